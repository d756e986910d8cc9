"""State of a structure at one instant, terms of its moving frame, and what lies between two instants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tautflex.numeric import Array, jit
from tautflex.solvers.remembering import Memory
from tautflex.solvers.transient.accuracy.books import Books


@dataclass
class MotionState:
    """State of the structure at one instant.

    Parameters
    ----------
    time
        [s].
    q, v, a
        Free unknowns, their velocities and accelerations, shape (size,).
    forces
        All forces but inertia at this instant, shape (size,); None until a method asks for them.
    jerk
        Difference quotient of the acceleration over the last step, shape (size,); None after a jump.
    internal
        Internal forces at this instant, shape (size,); None until a method asks for them.
    books
        Work done since the start of the run.
    """

    time: float
    q: Array
    v: Array
    a: Array
    forces: Array | None = None
    jerk: Array | None = None
    internal: Array | None = None
    books: Books = field(default_factory=lambda: Books(np.zeros(7)))


Resolved = Callable[[MotionState, Array], Array]
"""What steps resolve of a vector, at a state."""
"""What steps resolve of an acceleration, shape (size,), at a state: see `Stepper.resolved`."""


def recalled_state(kind: type[MotionState], memory: Memory) -> MotionState:
    """State of a kind from its fields, see `copied`."""
    parts: dict[str, Any] = {**memory, "books": Books(**memory["books"])}
    return kind(**parts)


@dataclass(frozen=True)
class MotionTerms:
    """Rotating-frame terms at one instant: G = M(velocity), K_T = M(displacement), Q_T = load."""

    key: tuple[float, ...]
    velocity: Array
    displacement: Array
    load: Array


@jit
def hermite(
    start: float, end: float, time: float, values: tuple[Array, Array], slopes: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Value and slope at ``time`` of the cubic that has these values and slopes at both ends."""
    step = end - start
    s = (time - start) / step
    mean = (values[1] - values[0]) / step
    first, last = slopes
    value = values[0] + s * step * (mean + (1.0 - s) * ((1.0 - s) * (first - mean) - s * (last - mean)))
    slope = mean + (1.0 - s) * (1.0 - 3.0 * s) * (first - mean) + s * (3.0 * s - 2.0) * (last - mean)
    return value, slope
