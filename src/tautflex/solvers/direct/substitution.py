"""Compiled forward and backward substitution with L D L' factors, by panels.

Columns of L that share their rows below a dense triangle form a panel (supernode): three at least, because the
unknowns of a node share their neighbours, and many more near the end of the elimination. Within a panel row numbers
are read once and the rest are products of contiguous stretches of the stored columns, which the compiler turns into
vector instructions. The columns are used as they are stored: nothing is copied.
"""

from __future__ import annotations

from collections.abc import Sequence

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_matrix

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_jit = numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"}, error_model="numpy")


@_jit
def _find_panels(start: Indices, rows: NDArray[np.int32]) -> Indices:
    """First columns of the panels, with the number of columns behind them."""
    size = start.size - 1
    first, count = np.empty(size + 1, dtype=np.int64), 0
    for j in range(size):
        begins = True
        if j > 0:
            before = start[j] - start[j - 1]
            # The rows below a column's first one are among those of the column that this one names (its parent).
            begins = before != start[j + 1] - start[j] + 1 or rows[start[j - 1]] != j
        if begins:
            first[count] = j
            count += 1
    first[count] = size
    return first[: count + 1].copy()


@_jit
def _substitute(
    panels: Indices, start: Indices, rows: NDArray[np.uint32], values: Array, inverse: Array,
    order: NDArray[np.uint32], widest: int, right: Array,
) -> Array:  # fmt: skip
    size = order.size
    x, part = np.empty(size), np.empty(widest)
    for i in range(size):
        x[i] = right[order[i]]
    for panel in range(panels.size - 1):
        first, last = panels[panel], panels[panel + 1] - 1
        below = start[last + 1] - start[last]
        own = rows[start[last] : start[last + 1]]
        for j in range(first, last):
            factor, length = x[j], last - j
            column, target = values[start[j] : start[j] + length], x[j + 1 : last + 1]
            for i in range(length):
                target[i] -= factor * column[i]
        result = part[:below]
        j, left = first, (last + 1 - first) % 3
        result[:] = 0.0
        for _ in range(left):
            column, factor = values[start[j + 1] - below : start[j + 1]], x[j]
            for i in range(below):
                result[i] += factor * column[i]
            j += 1
        while j <= last:
            c0, f0 = values[start[j + 1] - below : start[j + 1]], x[j]
            c1, f1 = values[start[j + 2] - below : start[j + 2]], x[j + 1]
            c2, f2 = values[start[j + 3] - below : start[j + 3]], x[j + 2]
            for i in range(below):
                result[i] += f0 * c0[i] + f1 * c1[i] + f2 * c2[i]
            j += 3
        for i in range(below):
            x[own[i]] -= result[i]
    for i in range(size):
        x[i] *= inverse[i]
    for panel in range(panels.size - 2, -1, -1):
        first, last = panels[panel], panels[panel + 1] - 1
        below = start[last + 1] - start[last]
        own, known = rows[start[last] : start[last + 1]], part[:below]
        for i in range(below):
            known[i] = x[own[i]]
        j, left = first, (last + 1 - first) % 3
        for _ in range(left):
            column, total = values[start[j + 1] - below : start[j + 1]], 0.0
            for i in range(below):
                total += known[i] * column[i]
            x[j] -= total
            j += 1
        while j <= last:
            c0 = values[start[j + 1] - below : start[j + 1]]
            c1 = values[start[j + 2] - below : start[j + 2]]
            c2 = values[start[j + 3] - below : start[j + 3]]
            t0, t1, t2 = 0.0, 0.0, 0.0
            for i in range(below):
                t0 += known[i] * c0[i]
                t1 += known[i] * c1[i]
                t2 += known[i] * c2[i]
            x[j] -= t0
            x[j + 1] -= t1
            x[j + 2] -= t2
            j += 3
        for j in range(last - 1, first - 1, -1):
            length, total = last - j, 0.0
            column, above = values[start[j] : start[j] + length], x[j + 1 : last + 1]
            for i in range(length):
                total += column[i] * above[i]
            x[j] -= total
    result = np.empty(size)
    for i in range(size):
        result[order[i]] = x[i]
    return result


class Substitution:
    """Solves with ``P L D L' P'`` whose pattern stays.

    Parameters
    ----------
    lower
        Strictly lower triangle of L, rows sorted within each column.
    order
        Row of the matrix that stands at each place of L, shape (size,).
    """

    def __init__(self, lower: csc_matrix, order: Sequence[int]) -> None:
        self._start = lower.indptr.astype(np.int64)
        self._panels = _find_panels(self._start, lower.indices)
        self._rows = lower.indices.astype(np.uint32)
        self._order = np.asarray(order, dtype=np.uint32)
        last = self._panels[1:] - 1
        self._widest = int((self._start[last + 1] - self._start[last]).max(initial=0))

    def set(self, values: Array, diagonal: ArrayLike) -> None:
        """Take the values of L and D, shapes (entries of L,) and (size,)."""
        self._values, self._inverse = values, 1.0 / np.asarray(diagonal)

    def solve(self, right: Array) -> Array:
        """Solve for one right-hand side, shape (size,)."""
        solution: Array = _substitute(
            self._panels, self._start, self._rows, self._values, self._inverse, self._order, self._widest,
            np.ascontiguousarray(right, dtype=float),
        )  # fmt: skip
        return solution
