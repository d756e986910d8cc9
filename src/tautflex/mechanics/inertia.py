r"""One inertia operator for all elements [theory.md 3].

``M(Z) = int rho N' Z N`` is linear in the 3x3 matrix Z, so nine constant sparse matrices and the moments
``int rho N_a' x_b`` and ``int rho N_a'`` give mass, gyroscopic, Euler, centrifugal and load terms for any motion:

    M = M(1) [paper (42)],  G = 2 M(S(w)) [paper (43)],  K_T = M(S(dw) + S(w)^2) [paper (44)],
    Q_T = int rho N' ((S(dw) + S(w)^2) x + a0) [paper (45)].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array

from tautflex.elements.block import InertiaPoints
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.mechanics.products import PairProducts, add_moments, add_pair_products, equal_lines
from tautflex.numeric import Array, Indices, Places, jit


class LoadMoments(Protocol):
    """What turns accelerations of the frame into loads, of a structure or of a reduced model."""

    @property
    def size(self) -> int:
        """Length of the load."""
        ...

    @property
    def first_moment(self) -> Array:
        """``int rho N_a' x_b``, shape (3, 3, size)."""
        ...

    @property
    def zeroth_moment(self) -> Array:
        """``int rho N_a'``, shape (3, size)."""
        ...

    def load(self, weight: ArrayLike, acceleration: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Load ``int rho N' (Z x + a)``, shape (size,)."""
        ...


class WeighedMoments:
    """Loads of any motion, shape (12, n), as ``int rho N_a' x_b`` and ``int rho N_a'``; of many instants too."""

    def __init__(self, loads: Array) -> None:
        self.first_moment, self.zeroth_moment, self.size = loads[:9].reshape(3, 3, -1), loads[9:], loads.shape[1]

    def load(self, weight: ArrayLike, acceleration: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Load ``Z : first + a . zeroth`` for weights (..., 3, 3) and accelerations (..., 3), shape (..., n)."""
        turning = np.einsum("...ab,abi->...i", np.asarray(weight), self.first_moment)
        return turning + np.asarray(acceleration) @ self.zeroth_moment


@jit
def _collect_moments(
    mass: Array, interpolation: Array, position: Array, places: Places, zeroth: Array, first: Array
) -> None:
    """Add ``int rho N_a'`` and ``int rho N_a' x_b`` of a block to arrays (3, size + 1) and (3, 3, size + 1)."""
    own = interpolation.shape[0] > 1
    for e in range(mass.shape[0]):
        for p in range(mass.shape[1]):
            shape = interpolation[e if own else 0, p]
            for a in range(3):
                for i in range(shape.shape[1]):
                    value = mass[e, p] * shape[a, i]
                    if value != 0.0:
                        zeroth[a, places[i, e]] += value
                        for b in range(3):
                            first[a, b, places[i, e]] += value * position[e, p, b]


@jit
def _collect_products(mass: Array, interpolation: Array, slots: Places, a: int, b: int, values: Array) -> None:
    """Add ``int rho N_a' N_b`` of a block to values in the pattern, shape (entries + 1,)."""
    own = interpolation.shape[0] > 1
    for e in range(mass.shape[0]):
        for p in range(mass.shape[1]):
            shape = interpolation[e if own else 0, p]
            for i in range(shape.shape[1]):
                weight = mass[e, p] * shape[a, i]
                if weight != 0.0:
                    for j in range(shape.shape[1]):
                        if shape[b, j] != 0.0:
                            values[slots[i, j, e]] += weight * shape[b, j]


@dataclass(frozen=True)
class InertiaOperator:
    """Constant inertia moments of a structure on its free unknowns.

    ``slots`` and ``values`` hold for each pair (a, b) the positions in the pattern and the values [kg, kg m, kg m^2] of
    ``int rho N_a' N_b``; ``first_moment`` is ``int rho N_a' x_b``, shape (3, 3, size) [kg m], ``zeroth_moment`` ``int
    rho N_a'``, shape (3, size) [kg]; of the whole structure there are ``mass`` [kg], ``mass_moment`` ``int rho x`` [kg
    m], shape (3,), and ``second_moment`` ``int rho x x'`` [kg m^2], shape (3, 3). Where sections turn by any angle, the
    values hold their `turning_terms` as well, and ``moving``, shape (entries,), is the mass M(1) without them.
    """

    pattern: SparsityPattern
    slots: list[list[NDArray[np.int32]]]
    values: list[list[Array]]
    first_moment: Array
    zeroth_moment: Array
    mass: float
    mass_moment: Array
    second_moment: Array
    moving: Array | None = None

    @classmethod
    def from_blocks(
        cls, inertias: Sequence[InertiaPoints], places: Sequence[Indices], pattern: SparsityPattern
    ) -> InertiaOperator:
        """Collect mass points of elements, whose unknowns have these places (element, dof) in the pattern."""
        first, zeroth = np.zeros((3, 3, pattern.size + 1)), np.zeros((3, pattern.size + 1))
        mass, moment, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for points, own in zip(inertias, places, strict=True):
            where = np.ascontiguousarray(own.T).astype(np.uint32)
            mass += float(points.mass.sum())
            moment += np.einsum("np,npk->k", points.mass, points.position)
            second += np.einsum("np,npk,npl->kl", points.mass, points.position, points.position)
            _collect_moments(points.mass, points.interpolation, points.position, where, zeroth, first)
        element_slots = [pattern.element_slots(own) for own in places]
        slots: list[list[NDArray[np.int32]]] = [[], [], []]
        values: list[list[Array]] = [[], [], []]
        turns = any(points.turning is not None for points in inertias)
        total, moving = np.empty(pattern.entries + 1), np.zeros(pattern.entries) if turns else None
        for a, b in np.ndindex(3, 3):
            total.fill(0.0)
            for points, where in zip(inertias, element_slots, strict=True):
                _collect_products(points.mass, points.interpolation, where, a, b, total)
            if moving is not None and a == b:
                moving += total[:-1]
            for points, where in zip(inertias, element_slots, strict=True):
                if points.turning is not None:
                    np.add.at(total, where, points.turning[:, a, b].transpose(1, 2, 0))
            slots[a].append(np.flatnonzero(total[:-1]).astype(np.int32))
            values[a].append(total[slots[a][b]])
        return cls(pattern, slots, values, first[:, :, :-1].copy(), zeroth[:, :-1].copy(), mass, moment, second, moving)

    @property
    def size(self) -> int:
        """Number of free unknowns."""
        return self.pattern.size

    def entries(self, weight: ArrayLike) -> Array:
        """Values of ``M(Z)`` in the pattern, shape (entries,), for a matrix Z of shape (3, 3)."""
        result = np.zeros(self.pattern.entries)
        z = np.asarray(weight, dtype=float)
        for a in range(3):
            for b in range(3):
                if z[a, b] != 0.0:
                    result[self.slots[a][b]] += z[a, b] * self.values[a][b]
        return result

    def matrix(self, weight: ArrayLike) -> csc_array:
        """``M(Z)`` as a sparse matrix on the free unknowns, shape (size, size)."""
        return self.pattern.matrix(self.entries(weight))

    @cached_property
    def pairs(self) -> tuple[NDArray[Any], ...]:
        """All nine products by rows, the parts of a `PairProducts`, for compiled code."""
        rows, columns = self.pattern.rows, self.pattern.columns
        lines, starts, others, values, entry = list[Places](), list[Indices](), list[Places](), list[Array](), 0
        for b, a in np.ndindex(3, 3):
            # M_ab is the transpose of M_ba, so the columns of that one, in which it is sorted, are rows here.
            slot = self.slots[b][a]
            line, begin = np.unique(columns[slot], return_index=True)
            lines.append(line.astype(np.uint32))
            starts.append(begin + entry)
            others.append(rows[slot].astype(np.uint32))
            values.append(self.values[b][a])
            entry += slot.size
        start = np.append(np.concatenate(starts), entry).astype(np.int64)
        column, value = np.concatenate(others), np.concatenate(values)
        limits = np.cumsum([0, *(line.size for line in lines)])
        which, kept = equal_lines(start, column, value, np.repeat(np.arange(3), np.diff(limits[::3])))
        length = np.diff(start)[kept]
        begin = np.concatenate([[0], np.cumsum(length)])
        entries = np.repeat(start[:-1][kept] - begin[:-1], length) + np.arange(begin[-1])
        whole = PairProducts(
            limits, np.concatenate(lines), which.astype(np.uint32), begin, column[entries], value[entries],
            np.searchsorted(kept, limits[::3]),
        )  # fmt: skip
        return tuple(whole)

    def apply(self, weight: ArrayLike, vector: Array) -> Array:
        """``M(Z) vector`` without forming the matrix, shape (size,); Z is mostly zeros for a fixed axis."""
        result = np.zeros(self.pattern.size)
        add_pair_products(self.pairs, np.asarray(weight, dtype=float), 1.0, np.ascontiguousarray(vector), result)
        return result

    @cached_property
    def mass_entries(self) -> Array:
        """Values of the mass matrix M(1) in the pattern."""
        return self.entries(np.eye(3)) if self.moving is None else self.moving

    @cached_property
    def mass_matrix(self) -> csr_array:
        """Mass matrix M(1) [kg, kg m, kg m^2] without stored zeros, shape (size, size)."""
        result = self.pattern.symmetric_matrix(self.mass_entries).copy()
        result.eliminate_zeros()
        return result

    def load(self, weight: ArrayLike, acceleration: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Inertial load ``int rho N' (Z x + a)`` [N, N m], shape (size,), for Z [1/s^2], shape (3, 3).

        ``acceleration`` is that of the frame's origin in its own axes [m/s^2], shape (3,).
        """
        result = np.zeros(self.pattern.size)
        add_moments(self.first_moment, np.asarray(weight, dtype=float), 1.0, result)
        for push, moment in zip(np.asarray(acceleration, dtype=float), self.zeroth_moment, strict=True):
            if push != 0.0:
                result += push * moment
        return result
