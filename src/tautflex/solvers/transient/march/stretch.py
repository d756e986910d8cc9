"""Stretches of a run that one compiled call takes: where they may begin, how far they go, and what they leave.

They save what a step costs in Python, half of it on a small antenna, and give the same numbers. A new tangent ends a
stretch, and the next begins with it; steps that something else happens in (a jump, a tangent that is too old within a
step) are left to the driver.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices
from tautflex.solvers.transient.accuracy.books import Books
from tautflex.solvers.transient.accuracy.time_error import TimeError, long_for
from tautflex.solvers.transient.driver import AnyStepper, ImplicitStepper
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.explicit import ExplicitStepper
from tautflex.solvers.transient.free_hub.equation import HubEquation, motion_factors
from tautflex.solvers.transient.free_hub.motion import HubMotion
from tautflex.solvers.transient.free_hub.record import HubRecorder
from tautflex.solvers.transient.march.ahead import Ahead, Outlook
from tautflex.solvers.transient.march.many_steps import take_steps
from tautflex.solvers.transient.march.sized import Sized
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.state import MotionState

# A call costs as much as a step and a half; it cannot be interrupted, and what is planned beyond a new tangent is lost.
LEAST_STEPS, _FIRST_STEPS, _MOST_STEPS, _MOST_UNKNOWNS = 3, 16, 256, 500_000


class March:
    """Takes stretches of a run.

    Parameters
    ----------
    problem
        What was asked.
    equation, stepper, recorder, errors
        Those of the run; ``errors`` is None where the time error is not estimated.

    Attributes
    ----------
    most
        Steps of the longest stretch.
    """

    def __init__(
        self, problem: TransientProblem, equation: EquationOfMotion, stepper: ImplicitStepper, recorder: Recorder,
        errors: TimeError | None,
    ) -> None:  # fmt: skip
        assert stepper.only is not None
        self._problem, self._equation, self._stepper = problem, equation, stepper.only
        self._outlook = Outlook(equation)
        self._recorder, self._watched = recorder, errors is not None
        self._errors = TimeError(equation, stepper.resolved) if errors is None else errors
        self._sized = Sized(equation, self._stepper, float(problem.time_step))
        self._left_out = -1.0
        self._kept = np.array(sorted(problem.field_steps | problem.frame_steps), dtype=np.int64)
        self.most = max(1, min(_MOST_STEPS, _MOST_UNKNOWNS // equation.system.size))
        self._length = min(_FIRST_STEPS, self.most)

    @staticmethod
    def serves(problem: TransientProblem, equation: EquationOfMotion, stepper: AnyStepper) -> bool:
        """Whether the steps of a run are such as it can take."""
        kinds = {EquationOfMotion, HubEquation} if problem.adaptive is None else {EquationOfMotion}
        known = type(equation) in kinds
        if not known or isinstance(stepper, ExplicitStepper) or stepper.only is None:
            return False
        first, *_ = stepper.method.stages(problem.time_step)
        return not first.velocity and (not equation.inputs or equation.inputs.all_fixed)

    def take(self, at: MotionState, number: int, last: int, segment: Segment) -> tuple[int, MotionState]:
        """Take steps from an instant of the grid to the last one at most; the one that was reached, and its state.

        None are taken where the next step is the driver's.
        """
        times, sized = self._times(at, number, last, segment), self._sized
        steps, every = len(times) - 1, self._problem.every
        begins = steps >= LEAST_STEPS and not self._outlook.follows_motion and self._begins(at, number, sized, segment)
        tangent = self._stepper.tangent(at, sized.size, segment) if begins else None
        if tangent is None:
            return number, at
        on_hub, instants = isinstance(at, HubMotion), sized.instants(times)
        ahead = self._outlook.at((instants if on_hub else instants[:, :1]).ravel(), segment.end)
        if on_hub:
            steps = ahead.known // (2 * len(sized.parts))
        stored = np.arange(-(number + 1) % every, steps, every)
        kept = self._kept[slice(*np.searchsorted(self._kept, (number, number + steps), "right"))] - (number + 1)
        hub = self._hub(at, steps, ahead) if isinstance(at, HubMotion) else None
        motions = np.zeros((len(instants), 9)) if hub else segment.rows(instants[:, 0])
        stress = self._outlook.stresses(times, instants, segment.end, times[1:])
        frame: Any = motions, self._equation.frame, ahead.loads, ahead.which[:: 2 if hub else 1].copy(), stress
        fields = np.empty((kept.size, at.q.size))
        samples: Any = self._recorder.parts, rows(steps, stored, self._recorder.count), fields, rows(steps, kept, 0)
        taken, end, there, _ = self._steps(at, sized, times[: steps + 1], tangent, frame, hub, samples)
        if self._stepper.took(taken, *tangent[4:]) and taken < steps:
            self._left_out = number + taken
        self._plan(steps, taken)
        if not taken:
            return number, at
        stored, reached = stored[stored < taken], state_of(end, float(times[taken]), sized)
        if hub and isinstance(self._recorder, HubRecorder):
            (rigid, true, power), hubs = there, hub[-1]
            now, done = power.tolist()
            parts: dict[str, Any] = vars(reached) | {"rigid": rigid, "balanced": true, "power": now, "work": done}
            reached = HubMotion(**parts)
            self._recorder.stored_on_hub(hubs[stored])
        else:
            self._recorder.stored(segment.rows(times[1 + stored]))
        for place, field in zip(kept[kept < taken].tolist(), fields, strict=False):
            self._recorder.store_field(number + place + 1, float(times[place + 1]), field)
        return number + taken, reached

    def _steps(
        self, at: MotionState, sized: Sized, times: Array, tangent: Any, frame: Any, hub: Any, samples: Any,
        control: Any = None,
    ) -> Any:  # fmt: skip
        """Call `take_steps` from a state."""
        books, forces = at.books, np.zeros(0) if at.forces is None else at.forces
        begin = at.q, at.v, at.a, at.jerk, forces, books.work, books.own, books.now, books.late
        # Stresses that change are others at the sample than at the last evaluation.
        scheme = sized.scheme if frame[4] is None else (*sized.scheme[:-1], False)
        parts = sized.matrices, sized.elements, scheme
        watch = self._watched, self._errors.parts
        return take_steps(times, *parts, *tangent[:3], frame, hub, *tangent[3:], begin, *watch, samples, control)

    def _plan(self, steps: int, taken: int) -> None:
        """Choose how many steps the next stretch is to have."""
        self._length = min(max(_FIRST_STEPS, 2 * taken, self._length if taken == steps else 0), self.most)

    def _hub(self, at: HubMotion, steps: int, ahead: Ahead) -> tuple[Any, ...]:
        """What `on_hub` tells of a free hub."""
        equation = self._equation
        assert isinstance(equation, HubEquation)
        factors = np.array([motion_factors(one.scheme) for one in self._sized.numbers])
        wrenches = ahead.wrenches[: 2 * len(factors) * steps].reshape(-1, 2, 6)
        acts = wrenches, ahead.loads, ahead.outside, ahead.which.reshape(-1, 2)
        begins = at.rigid, at.true if self._sized.weighed else np.zeros(0), np.array([at.power, at.work])
        return equation.body, equation.points, factors, *acts, *begins, np.empty((steps, 32))

    def _begins(self, at: MotionState, mark: float, sized: Sized, segment: Segment) -> bool:
        """Whether a stretch may begin: not behind a jump, nor where one has left a step."""
        behind_jump = at.jerk is None or not at.books.own.size
        known = not sized.weighed or (at.forces is not None and at.books.now.size > 0)
        return mark != self._left_out and known and not behind_jump and long_for(segment, sized.size)

    def _times(self, at: MotionState, number: int, last: int, segment: Segment) -> Array:
        """Instants of a stretch, from its start."""
        problem, count = self._problem, min(self._length, last - number)
        times: Array = problem.shift + problem.time_step * np.arange(number, number + count + 1.0)
        times[0], slack = at.time, 1e-9 * problem.time_step
        plain = (np.abs(times[1:] - times[:-1] - problem.time_step) < slack) & (times[1:] < segment.end - slack)
        return times[: 1 + (len(plain) if plain.all() else int(np.argmin(plain)))]


def state_of(parts: Any, time: float, sized: Sized) -> MotionState:
    """State at an instant [s] from what `take_steps` gives."""
    q, v, a, jerk, forces, *books = parts
    return MotionState(time, q, v, a, forces if sized.weighed else None, jerk, books=Books(*books))


def rows(steps: int, places: Indices, first: int) -> Indices:
    """Rows of the steps at these places, counted from the first; -1 for the others."""
    found = np.full(steps, -1)
    found[places] = np.arange(first, first + len(places))
    return found
