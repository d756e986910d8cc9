"""Sparse direct solution of symmetric systems in the fixed pattern, behind one small interface."""

from __future__ import annotations

import numpy as np
import qdldl
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from tautflex.mechanics.pattern import SparsityPattern

Array = NDArray[np.float64]


class SymmetricFactorization:
    """LDL' factors of a symmetric matrix given by its values in a pattern; the ordering is found once.

    Parameters
    ----------
    pattern
        Sparsity pattern of the matrix.

    Notes
    -----
    QDLDL factors without pivoting. Should it meet an exactly zero pivot, SuperLU with pivoting takes over for that
    matrix. ``factorizations`` and ``solves`` count the work done.
    """

    def __init__(self, pattern: SparsityPattern) -> None:
        self.pattern = pattern
        self.factorizations = 0
        self.solves = 0
        self._solver: qdldl.Solver | None = None
        self._fallback: SuperLU | None = None

    @property
    def ready(self) -> bool:
        """Whether a matrix has been factorized."""
        return self._solver is not None or self._fallback is not None

    def factorize(self, values: Array) -> None:
        """Factorize the symmetric matrix with these values in the pattern, shape (entries,).

        Raises
        ------
        numpy.linalg.LinAlgError
            If the matrix is singular or not finite.
        """
        if not np.all(np.isfinite(values)):
            raise np.linalg.LinAlgError("matrix has entries that are not finite")
        self.factorizations += 1
        upper = self.pattern.upper_matrix(values)
        self._fallback = None
        try:
            if self._solver is None:
                self._solver = qdldl.Solver(upper, upper=True)
            else:
                self._solver.update(upper, upper=True)
        except RuntimeError:
            self._solver = None
            try:
                self._fallback = splu(self.pattern.matrix(values))
            except RuntimeError as error:
                raise np.linalg.LinAlgError("matrix is singular") from error

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        self.solves += 1
        if self._fallback is not None:
            return self._fallback.solve(right)
        assert self._solver is not None, "factorize first"
        return self._solver.solve(right)

    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the factorized matrix (Sylvester's law of inertia)."""
        if self._fallback is not None:
            # A pivoted LU does not keep the inertia; an exactly zero pivot counts as not positive.
            return 1
        assert self._solver is not None, "factorize first"
        diagonal = self._solver.factors()[1]
        return int(np.sum(np.asarray(diagonal) <= 0.0))
