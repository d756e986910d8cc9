"""Solution with a factorized matrix and a correction of low rank, which is never filled in.

``(A + U' D U)^-1 r = y - Z (1 + D U Z)^-1 D U y`` with ``y = A^-1 r`` and ``Z = A^-1 U'`` [Woodbury 1950, Inverting
modified matrices; Golub & Van Loan, Matrix Computations, 2.1.4]. Nothing is asked of the core D: it may be singular or
not symmetric.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tautflex.mechanics.products import inner
from tautflex.numeric import Array, jit
from tautflex.solvers.remembering import Remembering


@jit
def take_back(back: Array, vectors: Array, solution: Array) -> None:
    """Correct the solution of A, in place, to that of the corrected matrix."""
    if vectors.shape[0] == 0:
        return
    shares = np.empty(vectors.shape[0])
    for k in range(shares.size):
        shares[k] = inner(vectors[k], solution)
    for i in range(solution.size):
        total, row = 0.0, back[i]
        for k in range(shares.size):
            total += row[k] * shares[k]
        solution[i] -= total


class Factors(Protocol):
    """A matrix that can be solved with: `SymmetricFactorization`, SuperLU."""

    def solve(self, right: Array, /) -> Array:
        """Solution of one right-hand side, shape (size,)."""
        ...


class LowRankUpdate(Remembering):
    """Factors of A, and what makes them those of ``A + U' D U``.

    Whenever the factors change, `correct` has to be called again; without it A itself is solved with.
    """

    MEMORY = ("_back", "_vectors")

    def __init__(self, factors: Factors) -> None:
        self.factors = factors
        none: Array = np.zeros((0, 0))
        self._back = self._vectors = none

    @property
    def rank(self) -> int:
        """Number of vectors that correct A."""
        return len(self._vectors)

    def correct(self, vectors: Array, core: Array) -> None:
        """Take the present factors and add ``vectors' core vectors`` to their matrix in place of any before.

        ``vectors`` is U, shape (rank, size), and costs one solution per row; ``core`` is D, shape (rank, rank), or its
        diagonal, shape (rank,). LinAlgError if the corrected matrix is singular.
        """
        square = core[:, None] * np.eye(len(core)) if core.ndim == 1 else core
        self._vectors = vectors
        moved = np.array([self.factors.solve(row) for row in vectors]).reshape(vectors.shape).T
        both = np.eye(len(vectors)) + square @ (vectors @ moved)
        self._back = moved @ np.linalg.solve(both, square)

    def solve(self, right: Array) -> Array:
        """Solution with the corrected matrix, shape (size,), or (size, columns) where the factors can."""
        y = self.factors.solve(right)
        if not len(self._vectors):
            return y
        if y.ndim > 1 or np.iscomplexobj(y):
            return y - self._back @ (self._vectors @ y)
        take_back(*self.parts, y)
        return y

    @property
    def parts(self) -> tuple[Array, Array]:
        """What `take_back` reads: shapes (size, rank) and (rank, size)."""
        return np.ascontiguousarray(self._back), np.ascontiguousarray(self._vectors)
