"""Stress fields of a reduced model as a basis for matrices over monomials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tautflex.numeric import Array
from tautflex.reduction.polynomial.monomials import monomial_sizes


@dataclass(frozen=True)
class Fields:
    """Stress fields F of the reduced model, shape (k, m), and their duals U, shape (m, k).

    Where there are too many for two products with F to pay, ``shape`` is None: A is then ``F' U' C U F``, per monomial.
    """

    shape: Array | None
    dual: Array

    @classmethod
    def of(cls, fields: Array, amplitude: Array) -> Fields:
        """Fields from their factor, judged at the typical size of each coordinate."""
        count, monomials = fields.shape
        weighed = fields * monomial_sizes(amplitude) ** 2
        dual = np.zeros((monomials, 0))
        if count:
            dual = np.asarray(np.linalg.solve(weighed @ fields.T, weighed).T, dtype=np.float64)
        if count * (count + monomials) < monomials**2:
            return cls(fields, dual)
        return cls(None, np.eye(monomials) if count == monomials else dual @ fields)

    def project(self, matrix: Any) -> Any:
        """A of a matrix over monomials."""
        return self.dual.T @ matrix @ self.dual

    def full(self, matrix: Any) -> Any:
        """Matrix over monomials of A, shape (m, m)."""
        return matrix if self.shape is None else self.shape.T @ matrix @ self.shape

    def root(self, matrix: Array) -> Array:
        """Factor V such that ``V'V = F' A F``, A of a positive semidefinite matrix over monomials, shape (l, m)."""
        values, vectors = np.linalg.eigh(self.project(matrix))
        kept = values > _ROUND_OFF * max(float(values[-1]), 0.0) if len(values) else values > 0.0
        rows = np.sqrt(values[kept])[:, None] * vectors.T[kept]
        return np.ascontiguousarray(rows if self.shape is None else rows @ self.shape)


# Eigenvalues below this part of the largest one are round-off.
_ROUND_OFF = 1e-15
