"""What every damping comes down to: parts of mass and stiffness, and a few vectors."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tautflex.numeric import Array
from tautflex.text import brief


@dataclass(frozen=True)
class DampingMatrix:
    """``C = mass M + stiffness K + sum_k coefficients_k v_k v_k'``; the sum is never filled in.

    Parameters
    ----------
    mass, stiffness
        Factors of the mass matrix [1/s] and of the stiffness of the prestressed reference [s], >= 0.
    vectors
        v on the free unknowns, shape (rank, size); no rows are none.
    coefficients
        Their weights, >= 0, shape (rank,).
    """

    mass: float = 0.0
    stiffness: float = 0.0
    vectors: Array = field(default_factory=lambda: np.zeros((0, 0)))
    coefficients: Array = field(default_factory=lambda: np.zeros(0))
    __repr__ = brief

    @property
    def rank(self) -> int:
        """Number of vectors."""
        return len(self.vectors)

    def proportional(self, mass: Array, stiffness: Array) -> Array:
        """Values of ``mass M + stiffness K`` from those of M and K, any shape."""
        return self.mass * mass + self.stiffness * stiffness

    def low_rank_force(self, velocity: Any) -> Any:
        """What the vectors add to ``C velocity``, shape (size,) or (size, columns)."""
        if not self.rank:
            return np.zeros_like(velocity)
        rates = self.vectors @ velocity
        return self.vectors.T @ (self.coefficients.reshape(-1, *(1 for _ in rates.shape[1:])) * rates)

    def projected(self, mass: Array, stiffness: Array, basis: Array) -> Array:
        """``Phi' C Phi`` from ``Phi' M Phi`` and ``Phi' K Phi``; ``basis`` holds Phi as rows, shape (r, size)."""
        result = self.proportional(mass, stiffness)
        return result + basis @ self.low_rank_force(basis.T) if self.rank else result
