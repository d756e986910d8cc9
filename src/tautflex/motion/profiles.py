"""Unit steps: smooth ways from 0 to 1, from which slews and spin-ups are scaled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Values = tuple[float, float, float]


@dataclass(frozen=True)
class Piece:
    """Smooth stretch of a function of time.

    Parameters
    ----------
    start, end
        Limits [s].
    values
        Time [s] -> the function and its first two derivatives [1, 1/s, 1/s^2], beyond the limits too.
    """

    start: float
    end: float
    values: Callable[[float], Values]


def library_of(value: Any) -> Any:
    """Array library that a number belongs to; the formulas of this room hold for any, traced numbers included."""
    return value.__array_namespace__() if hasattr(value, "__array_namespace__") else np


def _linear(s: float) -> Values:
    return s, 1.0, 0.0


def _versine(s: float) -> Values:
    xp, turn = library_of(s), 2.0 * np.pi
    return s - xp.sin(turn * s) / turn, 1.0 - xp.cos(turn * s), turn * xp.sin(turn * s)


def _minimum_jerk(s: float) -> Values:
    value = s**3 * (10.0 + s * (6.0 * s - 15.0))
    return value, 30.0 * s**2 * (1.0 - s) ** 2, 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)


def _speeding_up(s: float) -> Values:
    return 2.0 * s**2, 4.0 * s, 4.0


def _slowing_down(s: float) -> Values:
    left = 1.0 - s
    return 1.0 - 2.0 * left**2, 4.0 * left, -4.0


# Steps over the unit interval; the limits of their stretches are where a derivative jumps.
_STEPS: dict[str, tuple[tuple[float, float, Callable[[float], Values]], ...]] = {
    "linear": ((0.0, 1.0, _linear),),
    "versine": ((0.0, 1.0, _versine),),
    "minimum-jerk": ((0.0, 1.0, _minimum_jerk),),
    "bang-bang": ((0.0, 0.5, _speeding_up), (0.5, 1.0, _slowing_down)),
}


def unit_step(profile: str, duration: float) -> tuple[Piece, ...]:
    """Way from 0 to 1 within ``duration``.

    Parameters
    ----------
    profile
        ``"linear"``; ``"versine"``, ``s - sin(2 pi s)/(2 pi)``; ``"minimum-jerk"``, ``10 s^3 - 15 s^4 + 6 s^5``
        [Flash & Hogan 1985]; ``"bang-bang"``, constant second derivative that changes sign halfway.
    duration
        [s].

    Returns
    -------
    tuple of Piece
        Smooth stretches that cover [0, duration].
    """
    return tuple(_stretched(shape, start, end, duration) for start, end, shape in _STEPS[profile])


def _stretched(shape: Callable[[float], Values], start: float, end: float, duration: float) -> Piece:
    def values(time: float) -> Values:
        value, slope, curvature = shape(time / duration)
        return value, slope / duration, curvature / duration / duration

    return Piece(start * duration, end * duration, values)
