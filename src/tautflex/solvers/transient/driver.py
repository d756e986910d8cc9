"""Drivers: how steps follow the time grid, segments of the maneuver and failures, and stages make a step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array
from tautflex.solvers.nonlinear.newton import NewtonOutcome
from tautflex.solvers.remembering import Remembering
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.state import MotionState, Resolved
from tautflex.solvers.transient.step_kernel import recalled


class StagedStepper(Remembering):
    """Steps of several stages: one stepper for each effective stiffness, all of one equation of motion.

    Parameters
    ----------
    method
        Integrator.
    steppers
        One for each of the method's tangents, in order.
    """

    MEMORY = ("_steppers",)

    def __init__(self, method: Method, steppers: Sequence[Stepper]) -> None:
        self.method, self._numbers, self._steppers = method, method.tangents, list(steppers)
        self.equation = steppers[0].equation

    def step(self, at: MotionState, size: float, segment: Segment) -> tuple[MotionState, NewtonOutcome]:
        """Advance by all stages of a step; the outcome is that of the last one that was tried."""
        passed, reached = list[tuple[Array, ...]](), at
        for place, number in enumerate(self._numbers):
            stepper = self._steppers[number]
            passed.append((reached.q, reached.v, reached.a))
            factors = stepper.numbers(size, place).recalled
            known = recalled(factors, np.array(passed)) if factors.size else None
            reached, outcome = stepper.step(reached, size, segment, place, known)
            if not outcome.converged:
                break
        return reached, outcome

    @property
    def only(self) -> Stepper | None:
        """The stepper whose tangent serves all stages, if one does."""
        return self._steppers[0] if len(self._steppers) == 1 else None

    def prepare(self, at: MotionState, size: float, segment: Segment) -> None:
        """Factorize the last stage's tangent at a state unless there is one."""
        self._steppers[self._numbers[-1]].prepare(at, size, segment, len(self._numbers) - 1)

    def resolved(self, end: MotionState, error: Array) -> Array:
        """Part of a vector that the last stage resolves, shape (size,)."""
        return self._steppers[self._numbers[-1]].resolved(end, error)

    @property
    def dulling(self) -> Resolved | None:
        """That of the last stage, see `Stepper`."""
        return self._steppers[self._numbers[-1]].dulling

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(*(stepper.factor for stepper in self._steppers))


ImplicitStepper = Stepper | StagedStepper
AnyStepper = ImplicitStepper | ExplicitStepper
Watch = Callable[[MotionState, MotionState, Segment], None]


class GridDriver(Remembering):
    """Steps from one instant of the grid to the next, onto discontinuities, and halves steps that fail.

    Parameters
    ----------
    stepper
        Makes one step.
    segments
        Smooth stretches of the maneuver.
    step
        Nominal step [s].
    halvings
        Times a step may be halved.
    watch
        Sees the start, the end and the segment of every accepted step.

    Attributes
    ----------
    failure
        Residual norms of the last step that was tried.
    last
        State at the end of the last step, whatever instant of the grid was reached; None before the first.
    """

    MEMORY: ClassVar[tuple[str, ...]] = ("_stepper",)

    def __init__(
        self, stepper: AnyStepper, segments: tuple[Segment, ...], step: float, halvings: int, watch: Watch | None = None
    ) -> None:
        self._stepper, self._segments, self._step, self._halvings = stepper, segments, step, halvings
        self._watch = watch
        self._statistics = stepper.equation.statistics
        self._current = 0
        self.failure: list[float] = []
        self.last: MotionState | None = None

    @property
    def segment(self) -> Segment:
        """Stretch of the maneuver where the next step starts."""
        return self._segments[self._current]

    def segment_at(self, time: float) -> Segment:
        """Stretch of the maneuver at the last instant that `advance` reached."""
        return self.segment

    def advance(self, at: MotionState, target: float) -> MotionState | None:
        """Advance to a time of the grid; None if even the smallest step fails."""
        slack = 1e-9 * self._step
        while at.time < target - slack:
            end = min(target, self.segment.end)
            # Whole grid steps keep their nominal size, so that factors are re-used in spite of round-off.
            size = self._step if abs(end - at.time - self._step) < slack else end - at.time
            reached = self._halving_step(at, size, self._halvings)
            if reached is None:
                return None
            reached.time = end
            at = self.last = self._enter_next_segment(reached, slack)
        return at

    def enter(self, at: MotionState) -> None:
        """Go on from a state, behind the jump where a segment ends."""
        while self.segment.end <= at.time + 1e-9 * self._step and self._current + 1 < len(self._segments):
            self._current += 1

    def ahead(self, at: MotionState) -> MotionState:
        """State that the next step starts from, where `advance` reached ``at``."""
        return at

    def _enter_next_segment(self, at: MotionState, slack: float) -> MotionState:
        """Let the rigid motion jump where a segment ends."""
        if self.segment.end > at.time + slack or self._current + 1 == len(self._segments):
            return at
        before = self.segment.motion(at.time)
        self._current += 1
        return self._stepper.equation.jump(at, before, self.segment.motion(at.time), self._stepper.dulling)

    def _attempt(self, at: MotionState, size: float) -> MotionState | None:
        """One step of the stepper; None if it fails, as one does whose numbers overflow (see `within_arithmetic`)."""
        try:
            reached, outcome = self._stepper.step(at, size, self.segment)
        except (np.linalg.LinAlgError, FloatingPointError):
            return None
        self.failure = outcome.history
        return reached if outcome.converged else None

    def _accept(self, at: MotionState, reached: MotionState) -> None:
        self._statistics.steps += 1
        if self._watch is not None:
            self._watch(at, reached, self.segment)

    def _halving_step(self, at: MotionState, size: float, left: int) -> MotionState | None:
        reached = self._attempt(at, size)
        if reached is not None:
            self._accept(at, reached)
            return reached
        if left == 0:
            return None
        self._statistics.halvings += 1
        middle = self._halving_step(at, 0.5 * size, left - 1)
        return None if middle is None else self._halving_step(middle, 0.5 * size, left - 1)
