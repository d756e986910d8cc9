"""Adaptive steps: an error estimate for any implicit method, and a controller that changes the step seldom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import Segment
from tautflex.solvers.remembering import Memory
from tautflex.solvers.transient.driver import GridDriver, ImplicitStepper, Watch
from tautflex.solvers.transient.methods.scheme import Method, amplification
from tautflex.solvers.transient.state import MotionState, recalled_state

# Step sizes are time_step times powers of this, so that a size comes back and its factors with it.
_QUANTUM = np.sqrt(2.0)
# Share of an error that is still expected one step later: vibration passes through phases without any.
_MEMORY = 0.95
# Limits of one change, aim of the controller, and its exponents for an error of order h^2 [Gustafsson 1991].
_SMALLEST_FACTOR, _LARGEST_FACTOR, _AIM = 0.2, 2.0, 0.8
_INTEGRAL, _PROPORTIONAL = 0.7 / 2.0, 0.4 / 2.0


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

    MEMORY = ("_stepper", "_level", "_now", "_first", "_last_step", "_last_ratio", "_last_size", "_fastest", "_kick")

    def __init__(
        self, stepper: ImplicitStepper, segments: tuple[Segment, ...], step: float, control: Adaptive,
        watch: Watch | None = None,
    ) -> None:  # fmt: skip
        super().__init__(stepper, segments, step, 0, watch)
        self._implicit, self._control = stepper, control
        self._smallest, self._largest = control.limits(step)
        self._constant = error_constant(stepper.method)
        self._level = self._quantised(min(max(step, self._smallest), self._largest))
        self._now: MotionState | None = None
        self._first: MotionState | None = None
        self._last_step: list[MotionState] = []
        self._last_ratio, self._last_size = 0.0, step
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

    def _controlled_step(self, at: MotionState, slack: float) -> MotionState | None:
        """One accepted step, no longer than the segment has left."""
        left = self.segment.end - at.time
        while True:
            nominal = self._size
            size = _landing(nominal, left)
            # A landing may stretch the smallest step a little: it stays the smallest there is.
            smallest = min(size, nominal) <= self._smallest * (1.0 + 1e-9)
            reached = self._attempt(at, size)
            if reached is None:
                if smallest:
                    return None
                self._statistics.halvings += 1
                self._level = self._quantised(max(0.5 * size, self._smallest))
                continue
            ratio = self._error_ratio(at, reached, size)
            if ratio > 1.0 and not smallest:
                self._statistics.rejected += 1
                wanted = self._quantised(max(size * self._factor(ratio, None), self._smallest))
                self._level = min(wanted, self._level - 1)  # a landing may have stretched the step
                continue
            self._statistics.beyond_tolerance += ratio > 1.0
            self._accept(at, reached)
            self._note_velocity(reached)
            self._choose_next(size, nominal, ratio)
            if abs(left - size) <= slack:
                reached.time = at.time + left
            return reached

    def _error_ratio(self, at: MotionState, reached: MotionState, size: float) -> float:
        """Estimated error of a step over the allowed one.

        The third derivative comes from the accelerations [Zienkiewicz & Xie, Earthq. Eng. Struct. Dyn. 20 (1991)
        871]; the constant is the method's own.
        """
        share, stepper = self._constant * size, self._implicit
        found = stepper.equation.errors(at, reached, share, lambda error: stepper.resolved(reached, error))
        first = self._first or at
        fastest = np.maximum(self._fastest, stepper.equation.speeds(reached, first))
        if at.time < first.time + self._step:
            fastest = np.maximum(fastest, self._kick)
        ratio = np.divide(
            found, self._control.tolerance * fastest, out=np.full(found.size, np.inf), where=fastest > 0.0
        )
        return float(np.where(found > 0.0, ratio, 0.0).max())

    def _note_velocity(self, at: MotionState) -> None:
        self._fastest = np.maximum(self._fastest, self._implicit.equation.speeds(at, self._first or at))

    def _factor(self, ratio: float, last: float | None) -> float:
        """Change of the step size: proportional-integral control after a kept step, integral after a rejected one."""
        ratio = max(ratio, 1e-8)
        if last is None:
            factor = (_AIM / ratio) ** 0.5
        else:
            factor = (_AIM / ratio) ** _INTEGRAL * (last / ratio) ** _PROPORTIONAL
        return float(np.clip(factor, _SMALLEST_FACTOR, _LARGEST_FACTOR))

    def _choose_next(self, size: float, nominal: float, ratio: float) -> None:
        """Set the size of the next step; a step cut short at a landing says little about longer ones."""
        ratio = max(ratio, _MEMORY * self._last_ratio * (size / self._last_size) ** 2)
        factor = self._factor(ratio, self._last_ratio)
        self._last_ratio, self._last_size = max(ratio, 1e-4), size
        if size < 0.99 * nominal and size * factor < nominal:
            return
        wanted = self._quantised(min(size * factor, self._largest))
        # Up only by a whole quantum, down only where the next step would fail: the factors stay.
        if wanted > self._level or (wanted < self._level and ratio > 1.0 - 0.1):
            self._level = wanted

    @property
    def _size(self) -> float:
        return float(np.clip(self._step * _QUANTUM**self._level, self._smallest, self._largest))

    def _quantised(self, size: float) -> int:
        return int(np.floor(np.log(size / self._step) / np.log(_QUANTUM) + 1e-6))


def _landing(size: float, left: float) -> float:
    """Step size that does not leave a sliver before an instant to land on."""
    if left <= 1.1 * size:
        return left
    return 0.5 * left if left < 2.0 * size else size
