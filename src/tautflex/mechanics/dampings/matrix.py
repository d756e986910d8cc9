"""What every damping comes down to: parts of mass and stiffness, and a few vectors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from tautflex.numeric import Array
from tautflex.text import brief

_PARTS = ("mass", "stiffness")
_NO_KINDS: Mapping[str, tuple[Any, Any]] = MappingProxyType({})


@dataclass(frozen=True)
class DampingMatrix:
    """``C = mass M + stiffness K + sum_e (m_e M_e + s_e K_e) + sum_k coefficients_k v_k v_k'``.

    The last sum is never filled in.

    Parameters
    ----------
    mass, stiffness
        Factors of the mass matrix [1/s] and of the stiffness of the prestressed reference [s], >= 0.
    vectors
        v on the free unknowns, shape (rank, size); no rows are none.
    coefficients
        Their weights, >= 0, shape (rank,).
    kinds
        Kind of element e -> (m_e [1/s], s_e [s]): what its own mass M_e and its material stiffness K_e, that of the
        reference without the part of its stress, count in addition; C must stay positive semidefinite.
    """

    mass: float = 0.0
    stiffness: float = 0.0
    vectors: Array = field(default_factory=lambda: np.zeros((0, 0)))
    coefficients: Array = field(default_factory=lambda: np.zeros(0))
    kinds: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)

    __repr__ = brief

    @property
    def rank(self) -> int:
        """Number of vectors."""
        return len(self.vectors)

    def joined(self, vectors: Array, coefficients: Array) -> DampingMatrix:
        """Same with more vectors (rank, size) and their coefficients (rank,)."""
        if not len(vectors):
            return self
        # Products, because the own coefficients may be traced.
        own, total = self.rank, self.rank + len(vectors)
        weights = np.concatenate([np.zeros(own), coefficients])
        if own:
            vectors, weights = np.concatenate([self.vectors, vectors]), weights + np.eye(total, own) @ self.coefficients
        return replace(self, vectors=vectors, coefficients=weights)

    @property
    def weights(self) -> dict[str, Any]:
        """All that is not a vector, by name."""
        named = {"mass": self.mass, "stiffness": self.stiffness, "coefficients": self.coefficients}
        return named | {f"{name}.{kind}": part[i] for kind, part in self.kinds.items() for i, name in enumerate(_PARTS)}

    def proportional(self, mass: Any, stiffness: Any, kinds: Mapping[str, tuple[Any, Any]] = _NO_KINDS) -> Any:
        """C without its vectors, from values of M, K and, where kinds differ, the (M_e, K_e) of each; any shape."""
        result = self.mass * mass + self.stiffness * stiffness
        for kind, (on_mass, on_stiffness) in self.kinds.items():
            result = result + on_mass * kinds[kind][0] + on_stiffness * kinds[kind][1]
        return result

    def low_rank_force(self, velocity: Any) -> Any:
        """What the vectors add to ``C velocity``, shape (size,) or (size, columns)."""
        if not self.rank:
            return np.zeros_like(velocity)
        rates = self.vectors @ velocity
        return self.vectors.T @ (self.coefficients.reshape(-1, *(1 for _ in rates.shape[1:])) * rates)

    def projected(
        self, mass: Array, stiffness: Array, basis: Array, kinds: Mapping[str, tuple[Array, Array]] = _NO_KINDS
    ) -> Array:
        """``Phi' C Phi`` from those of M, K and (M_e, K_e); ``basis`` holds Phi as rows, shape (r, size)."""
        result: Array = self.proportional(mass, stiffness, kinds)
        return result + basis @ self.low_rank_force(basis.T) if self.rank else result
