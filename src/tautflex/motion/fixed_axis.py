"""Rotations about a fixed line from one steady state to another: stops, spin-ups and slews, all one formula."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from itertools import pairwise
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment, fixed_axis_motion, unit_axis
from tautflex.motion.profiles import Impulses, UnitStep
from tautflex.motion.shaping import SHAPERS, impulse_train, shaper_impulses
from tautflex.numeric import Array

SLEW_PROFILES = ("versine", "bang-bang", "minimum-jerk", "input-shaped")
BASE_PROFILES = ("bang-bang", "versine", "minimum-jerk")
SHAPING = ("frequency", "damping_ratio", "shaper", "base")
SPIN_PROFILES = ("versine", "linear", "minimum-jerk")


@dataclass(frozen=True)
class RateFormula:
    """Angular rate over time: ``before + change d^order(step)/dt^order``; its numbers may be traced.

    Parameters
    ----------
    before
        Rate before t = 0 [rad/s].
    change
        What scales the step: a change of the rate [rad/s] with order 0, an angle [rad] with order 1.
    step
        Way from 0 to 1.
    order
        0 or 1.
    """

    before: Any
    change: Any
    step: UnitStep
    order: int = 0

    def around(self, instant: Any) -> Callable[[Any], tuple[Any, Any]]:
        """Rate and angular acceleration over time in the smooth stretch that an instant lies in, and beyond it."""
        step, order = self.step.around(instant), self.order

        def rates(time: Any) -> tuple[Any, Any]:
            values = step(time)
            return self.before + self.change * values[order], self.change * values[order + 1]

        return rates


class FixedAxis(Maneuver):
    """Rotation about a fixed line by a `RateFormula`, for single runs and for batches.

    A subclass is a frozen dataclass whose fields are ``axis``, ``origin`` and what `formula` needs.
    """

    axis: tuple[float, float, float]
    origin: tuple[float, float, float]

    @abstractmethod
    def formula(self, numbers: Mapping[str, Any]) -> RateFormula:
        """Rate over time for given values of `numbers`, which a batch traces: arithmetic only, no checks."""

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the formula by name, which a batch may replace: all fields that hold one number."""
        numbers = {name: value for name, value in vars(self).items() if isinstance(value, int | float)}
        return {name: value for name, value in numbers.items() if not isinstance(value, bool)}

    def _check_line(self) -> None:
        unit_axis(self.axis)
        checks.vector3("origin", self.origin)

    def _line(self) -> tuple[Array, Array]:
        return unit_axis(self.axis), np.asarray(self.origin, dtype=float)

    def start(self) -> RigidMotion:
        """Steady rotation at the rate before."""
        return fixed_axis_motion(self.formula(self.numbers).before, 0.0, *self._line())

    def segments(self) -> tuple[Segment, ...]:
        """The smooth stretches of the formula, then steady rotation."""
        formula, line = self.formula(self.numbers), self._line()

        def turning(start: float, end: float) -> Segment:
            rates = formula.around(0.5 * (start + end))
            return Segment(start, end, lambda time: fixed_axis_motion(*rates(time), *line), _many(rates, *line))

        edges = formula.step.edges
        after = fixed_axis_motion(*formula.around(edges[-1] + 1.0)(edges[-1]), *line)
        steady = Segment(edges[-1], np.inf, lambda time: after, lambda times: np.tile(after.row, (len(times), 1)))
        return (*(turning(*limits) for limits in pairwise(edges)), steady)


def _many(rates: Callable[[Any], tuple[Any, Any]], axis: Array, origin: Array) -> Callable[[Array], Array] | None:
    """What `Segment.many` asks for, about a line through the frame's origin."""
    if origin.any():
        return None

    def rows(times: Array) -> Array:
        found = np.zeros((len(times), 9))
        for part, values in zip((found[:, :3], found[:, 3:6]), rates(times), strict=True):
            part[:] = np.reshape(values, (-1, 1)) * axis
        return found

    return rows


@dataclass(frozen=True)
class Stop(FixedAxis):
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

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Stop(rate=0.6, duration=1.0, axis=(0.0, 1.0, 0.0)).duration
    1.0
    """

    rate: float
    duration: float
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        checks.finite("rate", self.rate)
        checks.positive("duration", self.duration)
        self._check_line()

    def formula(self, numbers: Mapping[str, Any]) -> RateFormula:
        """The whole rate is taken away linearly."""
        return RateFormula(numbers["rate"], -numbers["rate"], UnitStep.of("linear", numbers["duration"]))


@dataclass(frozen=True)
class SpinUp(FixedAxis):
    """Change of a steady spin, from rest unless an initial rate is given.

    Parameters
    ----------
    rate
        Angular velocity to reach, from ``duration`` on [rad/s].
    duration
        Length of the change [s], > 0.
    profile
        Angular velocity over time: ``"versine"``, ``rate (t/T - sin(2 pi t/T)/(2 pi))`` [Kane, Ryan & Banerjee
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

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.SpinUp(rate=0.6, duration=2.0, axis=(0.0, 0.0, 1.0)).rate
    0.6
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
        self._check_line()
        checks.finite("initial_rate", self.initial_rate)

    def formula(self, numbers: Mapping[str, Any]) -> RateFormula:
        """From the initial rate to the other one by the profile."""
        before = numbers["initial_rate"]
        return RateFormula(before, numbers["rate"] - before, UnitStep.of(self.profile, numbers["duration"]))


@dataclass(frozen=True)
class Slew(FixedAxis):
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
    frequency
        Natural frequency of the mode to leave at rest [Hz], > 0 (input-shaped only).
    damping_ratio
        Its damping ratio, in [0, 1) (input-shaped only).
    shaper
        ``"ZVD"`` (robust, takes a period) or ``"ZV"`` (takes half of one), see `shaper_impulses`.
    base
        ``"bang-bang"``, ``"versine"`` or ``"minimum-jerk"``: what the shaper copies; it lasts ``duration`` less
        the shaper's longest delay.

    Raises
    ------
    InputError
        If a value is out of range, or the duration is too short for the shaper.

    Examples
    --------
    >>> import tautflex as tf
    >>> import math
    >>> tf.Slew(angle=math.radians(30.0), duration=4.0, axis=(0.0, 1.0, 0.0), profile="minimum-jerk").duration
    4.0
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
        self._check_line()
        if self.profile == "input-shaped":
            self._check_shaper()
            return
        for one in fields(self):
            value = getattr(self, one.name)
            if one.name in SHAPING and value != one.default:
                raise InputError(
                    f"{one.name}: expected no value with profile = {self.profile!r}, got {value!r}; "
                    "set profile = 'input-shaped'"
                )

    def _check_shaper(self) -> None:
        if self.frequency is None:
            raise InputError(
                "frequency: missing, profile = 'input-shaped' expects the mode's natural frequency [Hz]; "
                "add it, `tautflex modes` and solve_modes(state).frequencies list them"
            )
        delay = shaper_impulses(self.shaper, self.frequency, self.damping_ratio)[-1][1]
        if not self.duration > delay:
            raise InputError(
                f"duration: expected more than the {delay:g} s that the {self.shaper} shaper of a mode at "
                f"{self.frequency:g} Hz takes, got {self.duration:g} s; turn more slowly or take the shaper 'ZV'"
            )

    @property
    def numbers(self) -> dict[str, float]:
        """Angle and duration, and what the shaper needs."""
        numbers = super().numbers
        return numbers if self.frequency is not None else {name: numbers[name] for name in ("angle", "duration")}

    def formula(self, numbers: Mapping[str, Any]) -> RateFormula:
        """The rate is the angle times the slope of a unit step."""
        duration, profile = numbers["duration"], self.profile
        copies: Impulses = ((1.0, 0.0),)
        if self.frequency is not None:
            copies = impulse_train(SHAPERS[self.shaper], numbers["frequency"], numbers["damping_ratio"])
            duration, profile = duration - copies[-1][1], self.base
        return RateFormula(0.0, numbers["angle"], UnitStep.of(profile, duration, copies), order=1)
