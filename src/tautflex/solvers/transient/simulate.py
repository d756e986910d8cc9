"""Transient response: a method walks along a maneuver and leaves a record [paper (49), theory.md 4, 8]."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import fields
from inspect import Parameter, signature
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.interrupts import deferred, meet
from tautflex.mechanics.loads.inputs import InputSet, require_still
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver, RigidMotion, Segment, split_segments
from tautflex.numeric import Array, one_thread, within_arithmetic
from tautflex.solvers.remembering import Memory, copied, flat, nested
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.static.stability import find_start
from tautflex.solvers.transient.accuracy.between import doubts_about_inputs
from tautflex.solvers.transient.accuracy.energy import Energies, energies_at, energy_balance
from tautflex.solvers.transient.accuracy.time_error import TimeError
from tautflex.solvers.transient.accuracy.verdict import judge
from tautflex.solvers.transient.adaptive import AdaptiveDriver
from tautflex.solvers.transient.driver import AnyStepper, GridDriver, StagedStepper, Watch
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.free_hub.equation import HubEquation
from tautflex.solvers.transient.free_hub.motion import HubMotion
from tautflex.solvers.transient.free_hub.record import HubRecorder, check_coupling, steady_motion
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.march.adaptive_stretch import marching
from tautflex.solvers.transient.march.stretch import March
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import Progress, SteppingModel, TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.restart.checkpoint import Checkpoint, structure_of
from tautflex.solvers.transient.restart.keeper import Keeper, counted, in_memory, recounted
from tautflex.solvers.transient.state import MotionState, recalled_state
from tautflex.solvers.transient.status import Run, Statistics, Status


@within_arithmetic()
def simulate(
    state: PrestressedState | SteppingModel,
    maneuver: Maneuver | FreeHub | None = None,
    *,
    progress: Progress = None,
    throw: bool = True,
    keeper: Keeper | None = None,
    **question: Any,
) -> Run:
    """Integrate the rigid-flexible equation of motion (49) of the paper.

    Parameters
    ----------
    state, maneuver
        Prestressed state or reduced model, and its prescribed motion or `FreeHub`.
    progress
        Called with (fraction done, message), at most some hundred times, at least four times where there are steps.
    throw
        Raise when the run fails; False returns the labelled partial run.
    question
        ``time_step`` and ``end_time`` [s], ``method``, ``damping``, ``inputs``, ``probes``: name -> (x, y) [m], and all
        others of the signature; ``help(tf.TransientProblem)`` says what each means.

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
    solve = plant.solve if isinstance(plant, SteppingModel) else solve_full
    run = solve(problem, progress, keeper)
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


def solve_full(problem: TransientProblem, progress: Progress = None, keeper: Keeper | None = None) -> Run:
    """Answer of the full model; a step that fails is told by the status."""
    run, status = FullRun(problem, keeper), Status.COMPLETED
    first, count = problem.begin, problem.count
    with deferred(), one_thread():
        run.start()
        try:
            part = count - first if progress is None else run.between_calls(count - first)
            for number in [*range(first + part, count, part), count]:
                if not run.advance(number):
                    status = Status.NOT_CONVERGED
                    break
                if progress is not None and number > first:
                    progress((number - first) / (count - first), f"t = {run.at.time:.3g} s")
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
            run.keep()
        except InputError as error:  # a function of time that fails on the way
            run.keep()
            raise NotConvergedError(str(error), result=run.result(Status.NOT_CONVERGED)) from error
        return run.result(status)


class FullRun:
    """One run of the full model: its start, its steps, and what it leaves.

    Parameters
    ----------
    problem
        What was asked.
    keeper
        Keeps the run while it is under way, and may have kept one that goes on.

    Attributes
    ----------
    at
        State at the instant of the grid that the steps have come to.
    """

    at: MotionState

    def __init__(self, problem: TransientProblem, keeper: Keeper | None = None) -> None:
        self.problem, maneuver, self._keeper = problem, problem.maneuver, keeper
        driven = InputSet(problem.state.system, problem.inputs)
        parts = problem.state, problem.damping, problem.coupling
        self.equation: EquationOfMotion
        self.said: list[str] = [*problem.doubts, *doubts_about_inputs(driven, problem)]
        kind: type[Recorder] = Recorder
        if isinstance(maneuver, FreeHub):
            check_coupling(problem.coupling)
            require_still("on a free hub", problem.inputs)
            kind = HubRecorder
            self.equation = HubEquation(*parts, inputs=driven, hub=maneuver, probes=problem.placed)
            # The motion is not known beforehand.
            self.segments = split_segments(AtRest().segments(), (*driven.breaks, *maneuver.breaks))
        else:
            self.equation = EquationOfMotion(*parts, inputs=driven)
            self.segments = split_segments(maneuver.segments(), driven.breaks)
            self.said += driven.idle()
        self._stepper = _stepper(problem, self.equation)
        steps = problem.field_steps, problem.frame_steps
        moved = self.equation.moved
        placed = problem.placed if moved is None else problem.placed_on(moved.system)
        parts_of_record = self.equation, placed, len(problem.stored_steps), *steps
        self._recorder = kind(*parts_of_record, storage=in_memory if keeper is None else keeper.array)
        self._errors = TimeError(self.equation, self._stepper.resolved) if problem.time_error else None
        watch = None if self._errors is None else self._errors.step
        self._driver = _driver(problem, self._stepper, self.segments, watch)
        self._number, self._march = problem.begin, self._marching()
        # Where energies and errors began: of a run that goes on, in the earlier one.
        self._first: Energies | None = None
        self._largest, self._taken, self._inside = 0.0, 0, True
        self._began = clock.perf_counter()
        # Work of this run that another process did: factorizations, solutions, seconds.
        self._elsewhere = 0, 0, 0.0

    def between_calls(self, steps: int) -> int:
        """Steps between two calls of a callback: a hundredth of all, or those of a stretch, which is soon done."""
        return max(1, steps // 100, 0 if self._march is None else min(steps // 4, self._march.most))

    def start(self) -> None:
        """Start from the steady equilibrium, or go on from an earlier run."""
        problem, equation = self.problem, self.equation
        if self._keeper is not None and self._keeper.kept is not None:
            self._go_on(self._keeper.kept)
            return
        if problem.initial is None:
            self.at, found = begin(equation, problem.maneuver, problem.velocity, problem.initial_imperfection)
            self.said += found
            stress = equation.inputs.stress(self.at.time) if equation.inputs else {}
            dulling = self._stepper.dulling
            if stress and dulling and (pull := equation.workspace.added_force(self.at.q, stress)).any():
                self._stepper.prepare(self.at, problem.time_step, self._driver.segment)
                equation.set_time(self.at.time)
                self.at = equation.settled(self.at, pull, dulling)
        elif not (problem.initial.remembers(problem.memory_of) and self._recall(nested(problem.initial.memory))):
            self.at = self._from_motion(problem.initial)
        if self._first is None:
            self._first = self._energies(self.at)
            if isinstance(self._stepper, ExplicitStepper):
                self._stepper.check(self.at, problem.time_step)
        self._inside = False
        if problem.initial is None:
            self._record(0)

    def advance(self, number: int) -> bool:
        """Take the steps to an instant of the grid; whether they converged."""
        while self._number < number:
            meet()
            if self._keeper is not None and self._keeper.due():
                self.keep()
            self._inside, before = True, self._number
            if self._march is not None:
                self._number, self.at = self._march.take(self.at, before, number, self._driver.segment)
            if self._number > before:
                self._driver.last, self._inside = self._driver.ahead(self.at), False
                continue
            advanced = self._driver.advance(self.at, self.problem.instant(before + 1))
            if advanced is None:
                return False
            self.at, self._number, self._inside = advanced, before + 1, False
            self._record(self._number)
        return True

    def renew(self) -> None:
        """Meet a change of inputs that were set anew at the present instant: a jump as at the end of a segment."""
        motion = self._driver.segment.motion(self.at.time)
        if self.equation.restressed and self._stepper.dulling:
            self._stepper.prepare(self.at, self.problem.time_step, self._driver.segment)
        self.at = self.equation.jump(self.at, motion, motion, self._stepper.dulling)

    def strain_energy(self) -> float:
        """Strain energy of the present state under the inputs of its instant [J]."""
        self.equation.set_time(self.at.time)
        return self.equation.strain_energy(self.at.q)

    def motion(self) -> RigidMotion:
        """Motion of the floating frame at the present instant."""
        return self.equation.motion(self.at, self._driver.segment)

    def result(self, status: Status) -> Run:
        """What the run leaves."""
        problem, recorder, final = self.problem, self._recorder, self.checkpoint()
        statistics = self._statistics()
        ended = {"status": status.value, "status_message": status.message, "statistics": statistics.to_json()}
        data = recorder.to_dataset(problem.attributes | ended | {"warnings": self.said})
        last = self._driver.last or self.at
        # On a free hub the recorded kinetic energy is that of the whole spacecraft.
        stored, hub = data["strain_energy"].values, isinstance(problem.maneuver, FreeHub)
        energy = stored + (stored if hub else data["kinetic_energy"].values)
        self._largest = float(np.max(energy, initial=self._largest))
        assert self._first is not None
        balance = energy_balance(self._first, self._energies(last), last.books.work, hub)
        taken = max(self._taken + statistics.steps, 1)
        accuracy = judge(problem, self._errors, balance, self._largest, last.time / taken)
        data.attrs |= accuracy.attributes | {"warnings": data.attrs["warnings"] + accuracy.warnings}
        history = tuple(self._driver.failure) if status is Status.NOT_CONVERGED else ()
        return Run(data, status, statistics, self.at.time, history, accuracy.error, balance, final)

    def keep(self) -> None:
        """Let the keeper keep where the run stands, unless that is inside a step."""
        if self._keeper is not None and not self._inside:
            memory = {"number": self._number, "record": self._recorder.memory(), "mass": self.equation.mass_ready}
            memory |= counted(self._statistics(), self.said)
            evaluations = self.equation.statistics.force_evaluations
            memory["steps"] = self._memory()
            self.equation.statistics.force_evaluations = evaluations  # looking at the run is none of its work
            self._keeper.keep(self.at.time, flat(memory))

    def _go_on(self, kept: Mapping[str, Array]) -> None:
        """Go on where another process kept this run."""
        memory = nested(kept)
        recalled = self._recall(memory["steps"])
        assert recalled
        self._recorder.recall(memory["record"])
        self._number, self._inside = int(memory["number"]), False
        before, self.said = recounted(memory)
        if memory["mass"]:
            self.equation.mass_solve(np.zeros(self.equation.system.size))
        self._stepper.collect_counts()
        now = self.equation.statistics
        self._elsewhere = (
            before.factorizations - now.factorizations, before.back_substitutions - now.back_substitutions,
            before.seconds,
        )  # fmt: skip
        for item in fields(before):
            setattr(now, item.name, getattr(before, item.name))
        self._taken -= before.steps

    def _statistics(self) -> Statistics:
        """Work done so far."""
        self._stepper.collect_counts()
        statistics, (factorizations, solves, seconds) = self.equation.statistics, self._elsewhere
        statistics.factorizations += factorizations
        statistics.back_substitutions += solves
        statistics.seconds = clock.perf_counter() - self._began + seconds
        return statistics

    def checkpoint(self) -> Checkpoint:
        """State to go on from; without memory where a step was not finished."""
        at, problem = self.at, self.problem
        hub = at.rigid.copy() if isinstance(at, HubMotion) else np.zeros(0)
        structure, memory = structure_of(problem.state), {} if self._inside else flat(self._memory())
        return Checkpoint(at.time, at.q.copy(), at.v.copy(), hub, structure, problem.memory_of, memory)

    def _memory(self) -> Memory:
        ahead = self._driver.ahead(self.at)
        return {
            "at": copied(self.at),
            "driver": self._driver.memory(),
            "balance": self.equation.balance(ahead, self._driver.segment.motion(ahead.time)),
            "energies": copied(self._first),
            "largest": self._largest,
            "taken": self._taken + self.equation.statistics.steps,
            **({} if self._errors is None else {"errors": self._errors.memory()}),
        }

    def _recall(self, memory: Memory) -> bool:
        """Go on from the memory; False where steps that are ahead of the grid have met other forces."""
        driver = self._driver
        driver.recall(memory["driver"])
        self.at = recalled_state(self.equation.kind, memory["at"])
        ahead = driver.ahead(self.at)
        driver.enter(ahead)
        motion = driver.segment.motion(ahead.time)
        if ahead is self.at:
            self.at = self.equation.rebalanced(ahead, memory["balance"], motion, self._stepper.dulling)
        elif not np.array_equal(self.equation.balance(ahead, motion), memory["balance"]):
            # What was remembered belongs to these steps.
            self._stepper = _stepper(self.problem, self.equation)
            watch = None if self._errors is None else self._errors.step
            self._driver = _driver(self.problem, self._stepper, self.segments, watch)
            self._march = self._marching()
            return False
        self._first, self._largest, self._taken = Energies(**memory["energies"]), memory["largest"], memory["taken"]
        if self._errors is not None:
            self._errors.recall(memory.get("errors", {}))
        return True

    def _marching(self) -> March | None:
        return marching(self.problem, self.equation, self._stepper, self._recorder, self._errors, self._driver)

    def _from_motion(self, initial: Checkpoint) -> MotionState:
        """State of an earlier run's displacements and velocities alone, with the accelerations that follow."""
        at = MotionState(initial.time, initial.displacement.copy(), initial.velocity.copy(), np.zeros(0))
        self._driver.enter(at)
        return self.equation.start(at.time, at.q, at.v, self._driver.segment.motion(at.time), initial.hub)

    def _energies(self, at: MotionState) -> Energies:
        return energies_at(self.equation, self.problem.maneuver, self.segments, at)

    def _record(self, number: int) -> None:
        self._recorder.store_field(number, self.at.time, self.at.q)
        if number % self.problem.every == 0:
            self._recorder.store(self.at, self._driver.segment_at(self.at.time))


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
    return AdaptiveDriver(stepper, segments, step, problem.adaptive, watch)
