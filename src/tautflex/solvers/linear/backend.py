"""What all direct solvers of one sparse symmetric matrix have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from tautflex.numeric import Array


class Backend(ABC):
    """Factors of a symmetric matrix whose upper triangle has a fixed pattern; one small file each.

    Parameters
    ----------
    size
        Number of unknowns.
    column_start, rows
        Compressed columns of the upper triangle.
    memo
        Where what it finds out about the pattern is kept for other matrices of the same one.
    """

    def __init__(
        self, size: int, column_start: NDArray[np.int32], rows: NDArray[np.int32], memo: dict[str, Any]
    ) -> None:
        self._size, self._start, self._rows = size, column_start, rows

    def _upper(self, values: Array) -> csc_array:
        return csc_array((values, self._rows, self._start), shape=(self._size, self._size))

    @property
    def parts(self) -> tuple[Any, ...] | None:
        """Factors as `substitute` reads them; None where they are others."""
        return None

    @abstractmethod
    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if it is singular."""

    @abstractmethod
    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""

    def negative_pivots(self) -> int | None:
        """Number of negative eigenvalues (Sylvester's law of inertia), None if these factors do not tell."""
        return None

    @property
    @abstractmethod
    def fill(self) -> int:
        """Stored entries of the factors."""
