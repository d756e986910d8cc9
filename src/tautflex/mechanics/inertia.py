r"""One inertia operator for all elements [theory.md 3].

``M(Z) = int rho N' Z N`` is linear in the 3x3 matrix Z, so nine constant sparse matrices and the moments
``int rho N_a' x_b`` and ``int rho N_a'`` give mass, gyroscopic, Euler, centrifugal and load terms for any motion:

    M = M(1) [paper (42)],  G = 2 M(S(w)) [paper (43)],  K_T = M(S(dw) + S(w)^2) [paper (44)],
    Q_T = int rho N' ((S(dw) + S(w)^2) x + a0) [paper (45)].
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_array, csr_array

from tautflex.elements.block import ElementBlock
from tautflex.mechanics.pattern import SparsityPattern

Array = NDArray[np.float64]
Indices = NDArray[np.int32]

_CHUNK = 4096


def cross_matrix(vector: ArrayLike) -> Array:
    """Matrix S(v) with S(v) a = v x a, shape (3, 3)."""
    x, y, z = np.asarray(vector, dtype=float)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


class LoadMoments(Protocol):
    """What turns accelerations of the frame into loads, of a structure or of a reduced model."""

    @property
    def size(self) -> int:
        """Length of the load."""
        ...

    def load(self, weight: ArrayLike, acceleration: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Load ``int rho N' (Z x + a)``, shape (size,)."""
        ...


@numba.njit(cache=True)
def _add_product(factor: float, rows: Indices, columns: Indices, values: Array, vector: Array, result: Array) -> None:
    for k in range(values.size):
        result[rows[k]] += factor * values[k] * vector[columns[k]]


@dataclass(frozen=True)
class InertiaOperator:
    """Constant inertia moments of a structure on its free unknowns.

    Parameters
    ----------
    pattern
        Sparsity pattern of the free unknowns.
    slots, values
        For each pair (a, b): positions in the pattern and values [kg, kg m, kg m^2] of ``int rho N_a' N_b``.
    first_moment
        ``int rho N_a' x_b``, shape (3, 3, size) [kg m].
    zeroth_moment
        ``int rho N_a'``, shape (3, size) [kg].
    mass
        Total mass [kg].
    mass_moment
        ``int rho x`` [kg m], shape (3,).
    second_moment
        ``int rho x x'`` [kg m^2], shape (3, 3).
    """

    pattern: SparsityPattern
    slots: tuple[tuple[NDArray[np.int64], ...], ...]
    values: tuple[tuple[Array, ...], ...]
    first_moment: Array
    zeroth_moment: Array
    mass: float
    mass_moment: Array
    second_moment: Array

    @classmethod
    def from_blocks(
        cls, blocks: tuple[ElementBlock, ...], dofs: list[NDArray[np.int64]], pattern: SparsityPattern
    ) -> InertiaOperator:
        """Collect the mass points of all blocks; ``dofs`` maps element unknowns to extended slots."""
        size = pattern.size
        first, zeroth = np.zeros((3, 3, size + 1)), np.zeros((3, size + 1))
        sums = [[np.zeros(pattern.entries + 1) for _ in range(3)] for _ in range(3)]
        mass, moment, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for block, block_dofs in zip(blocks, dofs, strict=True):
            points = block.inertia
            mass += float(points.mass.sum())
            moment += np.einsum("np,npk->k", points.mass, points.position)
            second += np.einsum("np,npk,npl->kl", points.mass, points.position, points.position)
            used = [np.flatnonzero(np.any(points.interpolation[:, :, a] != 0.0, axis=(0, 1))) for a in range(3)]
            for start in range(0, len(block_dofs), _CHUNK):
                part = slice(start, start + _CHUNK)
                weight, places = points.mass[part], block_dofs[part]
                shapes = points.interpolation
                shapes = shapes if len(shapes) == 1 else shapes[part]
                shapes = np.broadcast_to(shapes, (len(places), *shapes.shape[1:]))
                for a in range(3):
                    row = shapes[:, :, a][:, :, used[a]]
                    row_dofs = places[:, used[a]]
                    np.add.at(zeroth[a], row_dofs, np.einsum("np,npi->ni", weight, row))
                    for b in range(3):
                        lever = weight * points.position[part, :, b]
                        np.add.at(first[a, b], row_dofs, np.einsum("np,npi->ni", lever, row))
                        column = shapes[:, :, b][:, :, used[b]]
                        product = np.einsum("np,npi,npj->nij", weight, row, column)
                        slot = pattern.slots(row_dofs[:, :, None], places[:, used[b]][:, None, :])
                        np.add.at(sums[a][b], slot.ravel(), product.ravel())
        kept = [[np.flatnonzero(sums[a][b][:-1]) for b in range(3)] for a in range(3)]
        return cls(
            pattern,
            tuple(tuple(row) for row in kept),
            tuple(tuple(sums[a][b][kept[a][b]] for b in range(3)) for a in range(3)),
            first[:, :, :-1].copy(),
            zeroth[:, :-1].copy(),
            mass,
            moment,
            second,
        )

    @property
    def size(self) -> int:
        """Number of free unknowns."""
        return self.pattern.size

    def entries(self, weight: ArrayLike) -> Array:
        """Values of ``M(Z)`` in the pattern.

        Parameters
        ----------
        weight
            The matrix Z, shape (3, 3).

        Returns
        -------
        numpy.ndarray
            Shape (entries,).
        """
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
    def _rows_and_columns(self) -> tuple[tuple[tuple[NDArray[np.int32], NDArray[np.int32]], ...], ...]:
        rows, columns = self.pattern.rows, self.pattern.columns
        return tuple(tuple((rows[slot], columns[slot]) for slot in line) for line in self.slots)

    def apply(self, weight: ArrayLike, vector: Array) -> Array:
        """``M(Z) vector`` without forming the matrix, shape (size,); Z is mostly zeros for a fixed axis."""
        result = np.zeros(self.pattern.size)
        z = np.asarray(weight, dtype=float)
        for a in range(3):
            for b in range(3):
                if z[a, b] != 0.0:
                    _add_product(z[a, b], *self._rows_and_columns[a][b], self.values[a][b], vector, result)
        return result

    @cached_property
    def mass_entries(self) -> Array:
        """Values of the mass matrix M(1) in the pattern."""
        return self.entries(np.eye(3))

    @cached_property
    def mass_matrix(self) -> csr_array:
        """Mass matrix M(1) [kg, kg m, kg m^2] without stored zeros, shape (size, size)."""
        result = self.pattern.symmetric_matrix(self.mass_entries).copy()
        result.eliminate_zeros()
        return result

    def load(self, weight: ArrayLike, acceleration: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """Inertial load ``int rho N' (Z x + a)`` [N, N m], shape (size,).

        Parameters
        ----------
        weight
            The matrix Z [1/s^2], shape (3, 3).
        acceleration
            Acceleration of the frame's origin in its own axes [m/s^2], shape (3,).
        """
        z = np.asarray(weight, dtype=float)
        return np.einsum("ab,abi->i", z, self.first_moment) + np.asarray(acceleration) @ self.zeroth_moment
