"""Linear laws as a matrix, for a network to learn behind."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.control.law import law_of
from tautflex.control.signals import Reference
from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.judging.baselines import baseline
from tautflex.numeric import Array

# Size of what a law is asked with: so small that no limit of it is met.
_SMALL = 1e-3


def linear_gain(law: Any, arena: Arena) -> Array:
    """Matrix of a linear law without memory in parts of the limits, shape (commands, z); z as of `Observation`.

    Raises
    ------
    InputError
        If the law has a memory, or is not linear.
    """
    chosen = baseline(law, arena) if isinstance(law, str) else law_of("law", law)
    spec, size, axes = arena.spec, len(arena.spec.measured), arena.spec.axes
    width = 2 * size + 4 * axes

    def commands(z: Array) -> list[Array]:
        """What it commands at the first and the second of two instants that are alike."""
        told = Reference(0.0, *z[2 * size :].reshape(4, axes))
        memory, first = chosen.act(chosen.start(spec), z[:size], told)
        return [
            np.broadcast_to(each, arena.limits.shape) / arena.limits
            for each in (first, chosen.act(memory, z[:size], told)[1])
        ]

    expected = "law: expected a linear law without memory for a network to learn behind"
    try:
        gain = np.array([commands(_SMALL * row)[0] for row in np.eye(width)]).T / _SMALL
        tried = _SMALL * np.cos(np.arange(width))
        linear = all(np.allclose(gain @ tried, each, atol=1e-12) for each in commands(tried))
    except InputError as error:
        raise InputError(f"{expected}, got {law!r} ({error}); take 'pd' or 'none'") from None
    if not linear:
        raise InputError(f"{expected}, got {law!r}; take 'pd' or 'none'")
    return gain
