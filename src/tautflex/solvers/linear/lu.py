"""SuperLU with partial pivoting: for matrices that L D L' without pivoting does not get right."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_array, triu
from scipy.sparse.linalg import SuperLU, splu

from tautflex.numeric import Array
from tautflex.solvers.linear.backend import Backend


def _factors(matrix: csc_array) -> SuperLU:
    try:
        return splu(matrix)
    except RuntimeError as error:
        raise np.linalg.LinAlgError("matrix is singular") from error


def general_solver(matrix: csc_array) -> Callable[[Array], Array]:
    """Solver with a matrix that need not be symmetric; LinAlgError if it is singular or not finite."""
    if not np.all(np.isfinite(matrix.data)):
        raise np.linalg.LinAlgError("matrix has entries that are not finite")
    factors = _factors(matrix)
    return lambda right: np.asarray(factors.solve(right))


class PivotedLU(Backend):
    """L U with partial pivoting, which does not keep the inertia."""

    _factors: SuperLU | None = None

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if it is singular."""
        upper, self._factors = self._upper(values), None
        self._factors = _factors(csc_array(upper + triu(upper, k=1).T))

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        if self._factors is None:
            raise np.linalg.LinAlgError("no matrix has been factorized")
        return np.asarray(self._factors.solve(right))

    @property
    def fill(self) -> int:
        """Stored entries of L and U."""
        return 0 if self._factors is None else int(self._factors.nnz)
