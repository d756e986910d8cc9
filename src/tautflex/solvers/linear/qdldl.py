"""QDLDL's own factors and substitution, kept to measure the panels against."""

from __future__ import annotations

from typing import Any

import numpy as np
import qdldl

from tautflex.numeric import Array
from tautflex.solvers.linear.backend import Backend


class PlainLDL(Backend):
    """L D L' without pivoting, entry by entry."""

    _solver: Any = None

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if a pivot is zero."""
        matrix = self._upper(values)
        try:
            if self._solver is None:
                self._solver = qdldl.Solver(matrix, upper=True)
            else:
                self._solver.update(matrix, upper=True)
        except RuntimeError as error:
            self._solver = None
            raise np.linalg.LinAlgError("a pivot is zero") from error

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        return np.asarray(self._solver.solve(right))

    def negative_pivots(self) -> int:
        """Number of negative eigenvalues (Sylvester's law of inertia)."""
        return int(np.sum(np.asarray(self._solver.factors()[1]) < 0.0))

    @property
    def fill(self) -> int:
        """Stored entries of L and D."""
        return int(self._solver.factors()[0].nnz) + self._size
