"""Input shaping: a maneuver split into delayed copies whose vibrations of one mode cancel."""

from __future__ import annotations

import math
from bisect import bisect
from itertools import pairwise
from typing import Any

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.profiles import Piece, Values, library_of

SHAPERS = {"ZV": 1, "ZVD": 2}
"""Order of the zero that each shaper has at the poles of the mode."""

# Limits closer than this part of the whole are one: a step between them would be all round-off.
_SAME = 1e-9

Impulses = tuple[tuple[float, float], ...]


def shaper_impulses(shaper: str, frequency: float, damping_ratio: float = 0.0) -> Impulses:
    """Amplitudes [-] and delays [s] of a zero-vibration shaper [Singer & Seering 1990].

    Parameters
    ----------
    shaper
        ``"ZV"``: two impulses half a damped period apart; ``"ZVD"``: three, which also cancel the derivative of the
        vibration with respect to the frequency and so forgive a mode that is not quite where it was thought.
    frequency
        Natural frequency of the mode [Hz], > 0.
    damping_ratio
        Its damping ratio, in [0, 1).

    Returns
    -------
    tuple of (float, float)
        (amplitude, delay) of each impulse; the amplitudes add up to 1.

    Raises
    ------
    InputError
        If an argument is out of range.
    """
    order = SHAPERS[checks.one_of("shaper", shaper, tuple(SHAPERS))]
    natural = checks.positive("frequency", frequency)
    ratio = checks.finite("damping_ratio", damping_ratio)
    if not 0.0 <= ratio < 1.0:
        raise InputError(f"damping_ratio: expected a number in [0, 1), got {damping_ratio!r}; 0 is no damping")
    return tuple((float(amplitude), float(delay)) for amplitude, delay in impulse_train(order, natural, ratio))


def impulse_train(order: int, frequency: Any, ratio: Any) -> tuple[tuple[Any, Any], ...]:
    """Amplitudes and delays of `shaper_impulses` for numbers of any array library, unchecked.

    Parameters
    ----------
    order
        Order of the zero, a value of `SHAPERS`.
    frequency, ratio
        Natural frequency [Hz] and damping ratio.

    Returns
    -------
    tuple of (amplitude, delay)
    """
    xp = library_of(ratio)
    root = xp.sqrt(1.0 - ratio**2)
    decay = xp.exp(-math.pi * ratio / root)
    half_period = 0.5 / (frequency * root)
    weights = [math.comb(order, k) * decay**k for k in range(order + 1)]
    return tuple((weight / sum(weights), k * half_period) for k, weight in enumerate(weights))


def convolved(step: tuple[Piece, ...], impulses: Impulses) -> tuple[Piece, ...]:
    """Sum of scaled and delayed copies of a unit step.

    Parameters
    ----------
    step
        Way from 0 to 1 that starts at t = 0; it is 0 before and 1 after.
    impulses
        (amplitude, delay [s]) of each copy, delays >= 0, the first one 0.

    Returns
    -------
    tuple of Piece
        A way from 0 to the sum of the amplitudes with a limit wherever any copy has one.
    """
    corners = [piece.start for piece in step] + [step[-1].end]
    every = sorted(delay + corner for _, delay in impulses for corner in corners)
    limits = every[:1]
    for limit in every[1:]:
        if limit - limits[-1] > _SAME * every[-1]:
            limits.append(limit)
    return tuple(_sum_of_copies(step, corners, impulses, start, end) for start, end in pairwise(limits))


def _sum_of_copies(
    step: tuple[Piece, ...], corners: list[float], impulses: Impulses, start: float, end: float
) -> Piece:
    """Stretch between two limits; which part of each copy counts there is settled once, at its middle."""
    middle, parts, done = 0.5 * (start + end), [], 0.0
    for amplitude, delay in impulses:
        index = bisect(corners, middle - delay) - 1
        if 0 <= index < len(step):
            parts.append((amplitude, delay, step[index].values))
        elif index >= 0:
            done += amplitude

    def values(time: float) -> Values:
        value, slope, curvature = done, 0.0, 0.0
        for amplitude, delay, function in parts:
            own = function(time - delay)
            value += amplitude * own[0]
            slope += amplitude * own[1]
            curvature += amplitude * own[2]
        return value, slope, curvature

    return Piece(start, end, values)
