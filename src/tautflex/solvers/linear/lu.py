"""SuperLU with partial pivoting: for matrices that L D L' without pivoting does not get right."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, triu
from scipy.sparse.linalg import SuperLU, splu

from tautflex.numeric import Array
from tautflex.solvers.linear.backend import Backend


class PivotedLU(Backend):
    """L U with partial pivoting, which does not keep the inertia."""

    _factors: SuperLU | None = None

    def factorize(self, values: Array) -> None:
        """Factorize the matrix with these values of its upper triangle; LinAlgError if it is singular."""
        upper, self._factors = self._upper(values), None
        try:
            self._factors = splu(csc_array(upper + triu(upper, k=1).T))
        except RuntimeError as error:
            raise np.linalg.LinAlgError("matrix is singular") from error

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        if self._factors is None:
            raise np.linalg.LinAlgError("no matrix has been factorized")
        return np.asarray(self._factors.solve(right))

    @property
    def fill(self) -> int:
        """Stored entries of L and U."""
        return 0 if self._factors is None else int(self._factors.nnz)
