"""Rotations about a fixed axis from one steady state to another: slews and spin-ups."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import RigidMotion, Segment, fixed_axis_motion
from tautflex.motion.maneuvers import unit_axis
from tautflex.motion.profiles import Piece, unit_step
from tautflex.motion.shaping import convolved, shaper_impulses

Array = NDArray[np.float64]

SLEW_PROFILES = ("versine", "bang-bang", "minimum-jerk", "input-shaped")
BASE_PROFILES = ("bang-bang", "versine", "minimum-jerk")
SHAPING = ("frequency", "damping_ratio", "shaper", "base")
SPIN_PROFILES = ("versine", "linear", "minimum-jerk")


@dataclass(frozen=True)
class Slew:
    """Turn by an angle from rest to rest.

    Parameters
    ----------
    angle
        Angle of the turn [rad], of any sign.
    duration
        Time from the first to the last moment of motion [s], > 0; it includes the delays of an input shaper.
    profile
        ``"versine"``: ``angle (t/T - sin(2 pi t/T)/(2 pi))``, continuous acceleration; ``"bang-bang"``: constant
        acceleration of one sign, then of the other, the fastest turn with bounded torque; ``"minimum-jerk"``:
        ``angle (10 s^3 - 15 s^4 + 6 s^5)``, s = t/T, continuous acceleration; ``"input-shaped"``: delayed copies of
        ``base`` whose vibrations of the mode with ``frequency`` cancel each other.
    axis
        Direction of the rotation axis in the floating frame.
    origin
        A point on the axis [m].
    frequency, damping_ratio
        Natural frequency [Hz] and damping ratio of the mode to leave at rest (input-shaped only).
    shaper
        ``"ZVD"`` (robust, takes a period) or ``"ZV"`` (takes half of one), see `shaper_impulses`.
    base
        ``"bang-bang"``, ``"versine"`` or ``"minimum-jerk"``: what the shaper copies; it lasts ``duration`` less
        the shaper's longest delay.

    Raises
    ------
    InputError
        If a value is out of range, or the duration is too short for the shaper.
    """

    angle: float
    duration: float
    profile: str = "versine"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frequency: float | None = field(default=None, kw_only=True)
    damping_ratio: float = field(default=0.0, kw_only=True)
    shaper: str = field(default="ZVD", kw_only=True)
    base: str = field(default="bang-bang", kw_only=True)

    def __post_init__(self) -> None:
        checks.finite("angle", self.angle)
        checks.positive("duration", self.duration)
        checks.one_of("profile", self.profile, SLEW_PROFILES)
        checks.one_of("base", self.base, BASE_PROFILES)
        unit_axis(self.axis)
        checks.vector3("origin", self.origin)
        if self.profile == "input-shaped" and self.frequency is None:
            raise InputError(
                "frequency: missing, profile = 'input-shaped' expects the mode's natural frequency [Hz]; "
                "add it, `tautflex modes` and solve_modes(state).frequencies list them"
            )
        for one in fields(self):
            value = getattr(self, one.name)
            if self.profile != "input-shaped" and one.name in SHAPING and value != one.default:
                raise InputError(
                    f"{one.name}: expected no value with profile = {self.profile!r}, got {value!r}; "
                    "set profile = 'input-shaped'"
                )
        self.steps()

    def steps(self) -> tuple[Piece, ...]:
        """Angle over ``angle`` and its derivatives, in smooth stretches that cover [0, duration]."""
        if self.frequency is None:
            return unit_step(self.profile, self.duration)
        impulses = shaper_impulses(self.shaper, self.frequency, self.damping_ratio)
        delay = impulses[-1][1]
        if not self.duration > delay:
            raise InputError(
                f"duration: expected more than the {delay:g} s that the {self.shaper} shaper of a mode at "
                f"{self.frequency:g} Hz takes, got {self.duration:g} s; turn more slowly or take the shaper 'ZV'"
            )
        return convolved(unit_step(self.base, self.duration - delay), impulses)

    def start(self) -> RigidMotion:
        """Rest."""
        return fixed_axis_motion(0.0, 0.0, unit_axis(self.axis), np.asarray(self.origin, dtype=float))

    def segments(self) -> tuple[Segment, ...]:
        """The turn, then rest."""
        axis, origin = unit_axis(self.axis), np.asarray(self.origin, dtype=float)

        def turning(piece: Piece) -> Segment:
            def motion(time: float) -> RigidMotion:
                _, rate, acceleration = piece.values(time)
                return fixed_axis_motion(self.angle * rate, self.angle * acceleration, axis, origin)

            return Segment(piece.start, piece.end, motion)

        turn, rest = tuple(turning(piece) for piece in self.steps()), self.start()
        return (*turn, Segment(turn[-1].end, np.inf, lambda time: rest))


@dataclass(frozen=True)
class SpinUp:
    """Change of a steady spin, from rest unless an initial rate is given.

    Parameters
    ----------
    rate
        Angular velocity to reach, from ``duration`` on [rad/s].
    duration
        Length of the change [s], > 0.
    profile
        Course of the angular velocity: ``"versine"``, ``rate (t/T - sin(2 pi t/T)/(2 pi))`` [Kane, Ryan & Banerjee
        1987], continuous acceleration; ``"linear"``, constant acceleration; ``"minimum-jerk"``.
    axis
        Direction of the rotation axis in the floating frame.
    origin
        A point on the axis [m].
    initial_rate
        Angular velocity before t = 0 [rad/s].

    Raises
    ------
    InputError
        If a value is out of range.
    """

    rate: float
    duration: float
    profile: str = "versine"
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    initial_rate: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        checks.finite("rate", self.rate)
        checks.positive("duration", self.duration)
        checks.one_of("profile", self.profile, SPIN_PROFILES)
        unit_axis(self.axis)
        checks.vector3("origin", self.origin)
        checks.finite("initial_rate", self.initial_rate)

    def _steady(self, rate: float) -> RigidMotion:
        return fixed_axis_motion(rate, 0.0, unit_axis(self.axis), np.asarray(self.origin, dtype=float))

    def start(self) -> RigidMotion:
        """Steady spin at the initial rate."""
        return self._steady(self.initial_rate)

    def segments(self) -> tuple[Segment, ...]:
        """The change, then steady spin at ``rate``."""
        axis, origin = unit_axis(self.axis), np.asarray(self.origin, dtype=float)
        change = self.rate - self.initial_rate
        (piece,) = unit_step(self.profile, self.duration)

        def motion(time: float) -> RigidMotion:
            value, slope, _ = piece.values(time)
            return fixed_axis_motion(self.initial_rate + change * value, change * slope, axis, origin)

        after = self._steady(self.rate)
        return (Segment(0.0, self.duration, motion), Segment(self.duration, np.inf, lambda time: after))
