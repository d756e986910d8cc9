"""Secant memory: makes an old factorization act like a fresh one for the few directions that changed."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Keeps nearly parallel pairs from cancelling each other with huge weights.
_RIDGE = 1e-8

_jit = numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"}, error_model="numpy")


@_jit
def _learn(
    changes: Array, shifts: Array, gram: Array, row: int, used: int, move: Array, change: Array, answer: Array
) -> bool:
    """Put a pair, scaled to unit energy, into a row; False if its energy is not positive."""
    energy = 0.0
    for i in range(move.size):
        energy += change[i] * answer[i]
    if not energy > 0.0 or not np.isfinite(energy):
        return False
    scale = 1.0 / np.sqrt(energy)
    for i in range(move.size):
        changes[row, i] = scale * change[i]
        shifts[row, i] = scale * (answer[i] - move[i])
    for k in range(used):
        total, other = 0.0, changes[k]
        for i in range(move.size):
            total += other[i] * answer[i]
        gram[row, k] = gram[k, row] = scale * total
    return True


@_jit
def _correct(changes: Array, shifts: Array, gram: Array, used: int, step: Array) -> Array:
    """Solve ``(gram + ridge) gamma = -changes . step`` by Cholesky and add ``gamma . shifts`` to the step."""
    gamma, factor = np.empty(used), np.empty((used, used))
    for k in range(used):
        total, other = 0.0, changes[k]
        for i in range(step.size):
            total += other[i] * step[i]
        gamma[k] = -total
    for k in range(used):
        for m in range(k + 1):
            value = gram[k, m]
            for i in range(m):
                value -= factor[k, i] * factor[m, i]
            # Round-off of nearly parallel pairs must not make the square root's argument negative.
            factor[k, m] = value / factor[m, m] if m < k else np.sqrt(max(value + _RIDGE, 1e-2 * _RIDGE))
    for k in range(used):
        for i in range(k):
            gamma[k] -= factor[k, i] * gamma[i]
        gamma[k] /= factor[k, k]
    for k in range(used - 1, -1, -1):
        for i in range(k + 1, used):
            gamma[k] -= factor[i, k] * gamma[i]
        gamma[k] /= factor[k, k]
    result = step.copy()
    for k in range(used):
        weight, shift = gamma[k], shifts[k]
        for i in range(step.size):
            result[i] += weight * shift[i]
    return result


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
        if not self._depth:
            return
        if not self._count:
            self._changes, self._shifts = np.empty((2, self._depth, move.size))
            self._gram = np.eye(self._depth)
        # Scaled to unit energy, so that the Gram matrix has a unit diagonal.
        row, used = self._count % self._depth, min(self._count + 1, self._depth)
        if _learn(self._changes, self._shifts, self._gram, row, used, move, change, answer):
            self._count += 1

    def correct(self, step: Array) -> Array:
        """Corrected step from ``step = -K^-1 r``, shape (size,)."""
        used = min(self._count, self._depth)
        if not used:
            return step
        corrected: Array = _correct(self._changes, self._shifts, self._gram, used, step)
        return corrected
