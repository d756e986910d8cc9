"""Anderson acceleration: makes an old factorization act like a fresh one for the few directions that changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from tautflex.mechanics.products import inner
from tautflex.numeric import Array, jit
from tautflex.solvers.remembering import Memory, Remembering

# Keeps nearly parallel pairs from cancelling each other with huge weights.
_RIDGE = 1e-8


@jit
def _learn(
    changes: Array, shifts: Array, gram: Array, row: int, used: int, last: Array, solution: Array, residual: Array
) -> bool:
    """Put the pair of the last step, scaled to unit energy, into a row; False if its energy is not positive.

    ``last`` holds the last step, residual and uncorrected step.
    """
    size = solution.size
    change, answer = np.empty(size), np.empty(size)
    then, uncorrected, taken = last[1], last[2], last[0]
    for i in range(size):
        change[i] = residual[i] - then[i]
    for i in range(size):
        answer[i] = uncorrected[i] + solution[i]
    energy = inner(change, answer)
    if not energy > 0.0 or not np.isfinite(energy):
        return False
    scale = 1.0 / np.sqrt(energy)
    learned, shift = changes[row], shifts[row]
    for i in range(size):
        learned[i] = scale * change[i]
    for i in range(size):
        shift[i] = scale * (answer[i] - taken[i])
    for k in range(used):
        gram[row, k] = gram[k, row] = scale * inner(changes[k], answer)
    return True


@jit
def _correct(changes: Array, shifts: Array, gram: Array, used: int, step: Array) -> None:
    """Solve ``(gram + ridge) gamma = -changes . step`` by Cholesky and add ``gamma . shifts`` to the step."""
    gamma, factor = np.empty(used), np.empty((used, used))
    for k in range(used):
        gamma[k] = -inner(changes[k], step)
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
    k = 0
    while k + 2 < used:
        f0, f1, f2, s0, s1, s2 = gamma[k], gamma[k + 1], gamma[k + 2], shifts[k], shifts[k + 1], shifts[k + 2]
        for i in range(step.size):
            step[i] = step[i] + f0 * s0[i] + f1 * s1[i] + f2 * s2[i]
        k += 3
    while k < used:
        weight, shift = gamma[k], shifts[k]
        for i in range(step.size):
            step[i] += weight * shift[i]
        k += 1


@jit
def propose_step(
    changes: Array, shifts: Array, gram: Array, count: int, known: bool, last: Array, solution: Array, residual: Array
) -> tuple[Array, float, int]:
    """Learn from the last step if it is known; next step, its slope and the number of pairs learned so far."""
    depth, size = changes.shape[0], solution.size
    if known and _learn(changes, shifts, gram, count % depth, min(count + 1, depth), last, solution, residual):
        count += 1
    step = np.empty(size)
    for i in range(size):
        step[i] = -solution[i]
    last[1] = residual
    last[2] = step
    if count > 0:
        _correct(changes, shifts, gram, min(count, depth), step)
    last[0] = step
    return step, inner(step, residual), count


class Axes(Protocol):
    """Axes in which the factorized matrix stays the same."""

    def into(self, vector: Array) -> Array:
        """A force in these axes, a new array of shape (size,)."""
        ...

    def out_of(self, vector: Array) -> Array:
        """A displacement in these axes back in the structure's, in place; the transpose of `into`."""
        ...


class AndersonAcceleration(Remembering):
    """Anderson acceleration in the energy norm of the factorized matrix K.

    From pairs (change of x, change of residual r) seen since the last factorization, the next step is the
    preconditioned one, ``-K^-1 r``, corrected so that the part of r spanned by the seen changes is removed exactly:
    ``gamma = argmin |r - dR gamma|`` in the norm of ``K^-1``. Pairs survive from one time step to the next, because
    the matrix does too.

    Parameters
    ----------
    depth
        Pairs kept.
    axes
        Where the matrix was factorized, and where pairs are kept; None for the structure's own.
    """

    MEMORY = ("_count", "_changes", "_shifts", "_gram")

    def __init__(self, depth: int = 6, axes: Axes | None = None) -> None:
        self._depth, self._axes = depth, axes
        self._reserve(0)
        self.clear()

    def _reserve(self, size: int) -> None:
        self._changes, self._shifts = np.zeros((2, self._depth, size))
        self._gram, self._last = np.eye(self._depth), np.zeros((3, size))

    def recall(self, memory: Memory) -> None:
        """Remember the pairs of another one between two solutions."""
        super().recall(memory)
        self._last = np.zeros((3, self._changes.shape[1]))

    def parts(self, size: int) -> tuple[Array, Array, Array, Array]:
        """What `propose_step` reads and writes, for vectors of a size."""
        if self._last.shape[1] != size:
            self._reserve(size)
        return self._changes, self._shifts, self._gram, self._last

    @property
    def learned(self) -> int:
        """Pairs learned since `clear`."""
        return self._count

    @learned.setter
    def learned(self, count: int) -> None:
        self._count = count

    def clear(self) -> None:
        """Forget everything (after a refactorization)."""
        self._count = 0
        self.begin()

    def begin(self) -> None:
        """Begin a new solution: the next proposal does not follow from the last one."""
        self._known = False

    def propose(self, solve: Callable[[Array], Array], residual: Array) -> tuple[Array, float]:
        """Learn from the step proposed last, if it was taken, and propose the next one.

        Parameters
        ----------
        solve
            Applies ``K^-1``.
        residual
            At the point where the last proposal led, shape (size,).

        Returns
        -------
        step
            Shape (size,).
        slope
            ``step . residual``, the slope of the potential along the step.
        """
        if self._axes is not None:
            residual = self._axes.into(residual)
        solution = solve(residual)
        changes, shifts, gram, last = self.parts(residual.size)
        step, slope, self._count = propose_step(
            changes, shifts, gram, self._count, self._known, last, solution, residual
        )
        self._known = self._depth > 0
        return step if self._axes is None else self._axes.out_of(step), slope

    def shorten(self, fraction: float) -> None:
        """Only this part of the last proposal was taken."""
        self._last[0] *= fraction
