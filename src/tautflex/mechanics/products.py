"""Compiled products of sparse matrices with vectors; the matrices stay as flat arrays.

A SciPy product costs as much in Python as a small mesh's whole force evaluation, and several products over the same
pattern can share one walk through it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.uint32]

_jit = numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"}, error_model="numpy")


class PairProducts(NamedTuple):
    """The nine matrices ``int rho N_a' N_b`` of an inertia operator, stored by their non-empty rows.

    ``first[3 a + b]`` is the first line of pair (a, b) in ``line`` (its row number) and ``start`` (its entries).
    """

    first: NDArray[np.int64]
    line: Places
    start: NDArray[np.int64]
    column: Places
    value: Array


@_jit
def add_pair_products(pairs: Any, weight: Array, factor: float, vector: Array, result: Array) -> None:
    """Add ``factor M(weight) vector`` to ``result``; ``pairs`` holds the parts of a `PairProducts`."""
    first, line, start, column, value = pairs
    for a in range(3):
        for b in range(3):
            z = factor * weight[a, b]
            if z != 0.0:
                for k in range(first[3 * a + b], first[3 * a + b + 1]):
                    total = 0.0
                    for entry in range(np.uint64(start[k]), np.uint64(start[k + 1])):
                        total += value[entry] * vector[column[entry]]
                    result[line[k]] += z * total


@_jit
def add_moments(moment: Array, weight: Array, factor: float, result: Array) -> None:
    """Add ``factor sum_ab weight_ab moment_ab`` to ``result``; ``moment`` has shape (3, 3, size)."""
    for a in range(3):
        for b in range(3):
            z = factor * weight[a, b]
            if z != 0.0:
                row = moment[a, b]
                for i in range(result.size):
                    result[i] += z * row[i]


@_jit
def product(start: NDArray[np.int64], column: Places, value: Array, vector: Array) -> Array:
    """Matrix in compressed rows times vector, shape (rows,)."""
    result = np.empty(start.size - 1)
    for i in range(result.size):
        total = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += value[k] * vector[column[k]]
        result[i] = total
    return result


@_jit
def quadratic_form(start: NDArray[np.int64], column: Places, value: Array, vector: Array) -> float:
    """``vector' A vector`` of a matrix in compressed rows."""
    result = 0.0
    for i in range(start.size - 1):
        total = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += value[k] * vector[column[k]]
        result += vector[i] * total
    return result
