"""Stretches of a run that one compiled call takes: where they may begin, how far they go, and what they leave.

They save what a step costs in Python, half of it on a small antenna, and give the same numbers. A new tangent ends a
stretch, and the next begins with it; steps that something else happens in (a jump, a tangent that is too old within a
step) are left to the driver.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.loads.inputs import earlier
from tautflex.mechanics.store import ELASTIC, block_data
from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices
from tautflex.solvers.transient.accuracy.books import NONE, Books
from tautflex.solvers.transient.accuracy.time_error import TimeError, long_for
from tautflex.solvers.transient.driver import AnyStepper
from tautflex.solvers.transient.equation import EquationOfMotion, StepNumbers
from tautflex.solvers.transient.free_hub.equation import HubEquation, motion_factors
from tautflex.solvers.transient.free_hub.motion import HubMotion
from tautflex.solvers.transient.free_hub.record import HubRecorder
from tautflex.solvers.transient.implicit import Stepper
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
        self, problem: TransientProblem, equation: EquationOfMotion, stepper: Stepper, recorder: Recorder,
        errors: TimeError | None,
    ) -> None:  # fmt: skip
        self._problem, self._equation, self._stepper = problem, equation, stepper
        self._recorder, self._watched = recorder, errors is not None
        self._errors = TimeError(equation, stepper.resolved) if errors is None else errors
        self._numbers: StepNumbers = stepper.numbers(problem.time_step)
        self._left_out = -1
        self._kept = np.array(sorted(problem.field_steps | problem.frame_steps), dtype=np.int64)
        self.most = max(1, min(_MOST_STEPS, _MOST_UNKNOWNS // equation.system.size))
        self._length = min(_FIRST_STEPS, self.most)
        products, workspace = equation.products, equation.workspace
        self._matrices: Any = (
            products.start, products.column, products.mass, products.damping, products.spread, self._numbers.linear,
            equation.inertia.pairs, equation.state.reference_force, products.vectors, products.coefficients,
            products.coefficients * (self._numbers.scheme.weight * self._numbers.scheme.velocity.d),
        )  # fmt: skip
        self._elements: Any = workspace.store, workspace.stresses, workspace.held
        scheme, size = self._numbers.scheme, float(problem.time_step)
        reach, share = scheme.evaluation * size, self._numbers.turning_share
        # Of other laws than the elastic one energies cost more than forces: once per sample, not per evaluation.
        elastic = all(block_data.py_func(workspace.store, n).law == ELASTIC for n in range(len(workspace.store[3])))
        there = elastic and reach == size and bool(np.array_equal(self._numbers.end[0], (1.0, 0.0, 0.0)))
        self._scheme: Any = self._numbers.known, self._numbers.end, scheme.weight, reach, size, share, there

    @staticmethod
    def serves(problem: TransientProblem, equation: EquationOfMotion, stepper: AnyStepper) -> bool:
        """Whether the steps of a run are such as it can take."""
        if isinstance(equation, HubEquation):
            known = not (equation.hub.feedback or equation.inputs)
        else:
            known = type(equation) is EquationOfMotion
        if not known or not isinstance(stepper, Stepper) or problem.adaptive is not None:
            return False
        (stage, *_), method = stepper.method.stages(problem.time_step), stepper.method
        return not stage.velocity and not method.average_stress and (not equation.inputs or equation.inputs.all_loads)

    def take(self, at: MotionState, number: int, last: int, segment: Segment) -> tuple[int, MotionState]:
        """Take steps from an instant of the grid to the last one at most; the one that was reached, and its state.

        None are taken where the next step is the driver's.
        """
        times, size = self._times(at, number, last, segment), self._problem.time_step
        steps, every = len(times) - 1, self._problem.every
        begins = steps >= _LEAST_STEPS and self._begins(at, number, segment)
        tangent = self._stepper.tangent(at, size, segment) if begins else None
        if tangent is None:
            return number, at
        stored = np.arange(-(number + 1) % every, steps, every)
        kept = self._kept[slice(*np.searchsorted(self._kept, (number, number + steps), "right"))] - (number + 1)
        instants = times[:-1] + self._numbers.scheme.evaluation * size
        hub = self._hub(at, steps) if isinstance(at, HubMotion) else None
        motions = np.zeros((steps, 9)) if hub else segment.rows(instants)
        frame: Any = motions, self._equation.frame, *self._pushes(instants, segment.end)
        fields, books = np.empty((kept.size, at.q.size)), at.books
        samples: Any = self._recorder.parts, _rows(steps, stored, self._recorder.count), fields, _rows(steps, kept, 0)
        begin: Any = (
            at.q, at.v, at.a, at.jerk, np.zeros(0) if at.forces is None else at.forces, books.work, books.own,
            books.now, books.late,
        )  # fmt: skip
        taken, end, forces, work, late, true, power = take_steps(
            times, self._matrices, self._elements, self._scheme, *tangent[:3], frame, hub, *tangent[3:], begin,
            self._watched, self._errors.parts, samples,
        )  # fmt: skip
        if self._stepper.took(taken, *tangent[4:]) and taken < steps:
            self._left_out = number + taken
        self._length = min(max(_FIRST_STEPS, 2 * taken, self._length if taken == steps else 0), self.most)
        if not taken:
            return number, at
        weighed = self._numbers.scheme.weight < 1.0
        books = Books(work, end[4:9], end[9:] if weighed else NONE, late)
        (q, v, a, jerk), forces, stored = end[:4], forces if weighed else None, stored[stored < taken]
        reached = MotionState(float(times[taken]), q, v, a, forces, jerk, books=books)
        if hub and isinstance(self._recorder, HubRecorder):
            rigid, (now, done) = hub[6][taken - 1, :31].copy(), power.tolist()
            parts: dict[str, Any] = vars(reached) | {"rigid": rigid, "balanced": true, "power": now, "work": done}
            reached = HubMotion(**parts)
            self._recorder.stored_on_hub(hub[6][stored])
        else:
            self._recorder.stored(segment.rows(times[1 + stored]))
        for place, field in zip(kept[kept < taken].tolist(), fields, strict=False):
            self._recorder.store_field(number + place + 1, float(times[place + 1]), field)
        return number + taken, reached

    def _hub(self, at: HubMotion, steps: int) -> tuple[Any, ...]:
        """What `on_hub` tells of a free hub."""
        equation, scheme = self._equation, self._numbers.scheme
        assert isinstance(equation, HubEquation)
        wrench, true = equation.wrench(at.time, at.rigid, at.q, at.v), at.true if scheme.weight < 1.0 else np.zeros(0)
        begins = wrench, at.rigid, true, np.array([at.power, at.work])
        return equation.body, motion_factors(scheme), *begins, np.empty((steps, 32))

    def _begins(self, at: MotionState, number: int, segment: Segment) -> bool:
        """Whether a stretch may begin: not behind a jump, nor where one has left a step."""
        behind_jump = at.jerk is None or not at.books.own.size
        known = self._numbers.scheme.weight == 1.0 or (at.forces is not None and at.books.now.size > 0)
        return number != self._left_out and known and not behind_jump and long_for(segment, self._problem.time_step)

    def _pushes(self, instants: Array, before: float) -> tuple[Array, Indices]:
        """Different loads of the inputs at instants [s], a jump not met yet, and which one each of them has."""
        inputs, rows, which, last = self._equation.inputs, list[Array](), np.zeros(len(instants), dtype=np.int64), b""
        if not inputs:
            return np.zeros((1, self._equation.system.size)), which
        for number, instant in enumerate(instants.tolist()):
            values = inputs.each_value(earlier(instant, before))
            key = b"".join(value.tobytes() for value in values)
            if key != last:
                last = key
                rows.append(inputs.load_of(values))
            which[number] = len(rows) - 1
        return np.array(rows), which

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
