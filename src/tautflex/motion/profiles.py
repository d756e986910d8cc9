"""Unit steps: ways from 0 to 1, from which rotations about an axis are scaled.

Every number may belong to any array library and be traced, so that one formula serves a single run and a batch. Powers
are products, which are the same numbers for one instant and for many.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Values = tuple[Any, Any, Any]
Impulses = tuple[tuple[Any, Any], ...]

# Limits closer than this part of the whole are one: a step between them would be all round-off.
_SAME = 1e-9


@dataclass(frozen=True)
class Stretch:
    """Smooth stretch of a function of time.

    Parameters
    ----------
    start, end
        Limits [s].
    values
        Time [s] -> the function and its first two derivatives [1, 1/s, 1/s^2], beyond the limits too.
    """

    start: Any
    end: Any
    values: Callable[[Any], Values]


@dataclass(frozen=True)
class UnitStep:
    """Way from 0 to 1: the sum of scaled and delayed copies of one that starts at t = 0.

    Parameters
    ----------
    stretches
        Of the copied way, from t = 0 on; it is 0 before and 1 after them.
    copies
        (amplitude, delay [s]) of each copy, delays >= 0, the first one 0; the amplitudes add up to 1.
    """

    stretches: tuple[Stretch, ...]
    copies: Impulses = ((1.0, 0.0),)

    @classmethod
    def of(cls, profile: str, duration: Any, copies: Impulses = ((1.0, 0.0),)) -> UnitStep:
        """Way by a named profile.

        Parameters
        ----------
        profile
            ``"linear"``; ``"versine"``, ``s - sin(2 pi s)/(2 pi)``; ``"minimum-jerk"``, ``10 s^3 - 15 s^4 + 6 s^5``
            [Flash & Hogan 1985]; ``"bang-bang"``, constant second derivative that changes sign halfway.
        duration
            Of one copy [s].
        copies
            See the class.
        """
        return cls(tuple(_stretched(shape, start, end, duration) for start, end, shape in _STEPS[profile]), copies)

    @property
    def limits(self) -> list[Any]:
        """Instants > 0 where a derivative may jump [s], in any order."""
        starts = [delay for _, delay in self.copies[1:]]
        return starts + [delay + stretch.end for _, delay in self.copies for stretch in self.stretches]

    @property
    def edges(self) -> list[float]:
        """The same in order, from 0 on, those that coincide once; of numbers that are not traced."""
        edges, last = [0.0], max(self.limits, default=0.0)
        for limit in sorted(self.limits):
            if limit - edges[-1] > _SAME * last:
                edges.append(float(limit))
        return edges

    def around(self, instant: Any) -> Callable[[Any], Values]:
        """Way in the stretch that an instant lies in, and beyond it: time -> value, slope and curvature."""
        done, parts = 0.0, []
        for amplitude, delay in self.copies:
            own = instant - delay
            done = done + amplitude * (own >= self.stretches[-1].end)
            for stretch in self.stretches:
                here = (own >= stretch.start) & (own < stretch.end)
                if not isinstance(here, bool | np.bool) or here:  # a traced one may be either
                    parts.append((amplitude * here, delay, stretch.values))

        def values(time: Any) -> Values:
            value, slope, curvature = done, 0.0, 0.0
            for weight, delay, function in parts:
                own = function(time - delay)
                value, slope, curvature = value + weight * own[0], slope + weight * own[1], curvature + weight * own[2]
            return value, slope, curvature

        return values


def library_of(value: Any) -> Any:
    """Array library that a number belongs to."""
    return value.__array_namespace__() if hasattr(value, "__array_namespace__") else np


def _linear(s: Any) -> Values:
    return s, 1.0, 0.0


def _versine(s: Any) -> Values:
    xp, turn = library_of(s), 2.0 * np.pi
    return s - xp.sin(turn * s) / turn, 1.0 - xp.cos(turn * s), turn * xp.sin(turn * s)


def _minimum_jerk(s: Any) -> Values:
    square, left = s * s, 1.0 - s
    value = square * s * (10.0 + s * (6.0 * s - 15.0))
    return value, 30.0 * square * (left * left), 60.0 * s * left * (1.0 - 2.0 * s)


def _speeding_up(s: Any) -> Values:
    return 2.0 * s * s, 4.0 * s, 4.0


def _slowing_down(s: Any) -> Values:
    left = 1.0 - s
    return 1.0 - 2.0 * left * left, 4.0 * left, -4.0


# Ways over the unit interval; the limits of their stretches are where a derivative jumps.
_STEPS: dict[str, tuple[tuple[float, float, Callable[[Any], Values]], ...]] = {
    "linear": ((0.0, 1.0, _linear),),
    "versine": ((0.0, 1.0, _versine),),
    "minimum-jerk": ((0.0, 1.0, _minimum_jerk),),
    "bang-bang": ((0.0, 0.5, _speeding_up), (0.5, 1.0, _slowing_down)),
}


def _stretched(shape: Callable[[Any], Values], start: float, end: float, duration: Any) -> Stretch:
    def values(time: Any) -> Values:
        value, slope, curvature = shape(time / duration)
        return value, slope / duration, curvature / duration / duration

    return Stretch(start * duration, end * duration, values)
