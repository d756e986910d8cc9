"""Solution with a factorized matrix and a correction of low rank, which is never filled in.

``(A + U' D V)^-1 r = y - Z (1 + D V Z)^-1 D V y`` with ``y = A^-1 r`` and ``Z = A^-1 U'`` [Woodbury 1950, Inverting
modified matrices; Golub & Van Loan, Matrix Computations, 2.1.4]. Nothing is asked of the core D: it may be singular or
not symmetric.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tautflex.numeric import Array


class Factors(Protocol):
    """A matrix that can be solved with: `SymmetricFactorization`, SuperLU."""

    def solve(self, right: Array, /) -> Array:
        """Solution of one right-hand side, shape (size,)."""
        ...


class LowRankUpdate:
    """Factors of A, and what makes them those of ``A + U' D V``.

    Parameters
    ----------
    factors
        Factors of A. Whenever they change, `correct` has to be called again; without it A itself is solved with.
    """

    def __init__(self, factors: Factors) -> None:
        self.factors = factors
        none: Array = np.zeros((0, 0))
        self._back = self._right = none

    def correct(self, left: Array, core: Array, right: Array | None = None) -> None:
        """Take the present factors and add ``left' core right`` to their matrix, in place of what was added before.

        Costs one solution per row of ``left``.

        Parameters
        ----------
        left, right
            U and V, shape (rank, size), few rows; ``right`` None is ``left``.
        core
            D, shape (rank, rank), or its diagonal, shape (rank,).

        Raises
        ------
        numpy.linalg.LinAlgError
            If the corrected matrix is singular.
        """
        square = core[:, None] * np.eye(len(core)) if core.ndim == 1 else core
        self._right = left if right is None else right
        moved = np.array([self.factors.solve(row) for row in left]).reshape(left.shape).T
        inner = np.eye(len(left)) + square @ (self._right @ moved)
        self._back = moved @ np.linalg.solve(inner, square)

    def solve(self, right: Array) -> Array:
        """Solution with the corrected matrix, shape (size,), or (size, columns) where the factors can."""
        y = self.factors.solve(right)
        return y - self._back @ (self._right @ y) if len(self._right) else y
