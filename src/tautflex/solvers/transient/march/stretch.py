"""Stretches of a run that one compiled call takes: where they may begin, how far they go, and what they leave.

They save what a step costs in Python, half of it on a small antenna, and give the same numbers. A new tangent ends a
stretch, and the next begins with it; steps that something else happens in (a jump, a tangent that is too old within a
step) are left to the driver.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.store import ELASTIC, block_data
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
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.state import MotionState

# A call costs as much as a step and a half; it cannot be interrupted, and what is planned beyond a new tangent is lost.
_LEAST_STEPS, _FIRST_STEPS, _MOST_STEPS, _MOST_UNKNOWNS = 3, 16, 256, 500_000


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
        size = float(problem.time_step)
        count = len(stepper.method.stages(size))
        self._numbers = [self._stepper.numbers(size, place) for place in range(count)]
        shares = [numbers.share * size for numbers in self._numbers]
        self._reach = np.array([one.scheme.evaluation * part for one, part in zip(self._numbers, shares, strict=True)])
        self._parts, self._weighed = np.array(shares), self._numbers[0].scheme.weight < 1.0
        self._left_out = -1
        self._kept = np.array(sorted(problem.field_steps | problem.frame_steps), dtype=np.int64)
        self.most = max(1, min(_MOST_STEPS, _MOST_UNKNOWNS // equation.system.size))
        self._length = min(_FIRST_STEPS, self.most)
        products, workspace = equation.products, equation.workspace
        self._matrices: Any = (
            products.start, products.column, products.mass, products.damping, products.spread,
            np.array([one.linear for one in self._numbers]), equation.inertia.pairs, equation.state.reference_force,
            products.vectors, products.coefficients,
            np.array([products.coefficients * (one.scheme.weight * one.scheme.velocity.d) for one in self._numbers]),
        )  # fmt: skip
        self._elements: Any = workspace.store, workspace.stresses, workspace.held
        last = self._numbers[-1]
        # Of other laws than the elastic one energies cost more than forces: once per sample, not per evaluation.
        elastic = all(block_data.py_func(workspace.store, n).law == ELASTIC for n in range(len(workspace.store[3])))
        there = elastic and self._reach[-1] == shares[-1] and bool(np.array_equal(last.end[0], (1.0, 0.0, 0.0)))
        recalled = np.zeros((count, 2, count, 3))
        for place, one in enumerate(self._numbers):
            recalled[place, :, : one.recalled.shape[1]] = one.recalled
        turns = [(one.scheme.weight, one.turning_share, one.part) for one in self._numbers]
        sizes = np.array([(w, r, h, t, p) for (w, t, p), r, h in zip(turns, self._reach, shares, strict=True)])
        self._scheme: Any = (
            np.array([one.known for one in self._numbers]), np.array([one.end for one in self._numbers]), recalled,
            np.array([one.recalled.size > 0 for one in self._numbers]), sizes, there,
        )  # fmt: skip

    @staticmethod
    def serves(problem: TransientProblem, equation: EquationOfMotion, stepper: AnyStepper) -> bool:
        """Whether the steps of a run are such as it can take."""
        known = type(equation) in {EquationOfMotion, HubEquation} and problem.adaptive is None
        if not known or isinstance(stepper, ExplicitStepper) or stepper.only is None:
            return False
        first, *_ = stepper.method.stages(problem.time_step)
        return not first.velocity and (not equation.inputs or equation.inputs.all_loads)

    def take(self, at: MotionState, number: int, last: int, segment: Segment) -> tuple[int, MotionState]:
        """Take steps from an instant of the grid to the last one at most; the one that was reached, and its state.

        None are taken where the next step is the driver's.
        """
        times, size = self._times(at, number, last, segment), self._problem.time_step
        steps, every = len(times) - 1, self._problem.every
        begins = steps >= _LEAST_STEPS and not self._outlook.follows_motion and self._begins(at, number, segment)
        tangent = self._stepper.tangent(at, size, segment) if begins else None
        if tangent is None:
            return number, at
        on_hub, instants = isinstance(at, HubMotion), self._instants(times)
        ahead = self._outlook.at((instants if on_hub else instants[:, :1]).ravel(), segment.end)
        if on_hub:
            steps = ahead.known // (2 * len(self._parts))
        stored = np.arange(-(number + 1) % every, steps, every)
        kept = self._kept[slice(*np.searchsorted(self._kept, (number, number + steps), "right"))] - (number + 1)
        hub = self._hub(at, steps, ahead) if isinstance(at, HubMotion) else None
        motions = np.zeros((len(instants), 9)) if hub else segment.rows(instants[:, 0])
        frame: Any = motions, self._equation.frame, ahead.loads, ahead.which[:: 2 if hub else 1].copy()
        fields, books = np.empty((kept.size, at.q.size)), at.books
        samples: Any = self._recorder.parts, _rows(steps, stored, self._recorder.count), fields, _rows(steps, kept, 0)
        begin: Any = (
            at.q, at.v, at.a, at.jerk, np.zeros(0) if at.forces is None else at.forces, books.work, books.own,
            books.now, books.late,
        )  # fmt: skip
        taken, end, there = take_steps(
            times[: steps + 1], self._matrices, self._elements, self._scheme, *tangent[:3], frame, hub, *tangent[3:],
            begin, self._watched, self._errors.parts, samples,
        )  # fmt: skip
        if self._stepper.took(taken, *tangent[4:]) and taken < steps:
            self._left_out = number + taken
        self._length = min(max(_FIRST_STEPS, 2 * taken, self._length if taken == steps else 0), self.most)
        if not taken:
            return number, at
        (q, v, a, jerk, forces, *work), stored = end, stored[stored < taken]
        reached = MotionState(float(times[taken]), q, v, a, forces if self._weighed else None, jerk, books=Books(*work))
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

    def _instants(self, times: Array) -> Array:
        """Evaluation instant and end of every stage of steps between instants, one after the other, (stages, 2)."""
        found, begins = np.empty((len(times) - 1, len(self._parts), 2)), times[:-1]
        for place, (reach, part) in enumerate(zip(self._reach, self._parts, strict=True)):
            found[:, place, 0], found[:, place, 1] = begins + reach, begins + part
            begins = begins + part
        return found.reshape(-1, 2)

    def _hub(self, at: HubMotion, steps: int, ahead: Ahead) -> tuple[Any, ...]:
        """What `on_hub` tells of a free hub."""
        equation = self._equation
        assert isinstance(equation, HubEquation)
        factors = np.array([motion_factors(one.scheme) for one in self._numbers])
        wrenches = ahead.wrenches[: 2 * len(factors) * steps].reshape(-1, 2, 6)
        acts = wrenches, ahead.loads, ahead.outside, ahead.which.reshape(-1, 2)
        begins = at.rigid, at.true if self._weighed else np.zeros(0), np.array([at.power, at.work])
        return equation.body, equation.points, factors, *acts, *begins, np.empty((steps, 32))

    def _begins(self, at: MotionState, number: int, segment: Segment) -> bool:
        """Whether a stretch may begin: not behind a jump, nor where one has left a step."""
        behind_jump = at.jerk is None or not at.books.own.size
        known = not self._weighed or (at.forces is not None and at.books.now.size > 0)
        return number != self._left_out and known and not behind_jump and long_for(segment, self._problem.time_step)

    def _times(self, at: MotionState, number: int, last: int, segment: Segment) -> Array:
        """Instants of a stretch, from its start."""
        problem, count = self._problem, min(self._length, last - number)
        times: Array = problem.shift + problem.time_step * np.arange(number, number + count + 1.0)
        times[0], slack = at.time, 1e-9 * problem.time_step
        plain = (np.abs(times[1:] - times[:-1] - problem.time_step) < slack) & (times[1:] < segment.end - slack)
        return times[: 1 + (len(plain) if plain.all() else int(np.argmin(plain)))]


def _rows(steps: int, places: Indices, first: int) -> Indices:
    """Rows of the steps at these places, counted from the first; -1 for the others."""
    rows = np.full(steps, -1)
    rows[places] = np.arange(first, first + len(places))
    return rows
