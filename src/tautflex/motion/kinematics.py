"""Rigid motion of the floating frame as a sequence of smooth segments [theory.md 1, 4]."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array, cross_matrix


@dataclass(frozen=True)
class RigidMotion:
    """Motion of the floating frame at one instant, components in its own axes.

    Parameters
    ----------
    angular_velocity
        [rad/s], shape (3,).
    angular_acceleration
        [rad/s^2], shape (3,).
    origin_acceleration
        Acceleration of the frame's origin [m/s^2], shape (3,).
    """

    angular_velocity: Array
    angular_acceleration: Array
    origin_acceleration: Array

    @cached_property
    def euler(self) -> Array:
        """Matrix S(dw) of the Euler acceleration, shape (3, 3)."""
        return cross_matrix(self.angular_acceleration)

    @cached_property
    def centrifugal(self) -> Array:
        """Matrix S(w)^2 of the centrifugal acceleration, shape (3, 3)."""
        x, y, z = self.angular_velocity.tolist()
        # S(w)^2 = w w' - |w|^2, written out: it is asked for at every step of a maneuver.
        return np.array(
            ((-y * y - z * z, x * y, x * z), (x * y, -x * x - z * z, y * z), (x * z, y * z, -x * x - y * y))
        )

    @property
    def row(self) -> Array:
        """All three after one another, shape (9,)."""
        return np.concatenate([self.angular_velocity, self.angular_acceleration, self.origin_acceleration])


@dataclass(frozen=True)
class Segment:
    """Smooth stretch of a maneuver.

    Parameters
    ----------
    start, end
        Limits [s]; the last segment of a maneuver ends at infinity.
    motion
        Smooth function of time. Integrators may evaluate it slightly beyond ``end`` (Wilson-theta looks ahead), so
        it must continue analytically.
    many
        The same at many instants, number by number, as `rows` returns it; None: one after the other.
    """

    start: float
    end: float
    motion: Callable[[float], RigidMotion]
    many: Callable[[Array], Array] | None = None

    def rows(self, times: Array) -> Array:
        """Motions at instants [s], shape (n,): each a `RigidMotion.row`, shape (n, 9)."""
        if self.many is not None:
            return self.many(times)
        rows, last, row = np.empty((len(times), 9)), None, np.empty(0)
        for number, time in enumerate(times.tolist()):
            motion = self.motion(time)
            if motion is not last:
                last, row = motion, motion.row
            rows[number] = row
        return rows


def split_segments(segments: tuple[Segment, ...], breaks: Collection[float]) -> tuple[Segment, ...]:
    """Segments with further limits [s], where something else than the motion jumps; those at limits change nothing."""
    pieces = list[Segment]()
    for segment in segments:
        inside = sorted({instant for instant in breaks if segment.start < instant < segment.end})
        limits = pairwise((segment.start, *inside, segment.end))
        pieces.extend(replace(segment, start=start, end=end) for start, end in limits)
    return tuple(pieces)


class Maneuver(ABC):
    """Rigid motion of the frame: a steady start, then smooth segments that cover [0, infinity).

    Subclasses are frozen dataclasses, so that runs can name what they did, and check their values when made.
    """

    @abstractmethod
    def start(self) -> RigidMotion:
        """Steady motion before t = 0, where the run's equilibrium is computed."""

    @abstractmethod
    def segments(self) -> tuple[Segment, ...]:
        """Segments in order; neighbours share their limits, where the motion may jump."""

    @property
    def end(self) -> float:
        """Last instant where the motion may jump [s]; 0 if there is none."""
        return self.segments()[-1].start


@dataclass(frozen=True)
class AtRest(Maneuver):
    """No rigid motion at all: free vibration in an inertial frame."""

    def start(self) -> RigidMotion:
        """No motion."""
        return RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))

    def segments(self) -> tuple[Segment, ...]:
        """One segment without motion."""
        zero = self.start()
        return (Segment(0.0, np.inf, lambda time: zero),)


def unit_axis(axis: tuple[float, float, float]) -> Array:
    """Unit vector along ``axis``, shape (3,); InputError if it has no length."""
    vector = checks.vector3("axis", axis)
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise InputError("axis: expected a direction of non-zero length, got [0, 0, 0]; give for example [1, 0, 0]")
    return vector / length


def fixed_axis_motion(rate: float, acceleration: float, axis: Array, origin: Array) -> RigidMotion:
    """Rotation [rad/s, rad/s^2] about a fixed line: `motion_about_point` for a unit vector and a point that rests."""
    return motion_about_point(rate * axis, acceleration * axis, origin)


def motion_about_point(
    angular_velocity: Array, angular_acceleration: Array, origin: Array, acceleration: Array | None = None
) -> RigidMotion:
    """Rotation [rad/s, rad/s^2] about a point of the floating frame that rests, or accelerates on its own.

    ``origin`` is the point [m] and ``acceleration`` its own in the frame's axes [m/s^2], shapes (3,). The frame's
    origin is at ``-origin`` from the point, so a0 = acceleration - (S(dw) + S(w)^2) origin.
    """
    push = np.zeros(3) if acceleration is None else acceleration
    motion = RigidMotion(angular_velocity, angular_acceleration, push)
    if not origin.any():
        return motion
    return RigidMotion(angular_velocity, angular_acceleration, push - (motion.euler + motion.centrifugal) @ origin)
