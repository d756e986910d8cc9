"""Input shaping: a maneuver split into delayed copies whose vibrations of one mode cancel."""

from __future__ import annotations

import math
from typing import Any

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.profiles import Impulses, library_of

SHAPERS = {"ZV": 1, "ZVD": 2}
"""Order of the zero that each shaper has at the poles of the mode."""


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
