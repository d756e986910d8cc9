"""Names of the runs that the figures draw, and the words that stand for their maneuvers."""

from __future__ import annotations

import math

MODELS = ("M1", "M2", "M3")
RATES = {"pi_100": math.pi / 100, "pi_50": math.pi / 50, "pi_5": math.pi / 5, "pi_2": math.pi / 2}
"""Angular velocities before the stop [rad/s], by their part of a run's name [paper, Tables 5 and 9]."""
DURATIONS = (0.1, 1.0, 2.0)
"""Durations of the stop [s] [paper, Table 5]."""
SECTION_3 = "damping0.01"
"""Part of a name that tells alpha = beta = 0.01 from section 4's 0.001 [paper, section 3]."""
RATE_SYMBOLS = {name: rf"$\pi$/{name.removeprefix('pi_')}" for name in RATES}


def run_name(model: str, rate: str, duration: float, variant: str = "published", damping: str = "") -> str:
    """Return the name of a run in the catalogue, e.g. ``published/M2/pi_5/T1/damping0.01``."""
    parts = [variant, model, rate, f"T{duration:g}", damping]
    return "/".join(part for part in parts if part)


def maneuver_words(rate: str, duration: float) -> str:
    """Return a maneuver as mathematical text for a title or a legend."""
    return rf"$\omega_0$ = {RATE_SYMBOLS[rate]} rad/s, $T$ = {duration:g} s"
