"""Compiled forward and backward substitution with L D L' factors, by panels.

Columns of L that share their rows below a dense triangle form a panel (supernode): three at least, because the
unknowns of a node share their neighbours, and many more near the end of the elimination. Within a panel row numbers
are read once and the rest are products of contiguous stretches of the stored columns, which the compiler turns into
vector instructions. The columns are used as they are stored: nothing is copied.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.numeric import Array, Indices, jit


@jit
def add_columns(start: Indices, values: Array, x: Array, first: int, width: int, below: int, result: Array) -> None:
    """Add the last ``below`` entries of columns of L, times a factor each, to ``result``."""
    j, end = first, first + width
    while j + 6 <= end:
        c0, c1 = values[start[j + 1] - below : start[j + 1]], values[start[j + 2] - below : start[j + 2]]
        c2, c3 = values[start[j + 3] - below : start[j + 3]], values[start[j + 4] - below : start[j + 4]]
        c4, c5 = values[start[j + 5] - below : start[j + 5]], values[start[j + 6] - below : start[j + 6]]
        f0, f1, f2, f3, f4, f5 = x[j], x[j + 1], x[j + 2], x[j + 3], x[j + 4], x[j + 5]
        for i in range(below):
            result[i] += f0 * c0[i] + f1 * c1[i] + f2 * c2[i] + f3 * c3[i] + f4 * c4[i] + f5 * c5[i]
        j += 6
    while j + 3 <= end:
        c0, f0 = values[start[j + 1] - below : start[j + 1]], x[j]
        c1, f1 = values[start[j + 2] - below : start[j + 2]], x[j + 1]
        c2, f2 = values[start[j + 3] - below : start[j + 3]], x[j + 2]
        for i in range(below):
            result[i] += f0 * c0[i] + f1 * c1[i] + f2 * c2[i]
        j += 3
    while j < end:
        column, factor = values[start[j + 1] - below : start[j + 1]], x[j]
        for i in range(below):
            result[i] += factor * column[i]
        j += 1


@jit
def _subtract_products(
    start: Indices, values: Array, known: Array, first: int, width: int, below: int, x: Array
) -> None:
    """Subtract the products of the panel's columns below its triangle with known unknowns."""
    j, end = first, first + width
    while j + 3 <= end:
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
    while j < end:
        column, total = values[start[j + 1] - below : start[j + 1]], 0.0
        for i in range(below):
            total += known[i] * column[i]
        x[j] -= total
        j += 1


@jit
def substitute(pattern: Any, values: Array, inverse: Array, right: Array) -> Array:
    """Solution for one right-hand side, shape (size,), with the factors of a matrix.

    ``pattern`` holds the parts of a `PanelPattern`, ``values`` the entries of L, ``inverse`` the reciprocal pivots,
    shape (size,).
    """
    order, start, rows, panels, _, _, longest = pattern
    size = order.size
    x, part = np.empty(size), np.empty(longest)
    for i in range(size):
        x[i] = right[order[i]]
    for panel in range(panels.size - 1):
        first, width = panels[panel], panels[panel + 1] - panels[panel]
        last = first + width - 1
        below = start[last + 1] - start[last]
        own = rows[start[last] : start[last + 1]]
        for j in range(first, last):
            factor, length = x[j], last - j
            column, target = values[start[j] : start[j] + length], x[j + 1 : last + 1]
            for i in range(length):
                target[i] -= factor * column[i]
        if width == 3:
            c0, f0 = values[start[first + 1] - below : start[first + 1]], x[first]
            c1, f1 = values[start[first + 2] - below : start[first + 2]], x[first + 1]
            c2, f2 = values[start[first + 3] - below : start[first + 3]], x[first + 2]
            for i in range(below):
                x[own[i]] -= f0 * c0[i] + f1 * c1[i] + f2 * c2[i]
            continue
        result = part[:below]
        result[:] = 0.0
        add_columns(start, values, x, first, width, below, result)
        for i in range(below):
            x[own[i]] -= result[i]
    for i in range(size):
        x[i] *= inverse[i]
    for panel in range(panels.size - 2, -1, -1):
        first, width = panels[panel], panels[panel + 1] - panels[panel]
        last = first + width - 1
        below = start[last + 1] - start[last]
        own = rows[start[last] : start[last + 1]]
        if width == 3:
            c0 = values[start[first + 1] - below : start[first + 1]]
            c1 = values[start[first + 2] - below : start[first + 2]]
            c2 = values[start[first + 3] - below : start[first + 3]]
            t0, t1, t2 = x[first], x[first + 1], x[first + 2]
            for i in range(below):
                value = x[own[i]]
                t0 -= value * c0[i]
                t1 -= value * c1[i]
                t2 -= value * c2[i]
            k = start[first]
            t1 -= values[start[first + 1]] * t2
            x[first] = t0 - values[k] * t1 - values[k + 1] * t2
            x[first + 1] = t1
            x[first + 2] = t2
            continue
        known = part[:below]
        for i in range(below):
            known[i] = x[own[i]]
        _subtract_products(start, values, known, first, width, below, x)
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
