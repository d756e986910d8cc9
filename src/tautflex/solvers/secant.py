"""Secant memory: makes an old factorization act like a fresh one for the few directions that changed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class SecantMemory:
    """Anderson acceleration in the energy norm of the factorized matrix K.

    From pairs (change of x, change of residual r) seen since the last factorization, the next step is the
    preconditioned one, ``-K^-1 r``, corrected so that the part of r spanned by the seen changes is removed exactly:
    ``gamma = argmin |r - dR gamma|`` in the norm of ``K^-1``. Pairs survive from one time step to the next, because
    the matrix does too.

    Parameters
    ----------
    depth
        Pairs kept.
    """

    def __init__(self, depth: int = 10) -> None:
        self._depth = depth
        self.clear()

    def clear(self) -> None:
        """Forget everything (after a refactorization)."""
        self._count = 0

    def learn(self, move: Array, change: Array, answer: Array) -> None:
        """Add a pair, in place of the oldest one when the memory is full.

        Parameters
        ----------
        move, change
            Change of x and of the residual, shape (size,).
        answer
            ``K^-1 change``, shape (size,).
        """
        energy = float(change @ answer) if self._depth else 0.0
        if not energy > 0.0 or not np.isfinite(energy):
            return
        if not self._count:
            self._changes, self._shifts = np.empty((2, self._depth, move.size))
            self._gram = np.eye(self._depth)
        # Scaled to unit energy, so that the Gram matrix has a unit diagonal.
        scale = 1.0 / np.sqrt(energy)
        row = self._count % self._depth
        np.multiply(change, scale, out=self._changes[row])
        np.subtract(answer, move, out=self._shifts[row])
        self._shifts[row] *= scale
        self._count += 1
        used = min(self._count, self._depth)
        products = scale * (self._changes[:used] @ answer)
        self._gram[row, :used] = self._gram[:used, row] = products

    def correct(self, step: Array) -> Array:
        """Corrected step from ``step = -K^-1 r``, shape (size,)."""
        used = min(self._count, self._depth)
        if not used:
            return step
        right = -(self._changes[:used] @ step)
        # The ridge keeps nearly parallel pairs from cancelling each other with huge weights.
        gamma = np.linalg.solve(self._gram[:used, :used] + 1e-8 * np.eye(used), right)
        return step + gamma @ self._shifts[:used]
