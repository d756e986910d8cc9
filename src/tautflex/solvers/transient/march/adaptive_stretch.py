"""Stretches of adaptive steps: those of one size, until their error asks for another."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array
from tautflex.solvers.transient.accuracy.time_error import TimeError
from tautflex.solvers.transient.adaptive import AdaptiveDriver
from tautflex.solvers.transient.driver import AnyStepper, GridDriver, ImplicitStepper
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.march.control import LEVEL
from tautflex.solvers.transient.march.sized import Sized
from tautflex.solvers.transient.march.stretch import LEAST_STEPS, March, rows, state_of
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.state import MotionState

# Sizes whose numbers are kept: a run uses few at a time, and each has as many as the matrices.
_SIZES = 6


class AdaptiveMarch(March):
    """Takes stretches of a run with adaptive steps.

    Parameters
    ----------
    problem, equation, stepper, recorder, errors
        See `March`.
    driver
        Takes the other steps; where it stands a stretch begins.
    """

    def __init__(
        self, problem: TransientProblem, equation: EquationOfMotion, stepper: ImplicitStepper, recorder: Recorder,
        errors: TimeError | None, driver: AdaptiveDriver,
    ) -> None:  # fmt: skip
        super().__init__(problem, equation, stepper, recorder, errors)
        self._driver, self._slack = driver, 1e-9 * problem.time_step
        self._sizes = {self._sized.size: self._sized}

    def take(self, at: MotionState, number: int, last: int, segment: Segment) -> tuple[int, MotionState]:
        """Take steps from where the driver stands; the instant of the grid that was reached, and its state.

        No step begins at the last instant or behind it.
        """
        driver = self._driver
        now = driver.ahead(at)
        if not now.time < self._problem.instant(number + 1) - self._slack:
            return number, at
        sized = self._of(driver.size)
        times = self._ends(now.time, last, sized, segment)
        may = len(times) > LEAST_STEPS and self._begins(now, now.time, sized, segment)
        tangent = self._stepper.tangent(now, sized.size, segment) if may else None
        if tangent is None:
            return number, at
        instants = sized.instants(times)
        ahead = self._outlook.at(instants[:, 0], segment.end)
        grid = _Grid(self._problem, times, number, last, self._slack)
        stress = self._outlook.stresses(times, instants, segment.end, grid.found)
        frame = segment.rows(instants[:, 0]), self._equation.frame, ahead.loads, ahead.which, stress
        fields, seen, nowhere = (
            np.empty((grid.kept.size, now.q.size)),
            np.empty((3, now.q.size)),
            np.full(grid.steps, -1),
        )
        control, beyond = driver.control(sized.size), np.zeros(1, dtype=np.int64)
        standing, level = control[1], control[1][LEVEL]
        taken, end, _, before = self._steps(
            now, sized, times, tangent, frame, None, (self._recorder.parts, nowhere, fields, nowhere),
            (*control, beyond, (*grid.parts(self._recorder.count), seen)),
        )  # fmt: skip
        same = self._stepper.took(taken, *tangent[4:]) and standing[LEVEL] == level
        if same and taken < grid.steps:
            self._left_out = float(times[taken])
        self._plan(grid.steps, taken)
        if not taken:
            return number, at
        self._equation.statistics.beyond_tolerance += int(beyond[0])
        reached = state_of(end, float(times[taken]), sized)
        driver.stepped(now if taken == 1 else state_of(before, float(times[taken - 1]), sized), reached)
        count, found = grid.reached(taken), grid.found
        stored = grid.stored[grid.stored < count]
        self._recorder.stored(segment.rows(found[stored]))
        for place, field in zip(grid.kept[grid.kept < count].tolist(), fields, strict=False):
            self._recorder.store_field(number + place + 1, float(found[place]), field)
        if not count:
            return number, at
        there = float(found[count - 1])
        return number + count, reached if there == reached.time else MotionState(there, *seen)

    def _of(self, size: float) -> Sized:
        """What steps of a size [s] know."""
        found = self._sizes.pop(size, None) or Sized(self._equation, self._stepper, size)
        self._sizes[size] = found
        if len(self._sizes) > _SIZES:
            del self._sizes[next(iter(self._sizes))]
        return found

    def _ends(self, begin: float, last: int, sized: Sized, segment: Segment) -> Array:
        """Instants of a stretch of plain steps from an instant [s], that one first."""
        times = sized.times(begin, self._length)
        starts = times[:-1]
        plain = (segment.end - starts >= 2.0 * sized.size) & (starts < self._problem.instant(last) - self._slack)
        return times[: 1 + (len(plain) if plain.all() else int(np.argmin(plain)))]


def marching(
    problem: TransientProblem, equation: EquationOfMotion, stepper: AnyStepper, recorder: Recorder,
    errors: TimeError | None, driver: GridDriver,
) -> March | None:  # fmt: skip
    """What takes stretches of a run; None where all steps are the driver's."""
    if isinstance(stepper, ExplicitStepper) or not March.serves(problem, equation, stepper):
        return None
    parts = problem, equation, stepper, recorder, errors
    return AdaptiveMarch(*parts, driver) if isinstance(driver, AdaptiveDriver) else March(*parts)


class _Grid:
    """Instants of the grid that steps between ``times`` reach, from the one behind ``number`` on.

    Attributes
    ----------
    steps
        Number of steps.
    found
        Instants [s], of those at the end of a step that end, shape (instant,).
    stored, kept
        Which of them samples and fields are stored of.
    """

    def __init__(self, problem: TransientProblem, times: Array, number: int, last: int, slack: float) -> None:
        self.steps, ends = len(times) - 1, times[1:]
        numbers = np.arange(number + 1, min(last, int((times[-1] - problem.shift) / problem.time_step) + 1) + 1)
        targets = problem.shift + problem.time_step * numbers
        step = np.searchsorted(ends, targets - slack)
        count = int(np.searchsorted(step, self.steps))
        step, targets, numbers = step[:count], targets[:count], numbers[:count]
        self._first = np.searchsorted(step, np.arange(self.steps + 1))
        self._ends = np.abs(ends[step] - targets) <= slack
        self.found = np.where(self._ends, ends[step], targets)
        self.stored = np.flatnonzero(numbers % problem.every == 0)
        self.kept = np.flatnonzero([n in problem.field_steps or n in problem.frame_steps for n in numbers.tolist()])

    def parts(self, first: int) -> tuple[Any, ...]:
        """What `record_between` reads, with the row of the first sample."""
        count = len(self.found)
        return self.found, self._first, self._ends, rows(count, self.stored, first), rows(count, self.kept, 0)

    def reached(self, taken: int) -> int:
        """How many instants so many steps reach."""
        return int(self._first[taken])
