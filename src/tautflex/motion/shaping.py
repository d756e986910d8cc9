"""Input shaping: a maneuver split into delayed copies whose vibrations of one mode cancel."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.profiles import Impulses, library_of
from tautflex.numeric import Array

SHAPERS = {"ZV": 1, "ZVD": 2}
"""Order of the zero that each shaper has at the poles of the mode."""
# Amplitudes below this are round-off.
_NONE = 1e-14


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
    """`shaper_impulses` by the order of the shaper's zero, for numbers of any array library, unchecked."""
    xp = library_of(ratio)
    root = xp.sqrt(1.0 - ratio**2)
    decay = xp.exp(-math.pi * ratio / root)
    half_period = 0.5 / (frequency * root)
    weights = [math.comb(order, k) * decay**k for k in range(order + 1)]
    return tuple((weight / sum(weights), k * half_period) for k, weight in enumerate(weights))


def sampled_shaper(shaper: str, frequencies: ArrayLike, damping_ratios: ArrayLike, interval: float) -> Array:
    """Amplitudes of a shaper of several modes at samples, for references that are held over an interval.

    The delays of `shaper_impulses` lie between samples in general. Here the last impulse is split between the two
    samples around it, and all amplitudes are chosen such that the zeros lie at the modes' sampled poles
    ``exp((-z w +- i w_d) interval)`` exactly [Murphy & Watanabe 1992; Tuttle & Seering 1994].

    Parameters
    ----------
    shaper
        ``"ZV"`` or ``"ZVD"``.
    frequencies
        Natural frequencies of the modes [Hz], > 0, shape (n,).
    damping_ratios
        Their damping ratios, in [0, 1), one for all or shape (n,).
    interval
        Time between two samples [s].

    Returns
    -------
    numpy.ndarray
        Amplitudes, the first at once, shape (taps,); they add up to 1.

    Raises
    ------
    InputError
        If an argument is out of range.
    """
    step, result = checks.positive("interval", interval), np.ones(1)
    for frequency, ratio in checked_modes(shaper, frequencies, damping_ratios):
        half = shaper_impulses("ZV", frequency, ratio)[1][1] / step
        before = int(np.floor(half + 1e-9))
        if before == 0:
            raise InputError(
                f"interval: expected less than half a period of the mode at {frequency:g} Hz, got {step:g} s; sample "
                "faster, or leave the mode out"
            )
        # Amplitudes of z^-0, z^-before and z^-(before + 1): they add up to 1, and their sum vanishes at the pole.
        places = np.array([0, before, before + 1])
        at_pole = np.exp(2.0 * np.pi * frequency * complex(ratio, -np.sqrt(1.0 - ratio**2)) * step * places)
        taps = np.zeros(before + 2)
        taps[places] = np.linalg.solve(np.array([np.ones(3), at_pole.real, at_pole.imag]), np.array([1.0, 0.0, 0.0]))
        taps[np.abs(taps) < _NONE] = 0.0
        for _ in range(SHAPERS[shaper]):
            result = np.convolve(result, taps)
    return np.trim_zeros(result, "b")


def checked_modes(shaper: str, frequencies: ArrayLike, damping_ratios: ArrayLike) -> list[tuple[float, float]]:
    """Frequency [Hz] and damping ratio of every mode of `sampled_shaper`; InputError if one is out of range."""
    natural = checks.float_array("frequencies", frequencies, (None,))
    if not natural.size:
        raise InputError("frequencies: expected at least one natural frequency [Hz], got none; add it")
    given = checks.numbers("damping_ratios", damping_ratios)
    ratios = checks.spread("damping_ratios", given[0] if given.shape == (1,) else given, natural.size)
    for frequency, ratio in zip(natural, ratios, strict=True):
        shaper_impulses(shaper, frequency, ratio)
    return list(zip(natural.tolist(), ratios.tolist(), strict=True))
