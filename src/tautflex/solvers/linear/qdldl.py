"""QDLDL's own factors and substitution, kept to measure the panels against."""

from __future__ import annotations

from typing import Any

import numpy as np
import qdldl
from numpy.typing import NDArray
from scipy.sparse import csc_array

from tautflex.numeric import Array


class PlainLDL:
    """L D L' without pivoting, entry by entry.

    Parameters
    ----------
    size, column_start, rows, memo
        As of `Backend`.
    """

    def __init__(
        self, size: int, column_start: NDArray[np.int32], rows: NDArray[np.int32], memo: dict[str, Any]
    ) -> None:
        self._size, self._start, self._rows = size, column_start, rows
        self._solver: Any = None

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if a pivot is zero."""
        matrix = csc_array((values, self._rows, self._start), shape=(self._size, self._size))
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
