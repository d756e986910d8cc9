"""Mass and damping on one pattern without stored zeros, so that one walk through it gives both forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.pattern import SparsityPattern
from tautflex.mechanics.products import product, quadratic_form

Array = NDArray[np.float64]


class MassDamping:
    """Symmetric mass and damping matrices of a run, in compressed rows.

    Parameters
    ----------
    pattern
        Pattern of the free unknowns.
    mass, damping
        Values in it, shape (entries,).

    Attributes
    ----------
    start, column, mass, damping
        Compressed rows of the entries where either matrix is not zero: transverse and in-plane unknowns of a flat
        film, for one, do not meet here.
    """

    def __init__(self, pattern: SparsityPattern, mass: Array, damping: Array) -> None:
        kept = (mass != 0.0) | (damping != 0.0)
        before = np.concatenate([[0], np.cumsum(kept)])
        # Symmetric: the pattern's columns are rows as well.
        self.start = before[pattern.column_start].astype(np.int64)
        self.column = pattern.rows[kept].astype(np.uint32)
        self.mass, self.damping = mass[kept], damping[kept]
        self.damped = bool(self.damping.any())

    def combined(self, mass: float, damping: float) -> Array:
        """Values of ``mass M + damping C``."""
        return mass * self.mass + damping * self.damping

    def mass_product(self, vector: Array) -> Array:
        """``M vector``, shape (size,)."""
        return product(self.start, self.column, self.mass, vector)

    def damping_product(self, vector: Array) -> Array:
        """``C vector``, shape (size,)."""
        return product(self.start, self.column, self.damping, vector)

    def mass_norm(self, vector: Array) -> float:
        """``vector' M vector``."""
        return float(quadratic_form(self.start, self.column, self.mass, vector))
