"""Transient response: a method walks along a maneuver and leaves a record [paper (49), theory.md 4, 8]."""

from __future__ import annotations

import time as clock
from inspect import Parameter, signature
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver, Segment, split_segments
from tautflex.numeric import Array, within_arithmetic
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.static.stability import find_start
from tautflex.solvers.transient.accuracy.between import doubts_about_inputs
from tautflex.solvers.transient.accuracy.energy import run_balance
from tautflex.solvers.transient.accuracy.time_error import TimeError
from tautflex.solvers.transient.accuracy.verdict import judge
from tautflex.solvers.transient.adaptive import AdaptiveDriver
from tautflex.solvers.transient.driver import AnyStepper, GridDriver, StagedStepper, Watch
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.free_hub.equation import HubEquation
from tautflex.solvers.transient.free_hub.record import HubRecorder, check_coupling, steady_motion
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import Progress, SteppingModel, TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.state import MotionState
from tautflex.solvers.transient.status import Run, Status


@within_arithmetic()
def simulate(
    state: PrestressedState | SteppingModel,
    maneuver: Maneuver | FreeHub | None = None,
    *,
    progress: Progress = None,
    throw: bool = True,
    **question: Any,
) -> Run:
    """Integrate the rigid-flexible equation of motion (49) of the paper.

    Parameters
    ----------
    state, maneuver
        Prestressed state or reduced model, and its prescribed motion or `FreeHub`.
    progress
        Called with (fraction done, message) about a hundred times.
    throw
        Raise when the run fails; False returns the labelled partial run.
    question
        ``time_step``, ``end_time`` and all other fields of `TransientProblem`, which says what they mean.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        If an argument is out of range, or the step of an explicit method is not stable.
    UnsupportedError
        If the structure could drift away as a rigid body under a maneuver, or the plant has no answer to the question.
    NotConvergedError
        If a step fails and ``throw`` is set; ``.result`` holds the partial run.
    """
    if progress is not None:
        checks.function("progress", progress, "fraction", "message")
    checks.flag("throw", throw)
    problem = TransientProblem.asked(state, maneuver, question)
    plant = problem.plant
    run = plant.solve(problem, progress) if isinstance(plant, SteppingModel) else solve_full(problem, progress)
    if run.status is Status.NOT_CONVERGED and throw:
        raise NotConvergedError(f"t = {run.reached:.6g} s: {run.status.message}", result=run, history=run.history)
    return run


# What `help` and editors show: the fields of the problem, written once, in the place of ``question``.
simulate.__signature__ = (_own := signature(simulate)).replace(  # type: ignore[attr-defined]
    parameters=[
        *(item for name, item in _own.parameters.items() if name in ("state", "maneuver")),
        *(item for item in signature(TransientProblem).parameters.values() if item.kind is Parameter.KEYWORD_ONLY),
        *(item for name, item in _own.parameters.items() if name in ("progress", "throw")),
    ]
)


def solve_full(problem: TransientProblem, progress: Progress = None) -> Run:
    """Answer of the full model; a step that fails is told by the status."""
    state, maneuver, step, count = problem.state, problem.maneuver, problem.time_step, problem.count
    driven = InputSet(state.system, problem.inputs)
    parts = state, problem.damping, problem.coupling
    equation: EquationOfMotion
    idle: list[str] = []
    kind: type[Recorder]
    if isinstance(maneuver, FreeHub):
        check_coupling(problem.coupling)
        equation, kind = HubEquation(*parts, inputs=driven, hub=maneuver, probes=problem.placed), HubRecorder
        # The motion is not known beforehand.
        segments = split_segments(AtRest().segments(), (*driven.breaks, *maneuver.breaks))
    else:
        equation, kind = EquationOfMotion(*parts, inputs=driven), Recorder
        segments, idle = split_segments(maneuver.segments(), driven.breaks), driven.idle()
    stepper = _stepper(problem, equation)
    recorder = kind(equation, problem.placed, count // problem.every + 1, problem.field_steps)
    errors = TimeError(equation, stepper.resolved) if problem.time_error else None
    driver = _driver(problem, stepper, segments, None if errors is None else errors.step)
    began = clock.perf_counter()
    status, history, reached, said = Status.COMPLETED, tuple[float, ...](), 0.0, list[str]()

    def record(number: int) -> None:
        recorder.store_field(number, at)
        if number % problem.every == 0:
            recorder.store(at, driver.segment_at(at.time))

    try:
        at, said = begin(equation, maneuver, problem.velocity, problem.initial_imperfection)
        first = at
        said = [*problem.doubts, *doubts_about_inputs(driven, problem), *idle, *said]
        if isinstance(stepper, ExplicitStepper):
            stepper.check(at, step)
        record(0)
        for number in range(1, count + 1):
            advanced = driver.advance(at, number * step)
            if advanced is None:
                status, history = Status.NOT_CONVERGED, tuple(driver.failure)
                break
            at, reached = advanced, advanced.time
            record(number)
            if progress is not None and number % max(1, count // 100) == 0:
                progress(number / count, f"t = {at.time:.3g} s")
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    stepper.collect_counts()
    statistics = equation.statistics
    statistics.seconds = clock.perf_counter() - began
    ended = {"status": status.value, "status_message": status.message, "statistics": statistics.to_json()}
    data, last = recorder.to_dataset(problem.attributes | ended | {"warnings": said}), driver.last or first
    # On a free hub the recorded kinetic energy is that of the whole spacecraft.
    stored, hub = data["strain_energy"].values, isinstance(maneuver, FreeHub)
    energy = float(np.max(stored + (stored if hub else data["kinetic_energy"].values)))
    balance = run_balance(equation, maneuver, segments, first, last)
    accuracy = judge(problem, errors, balance, energy, last.time / max(statistics.steps, 1))
    data.attrs |= accuracy.attributes | {"warnings": data.attrs["warnings"] + accuracy.warnings}
    return Run(data, status, statistics, reached, history, accuracy.error, balance)


def begin(
    equation: EquationOfMotion, maneuver: Maneuver | FreeHub, velocity: Array, imperfection: float = 0.0
) -> tuple[MotionState, list[str]]:
    """Start of a run: steady equilibrium, offset [m] and velocity, the accelerations that follow; and warnings."""
    if isinstance(maneuver, FreeHub):
        steady = first = steady_motion(maneuver, equation.inertia)
    else:
        steady, first = maneuver.start(), maneuver.segments()[0].motion(0.0)
    start = find_start(equation.state, steady, equation.coupling, equation.damping, imperfection)
    return equation.start(0.0, start.equilibrium + start.offset, velocity, first), start.warnings


def _stepper(problem: TransientProblem, equation: EquationOfMotion) -> AnyStepper:
    """Stepper of a run; an explicit method brings its own."""
    method, on_hub = problem.method, isinstance(equation, HubEquation)
    if not isinstance(method, Method):
        if on_hub:
            raise InputError("method: expected an implicit method on a free hub, got an explicit one; use Newmark()")
        return method.stepper(equation)
    tolerance = problem.tolerance or (min(1e-9, method.tolerance) if on_hub else method.tolerance)
    steppers = [Stepper(equation, method, tolerance) for _ in range(max(method.tangents) + 1)]
    return steppers[0] if len(method.tangents) == 1 else StagedStepper(method, steppers)


def _driver(
    problem: TransientProblem, stepper: AnyStepper, segments: tuple[Segment, ...], watch: Watch | None
) -> GridDriver:
    """Driver of a run."""
    step = problem.time_step
    if problem.adaptive is None:
        return GridDriver(stepper, segments, step, problem.max_halvings, watch)
    if isinstance(stepper, ExplicitStepper):
        raise InputError(
            "adaptive: expected an implicit method, got an explicit one, whose step is limited by stability; "
            "leave adaptive out or use GeneralizedAlpha()"
        )
    return AdaptiveDriver(stepper, segments, step, problem.count * step, problem.adaptive, watch)
