"""Compiled products of sparse matrices with vectors; the matrices stay as flat arrays.

A SciPy product costs as much in Python as a small mesh's whole force evaluation, and several products over the same
pattern can share one walk through it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array, Indices, Places, jit


class PairProducts(NamedTuple):
    """The nine matrices ``int rho N_a' N_b`` of an inertia operator, stored by their non-empty rows.

    ``first[a + 3 b]`` is the first line of pair (a, b) in ``line`` (its row number) and ``which`` (the product that it
    is); ``start`` is that of a product's entries in ``column`` and ``value``, ``source[b]`` the first product of
    direction b. The three directions of a node that only moves share theirs.
    """

    first: Indices
    line: Places
    which: Places
    start: Indices
    column: Places
    value: Array
    source: Indices


def equal_lines(start: Indices, column: Places, value: Array, part: Indices) -> tuple[Indices, Indices]:
    """Which different line each one is, and where each of these is first, of non-empty lines of sparse matrices.

    ``part`` numbers parts of the lines, shape (line,); equal ones of two parts count as different.
    """
    mixed = (column.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15) ^ value.view(np.uint64)
    mixed = (mixed ^ mixed >> np.uint64(29)) * np.uint64(0xBF58476D1CE4E5B9)
    marks = np.add.reduceat(mixed ^ mixed >> np.uint64(32), start[:-1]) if part.size else mixed
    _, first, which = np.unique(
        np.stack([part.astype(np.uint64), marks]), axis=1, return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    kept, rank = first[order], np.argsort(order)
    which, length = rank[which.ravel()], np.diff(start)
    own = kept[which]
    same = np.array_equal(length[own], length)
    if same:
        twin = np.repeat(start[:-1][own] - start[:-1], length) + np.arange(column.size)
        same = np.array_equal(column[twin], column) and np.array_equal(value[twin], value)
    return (which, kept) if same else (np.arange(part.size), np.arange(part.size))


@jit
def inner(a: Array, b: Array) -> float:
    """``a' b``, summed in four parts, which take turns."""
    s0, s1, s2, s3, whole = 0.0, 0.0, 0.0, 0.0, a.size - a.size % 4
    for i in range(0, whole, 4):
        s0 += a[i] * b[i]
        s1 += a[i + 1] * b[i + 1]
        s2 += a[i + 2] * b[i + 2]
        s3 += a[i + 3] * b[i + 3]
    for i in range(whole, a.size):
        s0 += a[i] * b[i]
    return (s0 + s1) + (s2 + s3)


@jit
def add_pair_products(pairs: Any, weight: Array, factor: float, vector: Array, result: Array) -> None:
    """Add ``factor M(weight) vector`` to ``result``; ``pairs`` holds the parts of a `PairProducts`."""
    first, line, which, start, column, value, source = pairs
    totals = np.empty(start.size - 1)
    for b in range(3):
        if weight[0, b] == 0.0 and weight[1, b] == 0.0 and weight[2, b] == 0.0:
            continue
        for k in range(source[b], source[b + 1]):
            total = 0.0
            for entry in range(np.uint64(start[k]), np.uint64(start[k + 1])):
                total += value[entry] * vector[column[entry]]
            totals[k] = total
        for a in range(3):
            z = factor * weight[a, b]
            if z != 0.0:
                for k in range(first[a + 3 * b], first[a + 3 * b + 1]):
                    result[line[k]] += z * totals[which[k]]


@jit
def add_two_pair_products(pairs: Any, weight: Array, vector: Array, other: Array, second: Array, result: Array) -> None:
    """Add ``M(weight) vector + M(other) second`` to ``result``: one walk for both."""
    first, line, which, start, column, value, source = pairs
    totals = np.empty((2, start.size - 1))
    for b in range(3):
        if not (np.any(weight[:, b] != 0.0) or np.any(other[:, b] != 0.0)):
            continue
        for k in range(source[b], source[b + 1]):
            total, more = 0.0, 0.0
            for entry in range(np.uint64(start[k]), np.uint64(start[k + 1])):
                total += value[entry] * vector[column[entry]]
                more += value[entry] * second[column[entry]]
            totals[0, k], totals[1, k] = total, more
        for a in range(3):
            y, z = weight[a, b], other[a, b]
            if y != 0.0 or z != 0.0:
                for k in range(first[a + 3 * b], first[a + 3 * b + 1]):
                    result[line[k]] += y * totals[0, which[k]] + z * totals[1, which[k]]


@jit
def add_moments(moment: Array, weight: Array, factor: float, result: Array) -> None:
    """Add ``factor sum_ab weight_ab moment_ab`` to ``result``; ``moment`` has shape (3, 3, size)."""
    for a in range(3):
        for b in range(3):
            z = factor * weight[a, b]
            if z != 0.0:
                row = moment[a, b]
                for i in range(result.size):
                    result[i] += z * row[i]


@jit
def product(start: Indices, column: Places, value: Array, vector: Array) -> Array:
    """Matrix in compressed rows times vector, shape (rows,)."""
    result = np.empty(start.size - 1)
    for i in range(result.size):
        total = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += value[k] * vector[column[k]]
        result[i] = total
    return result


@jit
def quadratic_form(start: Indices, column: Places, value: Array, vector: Array) -> float:
    """``vector' A vector`` of a matrix in compressed rows."""
    result = 0.0
    for i in range(start.size - 1):
        total = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += value[k] * vector[column[k]]
        result += vector[i] * total
    return result


@jit
def add_low_rank(vectors: Array, coefficients: Array, factor: float, vector: Array, result: Array) -> None:
    """Add ``factor sum_k coefficients_k v_k v_k' vector`` to ``result``, for v of shape (rank, size)."""
    for k in range(vectors.shape[0]):
        row = vectors[k]
        total = factor * coefficients[k] * inner(row, vector)
        for i in range(vector.size):
            result[i] += total * row[i]


class MassDamping:
    """Symmetric mass and damping matrices of a run, in compressed rows and, for a few vectors, beside them.

    ``start``, ``column``, ``mass`` and ``damping`` are compressed rows of the entries where mass or proportional
    damping is not zero, so that one walk gives both forces: transverse and in-plane unknowns of a flat film, for one,
    do not meet here. ``spread`` tells whether there is proportional damping, ``damped`` whether there is any;
    ``vectors``, shape (rank, size), and ``coefficients``, shape (rank,), hold the rest of C. It is made from values of
    mass and stiffness in a pattern, those of the reference, shape (entries,), and where kinds of element are damped
    differently, from those of each kind.
    """

    def __init__(
        self,
        pattern: SparsityPattern,
        mass: Array,
        stiffness: Array,
        damping: DampingMatrix,
        kinds: Mapping[str, tuple[Array, Array]] | None = None,
    ) -> None:
        self.matrix: DampingMatrix = damping
        self.entries: Array = damping.proportional(mass, stiffness, kinds or {})
        self.vectors = np.ascontiguousarray(damping.vectors, dtype=np.float64)
        self.coefficients = np.ascontiguousarray(damping.coefficients, dtype=np.float64)
        kept = (mass != 0.0) | (self.entries != 0.0)
        before = np.concatenate([[0], np.cumsum(kept)])
        # Symmetric: the pattern's columns are rows as well.
        self.start = before[pattern.column_start].astype(np.int64)
        self.column = pattern.rows[kept].astype(np.uint32)
        self.mass, self.damping = mass[kept], self.entries[kept]
        self.spread = bool(self.damping.any())
        self.damped = self.spread or bool(damping.coefficients.any())

    def combined(self, mass: float, damping: float) -> Array:
        """Values of ``mass M + damping C`` without the vectors' part of C."""
        return mass * self.mass + damping * self.damping

    def mass_product(self, vector: Array) -> Array:
        """``M vector``, shape (size,)."""
        return product(self.start, self.column, self.mass, vector)

    def damping_product(self, vector: Array) -> Array:
        """``C vector``, shape (size,)."""
        result = product(self.start, self.column, self.damping, vector)
        if self.matrix.rank:
            self.add_low_rank(1.0, vector, result)
        return result

    def add_low_rank(self, factor: float, vector: Array, result: Array) -> None:
        """Add ``factor`` times the vectors' part of ``C vector`` to ``result``."""
        add_low_rank(self.vectors, self.coefficients, factor, vector, result)

    def mass_norm(self, vector: Array) -> float:
        """``vector' M vector``."""
        return float(quadratic_form(self.start, self.column, self.mass, vector))
