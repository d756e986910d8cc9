"""Motion of a hub that is prescribed about one of its axes, step by step."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, UnsupportedError
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver, Segment
from tautflex.numeric import Array, Mask
from tautflex.reduction.marching.frame_terms import sample
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.text import shown

# Three Gauss points of an interval, and their weights: the angle is exact for rates of up to fifth degree.
_GAUSS = 0.5 + np.sqrt(0.15) * np.array([-1.0, 0.0, 1.0])
_WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0
# What two segments may differ by in their common rate, and an instant from a whole step.
_ROUND_OFF = 1e-9


def _moves(maneuver: Maneuver) -> Mask:
    """Axes about which a maneuver turns, and along which its origin is pushed, shape (6,)."""
    rows = [maneuver.start().row[None]]
    for segment in maneuver.segments():
        end = segment.end if np.isfinite(segment.end) else segment.start + 1.0
        rows.append(segment.rows(np.linspace(segment.start, end, 5)))
    spin, turn, push = np.concatenate(rows).any(axis=0).reshape(3, 3)
    return np.concatenate([spin | turn, push])


def is_course(maneuver: Maneuver, step: float) -> bool:
    """Whether compiled plants of a step [s] may be prescribed to move like this."""
    try:
        Course(maneuver, int(_moves(maneuver).argmax()), step)
    except (InputError, UnsupportedError):
        return False
    return True


class Course:
    """A maneuver about one axis in steps, from its start on.

    Parameters
    ----------
    maneuver
        The maneuver.
    axis
        Number of the axis.
    step
        Of the plant [s].

    Attributes
    ----------
    row
        Angle, rate and acceleration where it stands, and the acceleration behind that, where it may jump; shape (4,).

    Raises
    ------
    UnsupportedError
        If it turns about another axis, moves on, or its rate jumps.
    InputError
        If it jumps between two steps.
    """

    def __init__(self, maneuver: Maneuver, axis: int, step: float) -> None:
        if np.delete(_moves(maneuver), axis).any():
            raise _otherwise(maneuver, f"a maneuver about {'xyz'[axis]}, through the origin,")
        self._axis, self._step, self._at = axis, step, 0
        self._segments = maneuver.segments()
        first = self._motion(self._segments[0])(0.0)
        self.row = np.array([0.0, first[0], first[1], first[1]])
        self._ends, self._after = list[int](), list[float]()
        for one, other in pairwise(self._segments):
            end = one.end / step
            if abs(end - round(end)) > _ROUND_OFF * max(1.0, end):
                raise InputError(
                    f"maneuver: expected one that jumps at whole steps of {step:g} s in a compiled plant, got a jump "
                    f"at {one.end:.6g} s; set another duration or time_step, or use Plant"
                )
            before, after = self._motion(one)(one.end), self._motion(other)(one.end)
            if abs(after[0] - before[0]) > _ROUND_OFF * max(1.0, abs(before[0])):
                raise _otherwise(maneuver, "a maneuver whose rate does not jump")
            self._ends.append(round(end))
            self._after.append(float(after[1]))

    def _motion(self, segment: Segment) -> Callable[[float], Array]:
        """Rate and acceleration over time."""

        def at(time: float) -> Array:
            motion = segment.motion(time)
            return np.array([motion.angular_velocity[self._axis], motion.angular_acceleration[self._axis]])

        return at

    def take(self, count: int) -> Array:
        """Rows of the next steps, shape (count, 4): as `row`, each at its end."""
        found, first, angle = np.empty((count, 4)), self._at, self.row[0]
        limits = [0, *self._ends, first + count]
        for number, segment in enumerate(self._segments):
            low, high = max(limits[number], first), min(limits[number + 1], first + count)
            if low >= high:
                continue
            edges = self._step * np.arange(low, high + 1, dtype=float)
            inside = edges[:-1, None] + self._step * _GAUSS
            times = np.concatenate([edges[1:], inside.ravel()])
            values = sample(self._motion(segment), times, (edges[0], edges[-1], len(times)))
            values = np.broadcast_to(values, (len(times), 2))
            own = found[low - first : high - first]
            turned = self._step * (values[len(own) :, 0].reshape(-1, 3) @ _WEIGHTS)
            own[:, 0] = angle + np.cumsum(turned)
            own[:, 1:3], own[:, 3] = values[: len(own)], values[: len(own), 1]
            if high in self._ends:
                own[-1, 3] = self._after[bisect_right(self._ends, high) - 1]
            angle = own[-1, 0]
        self._at, self.row = first + count, found[-1]
        return found


class Prescribed:
    """Hub of a plant whose motion about one axis is given.

    Parameters
    ----------
    rom
        The reduced model.
    given
        Motion until another one is given; None is none.
    question
        Keywords of `TransientProblem`.

    Attributes
    ----------
    axis
        Number of the axis.
    hub
        Hub whose tables are those of the prescribed motion, too; its own inertia counts nothing.

    Raises
    ------
    UnsupportedError
        If the motion is no turn about one axis through the origin.
    InputError
        If the step is not stable, or the maneuver jumps between two steps.
    """

    def __init__(self, rom: ReducedModel, given: Maneuver | None, question: Mapping[str, Any]) -> None:
        self.maneuver = maneuver = _checked(given, AtRest())
        moves = _moves(maneuver)
        self.axis = int(moves[:3].argmax())
        if moves.sum() > 1 or moves[3:].any():
            raise _otherwise(maneuver, "a turn about one of the axes x, y and z, through the origin,")
        self.hub = FreeHub(1.0, (1.0, 1.0, 1.0), axes="xyz"[self.axis])
        self._run = ReducedRun(rom, TransientProblem.asked(rom, maneuver, question))
        self._run.start()
        self._step, self._courses = float(question["time_step"]), dict[int, Course]()

    def begin(self, plant: int, given: Maneuver | None) -> tuple[Array, Array]:
        """Begin with a maneuver, or the own one: equilibrium of the motion before it, shape (r,), and `Course.row`."""
        maneuver = _checked(given, self.maneuver)
        course = self._courses[plant] = Course(maneuver, self.axis, self._step)
        return self._run.beginning(maneuver.start()).equilibrium(), course.row

    def fill(self, plant: int, rows: Array) -> None:
        """Fill the next rows of a plant's course."""
        rows[:] = self._courses[plant].take(len(rows))


def require_no_motion_of(hub: FreeHub | None, maneuver: Maneuver | None) -> None:
    """Raise InputError where a free hub is given a motion."""
    if hub is not None and maneuver is not None:
        raise InputError(
            f"maneuver: expected none on a free hub, got {shown(maneuver)}; leave it out, run() takes what laws follow"
        )


def _checked(given: Maneuver | None, own: Maneuver) -> Maneuver:
    found: Maneuver = checks.instance("maneuver", own if given is None else given, Maneuver, "a maneuver, or None")
    return found


def _otherwise(maneuver: Maneuver, expected: str) -> UnsupportedError:
    return UnsupportedError(f"maneuver: expected {expected} in a compiled plant, got {shown(maneuver)}; use Plant")
