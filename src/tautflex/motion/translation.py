"""Translation of the frame without rotation: thrust, pulses, the end of a burn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment, unit_axis

BASE_ACCELERATION_PROFILES = ("constant", "half-sine", "cut-off")


@dataclass(frozen=True)
class BaseAcceleration(Maneuver):
    """Acceleration of the whole floating frame along a direction; acts as a uniform body force ``-rho a``.

    For an acceleration given as a table see `Tabulated`.

    Parameters
    ----------
    acceleration
        Acceleration, the largest one of a pulse [m/s^2].
    duration
        Time at which it ends [s], > 0; None: never (profile ``"constant"``).
    profile
        ``"constant"``: switched on at t = 0, off at ``duration``; ``"half-sine"``: the pulse
        ``acceleration sin(pi t/duration)``; ``"cut-off"``: steady before t = 0, where the structure is in equilibrium
        under it, and none from then on (no ``duration``).
    axis
        Direction in the floating frame.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    acceleration: float
    duration: float | None = None
    profile: str = "constant"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        checks.finite("acceleration", self.acceleration)
        checks.one_of("profile", self.profile, BASE_ACCELERATION_PROFILES)
        unit_axis(self.axis)
        if self.duration is not None:
            checks.positive("duration", self.duration)
        if self.profile == "half-sine" and self.duration is None:
            raise InputError("duration: missing, profile = 'half-sine' expects the length of the pulse [s]; add it")
        if self.profile == "cut-off" and self.duration is not None:
            raise InputError(
                f"duration: expected no value with profile = 'cut-off', got {self.duration!r}; "
                "the acceleration ends at t = 0"
            )

    def _push(self, acceleration: float) -> RigidMotion:
        return RigidMotion(np.zeros(3), np.zeros(3), acceleration * unit_axis(self.axis))

    def start(self) -> RigidMotion:
        """Steady acceleration before a cut-off, else none."""
        return self._push(self.acceleration if self.profile == "cut-off" else 0.0)

    def segments(self) -> tuple[Segment, ...]:
        """The acceleration, then none."""
        none, full = self._push(0.0), self._push(self.acceleration)
        if self.profile == "cut-off":
            return (Segment(0.0, np.inf, lambda time: none),)
        if self.duration is None:
            return (Segment(0.0, np.inf, lambda time: full),)
        duration = self.duration

        def pulse(time: float) -> RigidMotion:
            return self._push(self.acceleration * float(np.sin(np.pi * time / duration)))

        motion = pulse if self.profile == "half-sine" else lambda time: full
        return (Segment(0.0, duration, motion), Segment(duration, np.inf, lambda time: none))
