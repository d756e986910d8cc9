"""Steps between two commands."""

from __future__ import annotations

import numpy as np

from tautflex import checks
from tautflex.errors import InputError

# Longest step [s] where none is given.
_LONGEST = 5e-3


def steps_of(interval: float, time_step: float | None) -> int:
    """Steps of an interval; InputError unless they are whole ones."""
    if time_step is None:
        return int(np.ceil(interval / _LONGEST - 1e-9))
    count = interval / checks.positive("time_step", time_step)
    if round(count) < 1 or abs(count - round(count)) > 1e-6:
        whole = interval / max(1, round(count))
        raise InputError(
            f"time_step: expected a whole part of the interval ({interval:g} s), got {time_step:g}; set for example "
            f"time_step = {whole:.6g}"
        )
    return round(count)
