"""Maneuvers: small frozen classes that give the rigid motion as smooth segments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import RigidMotion, Segment, fixed_axis_motion

Array = NDArray[np.float64]


def unit_axis(axis: tuple[float, float, float]) -> Array:
    """Unit vector along ``axis``, shape (3,); InputError if it has no length."""
    vector = checks.vector3("axis", axis)
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise InputError("axis: expected a direction of non-zero length, got [0, 0, 0]; give for example [1, 0, 0]")
    return vector / length


@dataclass(frozen=True)
class AtRest:
    """No rigid motion at all: free vibration in an inertial frame."""

    def start(self) -> RigidMotion:
        """No motion."""
        return RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))

    def segments(self) -> tuple[Segment, ...]:
        """One segment without motion."""
        zero = self.start()
        return (Segment(0.0, np.inf, lambda time: zero),)


@dataclass(frozen=True)
class Stop:
    """Steady spin stopped at constant deceleration [paper sec. 3]: w = rate (1 - t/duration), then rest.

    Parameters
    ----------
    rate
        Angular velocity before t = 0 [rad/s].
    duration
        Time to stop [s], > 0.
    axis
        Direction of the rotation axis in the floating frame.
    origin
        A point on the axis [m].

    Raises
    ------
    InputError
        If a value is out of range.
    """

    rate: float
    duration: float
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        checks.finite("rate", self.rate)
        checks.positive("duration", self.duration)
        unit_axis(self.axis)
        checks.vector3("origin", self.origin)

    def start(self) -> RigidMotion:
        """Steady spin at ``rate``."""
        return fixed_axis_motion(self.rate, 0.0, unit_axis(self.axis), np.asarray(self.origin, dtype=float))

    def segments(self) -> tuple[Segment, ...]:
        """Braking, then rest."""
        axis, origin = unit_axis(self.axis), np.asarray(self.origin, dtype=float)
        slope = -self.rate / self.duration

        def braking(time: float) -> RigidMotion:
            return fixed_axis_motion(self.rate + slope * time, slope, axis, origin)

        rest = fixed_axis_motion(0.0, 0.0, axis, origin)
        return (Segment(0.0, self.duration, braking), Segment(self.duration, np.inf, lambda time: rest))
