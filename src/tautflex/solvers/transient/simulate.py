"""Transient response: a method walks along a maneuver and leaves a record [paper (49), theory.md 4, 8]."""

from __future__ import annotations

import time as clock
from inspect import Parameter, signature
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.errors import InputError, NotConvergedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import Maneuver, Segment, split_segments
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.adaptive import AdaptiveDriver
from tautflex.solvers.transient.driver import GridDriver, StagedStepper
from tautflex.solvers.transient.equation import EquationOfMotion, MotionState
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.free_hub.history import HubFlight, check_coupling
from tautflex.solvers.transient.free_hub.stepper import HubStepper
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.methods.scheme import Method, OneStageMethod
from tautflex.solvers.transient.problem import Progress, SteppingModel, TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.status import Run, Status

Array = NDArray[np.float64]
AnyStepper = Stepper | StagedStepper | ExplicitStepper


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
    equation = EquationOfMotion(state, problem.damping, problem.coupling, inputs=driven)
    flight: _Flight | HubFlight
    stepper: AnyStepper | HubStepper
    if isinstance(maneuver, FreeHub):
        check_coupling(problem.coupling)
        stepper = hub_stepper = _hub_stepper(problem, maneuver, equation)
        flight = HubFlight(state, maneuver, hub_stepper)
        segments = split_segments(flight.segments(), (*driven.breaks, *maneuver.breaks))
    else:
        stepper = prescribed = _stepper(problem, equation)
        flight = _Flight(state, maneuver, prescribed, problem.coupling)
        segments = split_segments(maneuver.segments(), driven.breaks)
    samples = count // problem.every + 1
    recorder = Recorder(state.system, equation.workspace, problem.placed, samples, problem.field_steps)
    driver = _driver(problem, stepper, segments)
    began = clock.perf_counter()
    status, history, reached = Status.COMPLETED, tuple[float, ...](), 0.0
    try:
        at = flight.start(problem.velocity)
        if isinstance(stepper, ExplicitStepper):
            stepper.check(at, step)
        flight.record(recorder, driver, at, 0, problem.every)
        for number in range(1, count + 1):
            advanced = driver.advance(at, number * step)
            if advanced is None:
                status, history = Status.NOT_CONVERGED, tuple(driver.failure)
                break
            at, reached = advanced, advanced.time
            flight.record(recorder, driver, at, number, problem.every)
            if progress is not None and number % max(1, count // 100) == 0:
                progress(number / count, f"t = {at.time:.3g} s")
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    stepper.collect_counts()
    statistics = equation.statistics
    statistics.seconds = clock.perf_counter() - began
    ended = {"status": status.value, "status_message": status.message, "statistics": statistics.to_json()}
    data = flight.complete(recorder.to_dataset(problem.attributes | ended))
    return Run(data, status, statistics, reached, history)


def _stepper(problem: TransientProblem, equation: EquationOfMotion) -> AnyStepper:
    """Stepper of a run under prescribed motion; an explicit method brings its own."""
    method = problem.method
    if not isinstance(method, Method):
        return method.stepper(equation)
    tolerance = problem.tolerance or method.tolerance
    steppers = [
        Stepper(problem.state, method, problem.damping, problem.coupling, tolerance, shared=equation)
        for _ in range(max(method.tangents) + 1)
    ]
    return steppers[0] if len(method.tangents) == 1 else StagedStepper(method, steppers)


def _hub_stepper(problem: TransientProblem, hub: FreeHub, equation: EquationOfMotion) -> HubStepper:
    """Stepper of a run on a free hub."""
    method = problem.method
    if not isinstance(method, OneStageMethod):
        kind = "one of several stages" if isinstance(method, Method) else "an explicit one"
        raise InputError(f"method: expected an implicit method of one stage on a free hub, got {kind}; use Newmark()")
    return HubStepper(equation, hub, method, problem.tolerance or min(1e-9, method.tolerance), problem.placed)


def _driver(problem: TransientProblem, stepper: AnyStepper | HubStepper, segments: tuple[Segment, ...]) -> GridDriver:
    """Driver of a run."""
    step = problem.time_step
    if problem.adaptive is None:
        return GridDriver(stepper, segments, step, problem.max_halvings)
    if isinstance(stepper, ExplicitStepper):
        raise InputError(
            "adaptive: expected an implicit method, got an explicit one, whose step is limited by stability; "
            "leave adaptive out or use GeneralizedAlpha()"
        )
    if isinstance(stepper, HubStepper):
        raise InputError("adaptive: expected None on a free hub, got error control; leave adaptive out")
    return AdaptiveDriver(stepper, segments, step, problem.count * step, problem.adaptive)


class _Flight:
    """A run under prescribed rigid motion: its start and its record."""

    def __init__(self, state: PrestressedState, maneuver: Maneuver, stepper: AnyStepper, coupling: Coupling) -> None:
        self._state, self._maneuver, self._stepper, self._coupling = state, maneuver, stepper, coupling

    def start(self, velocity: Array) -> MotionState:
        """Steady spinning equilibrium, given velocity, and the acceleration that follows."""
        q = spinning_equilibrium(self._state, self._maneuver.start(), self._coupling)
        return self._stepper.start(0.0, q, velocity, self._maneuver.segments()[0].motion(0.0))

    def record(self, recorder: Recorder, driver: GridDriver, at: MotionState, step: int, every: int) -> None:
        """Store the sample and the field of a grid step."""
        recorder.store_field(step, at.time, at.q)
        if step % every:
            return
        equation = self._stepper.equation
        equation.set_time(at.time)
        energy = equation.workspace.strain_energy(at.q)
        kinetic = 0.5 * equation.products.mass_norm(at.v)
        motion = driver.segment_at(at.time).motion(at.time)
        strain = energy - float(self._state.reference_force @ at.q)
        recorder.store(at.time, at.q, at.v, motion, kinetic, strain)

    def complete(self, data: xr.Dataset) -> xr.Dataset:
        """Nothing to add."""
        return data
