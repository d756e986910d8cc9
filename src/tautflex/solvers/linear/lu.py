"""SuperLU with partial pivoting: for matrices that L D L' without pivoting does not get right."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, triu
from scipy.sparse.linalg import SuperLU, splu

from tautflex.numeric import Array


def _factors(matrix: csc_array) -> SuperLU:
    try:
        return splu(matrix)
    except RuntimeError as error:
        raise np.linalg.LinAlgError("matrix is singular") from error


def general_solver(matrix: csc_array) -> Callable[[Array], Array]:
    """Solve with a matrix that need not be symmetric.

    Parameters
    ----------
    matrix
        Shape (size, size).

    Returns
    -------
    callable
        Solution from a right-hand side, shape (size,).

    Raises
    ------
    numpy.linalg.LinAlgError
        If the matrix is singular or not finite.
    """
    if not np.all(np.isfinite(matrix.data)):
        raise np.linalg.LinAlgError("matrix has entries that are not finite")
    factors = _factors(matrix)
    return lambda right: np.asarray(factors.solve(right))


class PivotedLU:
    """L U with partial pivoting.

    Parameters
    ----------
    size, column_start, rows, memo
        As of `Backend`.
    """

    def __init__(
        self, size: int, column_start: NDArray[np.int32], rows: NDArray[np.int32], memo: dict[str, Any]
    ) -> None:
        self._size, self._start, self._rows = size, column_start, rows
        self._factors: SuperLU | None = None

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if it is singular."""
        upper = csc_array((values, self._rows, self._start), shape=(self._size, self._size))
        self._factors = None
        self._factors = _factors(csc_array(upper + triu(upper, k=1).T))

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        if self._factors is None:
            raise np.linalg.LinAlgError("no matrix has been factorized")
        return np.asarray(self._factors.solve(right))

    def negative_pivots(self) -> None:
        """A pivoted LU does not keep the inertia."""
        return

    @property
    def fill(self) -> int:
        """Stored entries of L and U."""
        return 0 if self._factors is None else int(self._factors.nnz)
