"""Adaptive steps: an error estimate for any implicit method, and a controller that changes the step seldom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import Segment
from tautflex.solvers.remembering import Memory
from tautflex.solvers.transient.driver import GridDriver, ImplicitStepper, Watch
from tautflex.solvers.transient.march.control import (
    KICKED,
    LEVEL,
    QUANTUM,
    SHARE,
    changed,
    choose_next,
    error_ratio,
    quantised,
)
from tautflex.solvers.transient.methods.scheme import Method, amplification
from tautflex.solvers.transient.state import MotionState, recalled_state


@dataclass(frozen=True)
class Adaptive:
    """Error control of the step size.

    Parameters
    ----------
    tolerance
        Allowed displacement error per unit of time over the largest velocity of the run so far, both in the mass norm
        ``sqrt(x' M x)``, which weighs translations and rotations by their inertia. For a harmonic motion and the
        trapezoidal rule it equals (angular frequency times step)^2 / 12: 1e-4 are 181 steps per period.
    min_step
        Smallest step [s]; default ``time_step / 4096``. Steps of this size are kept whatever their error, and counted.
    max_step
        Largest step [s]; default ``16 * time_step``.

    Raises
    ------
    InputError
        If a value is out of range or ``min_step`` exceeds ``max_step``.

    Notes
    -----
    The results stay on the grid of ``time_step``: between the ends of a step they follow the cubic that has the
    displacements and velocities of both [Hermite].
    """

    tolerance: float = 1e-4
    min_step: float | None = None
    max_step: float | None = None

    def __post_init__(self) -> None:
        checks.positive("adaptive.tolerance", self.tolerance)
        checks.between("adaptive.tolerance", self.tolerance, 0.0, 0.1, remedy="1e-4 is a usual choice")
        for name in ("min_step", "max_step"):
            if getattr(self, name) is not None:
                checks.positive(f"adaptive.{name}", getattr(self, name))
        if self.min_step is not None and self.max_step is not None and self.min_step > self.max_step:
            raise InputError(
                f"adaptive.min_step: expected at most max_step = {self.max_step:g} s, got {self.min_step:g}; swap them?"
            )

    def limits(self, time_step: float) -> tuple[float, float]:
        """Smallest and largest step [s] of a run whose grid is ``time_step``; InputError if they contradict."""
        low = time_step / 4096.0 if self.min_step is None else self.min_step
        high = max(16.0 * time_step, low) if self.max_step is None else self.max_step
        if low > high:
            raise InputError(
                f"adaptive.max_step: expected at least min_step = {low:g} s (default: time_step / 4096), got {high:g}; "
                "give min_step too"
            )
        return low, high


def error_constant(method: Method, phase: float = 0.1) -> float:
    """Local error of a method over ``(angular frequency * step)^3`` for an undamped oscillator.

    Parameters
    ----------
    method
        Implicit method.
    phase
        Angular frequency times step [rad].

    Returns
    -------
    float
        From the principal root of the method's amplification matrix at that phase, all stages of it, which should turn
        by ``exp(i phase)``; 1/12 for the trapezoidal rule. For a method of first order it grows like 1/phase.
    """
    roots = np.linalg.eigvals(amplification(method, phase))
    exact = np.exp(1j * phase)
    return float(np.abs(roots - exact).min()) / phase**3


class AdaptiveDriver(GridDriver):
    """Walks with steps of its own, lands on discontinuities and reports on the time grid.

    No step knows where the run will end: the last one may go a little beyond.

    Parameters
    ----------
    stepper
        Implicit stepper.
    segments
        Smooth stretches of the maneuver.
    step
        Spacing of the grid of results [s], and first trial step.
    control
        Tolerance and limits.
    watch
        Sees the start, the end and the segment of every accepted step.
    """

    MEMORY = ("_stepper", "_now", "_first", "_last_step", "_standing", "_fastest", "_kick")

    def __init__(
        self, stepper: ImplicitStepper, segments: tuple[Segment, ...], step: float, control: Adaptive,
        watch: Watch | None = None,
    ) -> None:  # fmt: skip
        super().__init__(stepper, segments, step, 0, watch)
        self._implicit, self._tolerance = stepper, control.tolerance
        self._smallest, self._largest = control.limits(step)
        self._constant = error_constant(stepper.method)
        self._now: MotionState | None = None
        self._first: MotionState | None = None
        self._last_step: list[MotionState] = []
        # What `choose_next` knows.
        self._standing = np.array([0.0, 0.0, step])
        self._try(min(step, self._largest))
        self._fastest = self._kick = np.zeros(1)

    def segment_at(self, time: float) -> Segment:
        """Stretch of the maneuver that an instant of the grid belongs to; the later one at a discontinuity."""
        slack = 1e-9 * self._step
        return next(segment for segment in reversed(self._segments) if segment.start <= time + slack)

    def advance(self, at: MotionState, target: float) -> MotionState | None:
        """State at a time of the grid, from the steps that enclose it; None if the smallest step fails."""
        slack = 1e-9 * self._step
        if self._now is None:
            self._now = at
            self._first = at
            self._note_velocity(at)
            # A run from rest has no velocity to compare with yet; what the first grid step will gain is a fair guess.
            self._kick = self._step * self._implicit.equation.pushes(at)
        while self._now.time < target - slack:
            reached = self._controlled_step(self._now, slack)
            if reached is None:
                return None
            # The state before a jump ends the step; the one behind it starts the next.
            self._last_step = [self._now, reached]
            self._now = self.last = self._enter_next_segment(reached, slack)
        if abs(self._now.time - target) <= slack:
            return self._now
        before, after = self._last_step
        return self._implicit.equation.between(before, after, target)

    def ahead(self, at: MotionState) -> MotionState:
        """State that the next step starts from, at or behind the instant of the grid."""
        return self._now or at

    def recall(self, memory: Memory) -> None:
        """Go on from where another driver stood."""
        super().recall(memory)
        kind = self._implicit.equation.kind
        if "_now" in memory:
            self._now, self._first = (recalled_state(kind, memory[name]) for name in ("_now", "_first"))
        self._last_step = [recalled_state(kind, part) for part in memory.get("_last_step", {}).values()]

    def control(self, size: float) -> tuple[Any, ...]:
        """Limits of steps of a size [s], and what `is_kept` keeps up to date."""
        assert self._first is not None
        kicked, share = self._first.time + self._step, self._constant * size
        limits = (self._step, self._smallest, self._largest, self._tolerance, size, share, kicked)
        return np.array(limits), self._standing, self._fastest, self._kick

    def stepped(self, before: MotionState, now: MotionState) -> None:
        """Go on behind steps that another has taken and counted, from the two ends of the last one."""
        self._last_step, self._now = [before, now], now
        self.last = now

    def _controlled_step(self, at: MotionState, slack: float) -> MotionState | None:
        """One accepted step, no longer than the segment has left."""
        left = self.segment.end - at.time
        while True:
            nominal = self.size
            size = _landing(nominal, left)
            # A landing may stretch the smallest step a little: it stays the smallest there is.
            smallest = min(size, nominal) <= self._smallest * (1.0 + 1e-9)
            reached = self._attempt(at, size)
            if reached is None:
                if smallest:
                    return None
                self._statistics.halvings += 1
                self._try(0.5 * size)
                continue
            ratio = self._error_ratio(at, reached, size)
            if ratio > 1.0 and not smallest:
                self._statistics.rejected += 1
                level = self._standing[LEVEL] - 1.0  # a landing may have stretched the step
                self._try(size * changed(ratio, -1.0))
                self._standing[LEVEL] = min(self._standing[LEVEL], level)
                continue
            self._statistics.beyond_tolerance += ratio > 1.0
            self._accept(at, reached)
            self._note_velocity(reached)
            choose_next(self._standing, self.control(size)[0], size, nominal, ratio)
            if abs(left - size) <= slack:
                reached.time = at.time + left
            return reached

    def _error_ratio(self, at: MotionState, reached: MotionState, size: float) -> float:
        """Estimated error of a step over the allowed one.

        The third derivative comes from the accelerations [Zienkiewicz & Xie, Earthq. Eng. Struct. Dyn. 20 (1991)
        871]; the constant is the method's own.
        """
        stepper, (limits, _, fastest, kick) = self._implicit, self.control(size)
        found = stepper.equation.errors(at, reached, limits[SHARE], lambda error: stepper.resolved(reached, error))
        speeds = stepper.equation.speeds(reached, self._first or at)
        return float(error_ratio(found, self._tolerance, fastest, speeds, kick, at.time < limits[KICKED]))

    def _note_velocity(self, at: MotionState) -> None:
        self._fastest = np.maximum(self._fastest, self._implicit.equation.speeds(at, self._first or at))

    @property
    def size(self) -> float:
        """Size of the next step [s], unless it lands."""
        return float(np.clip(self._step * QUANTUM ** self._standing[LEVEL], self._smallest, self._largest))

    def _try(self, size: float) -> None:
        """Take the next steps of a size [s], or as small as they may be."""
        self._standing[LEVEL] = quantised(max(size, self._smallest), self._step)


def _landing(size: float, left: float) -> float:
    """Step size that does not leave a sliver before an instant to land on."""
    if left <= 1.1 * size:
        return left
    return 0.5 * left if left < 2.0 * size else size
