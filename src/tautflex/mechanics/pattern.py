"""Fixed sparsity pattern of all square operators on the free unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SparsityPattern:
    """Compressed-column pattern with sorted rows, symmetric in structure.

    Parameters
    ----------
    size
        Number of free unknowns.
    column_start, rows
        Compressed-column index arrays, shapes (size + 1,) and (entries,).
    """

    size: int
    column_start: NDArray[np.int32]
    rows: NDArray[np.int32]

    @classmethod
    def from_elements(cls, size: int, element_dofs: list[NDArray[np.int64]]) -> SparsityPattern:
        """Union of the dense blocks of all elements; slots equal to ``size`` (supported unknowns) are left out."""
        keys = [np.arange(size, dtype=np.int64) * (size + 1)]
        for dofs in element_dofs:
            row, column = dofs[:, :, None], dofs[:, None, :]
            inside = (row < size) & (column < size)
            keys.append(np.unique((column * np.int64(size) + row)[inside]))
        entries = np.unique(np.concatenate(keys))
        columns, rows = entries // size, entries % size
        start = np.searchsorted(columns, np.arange(size + 1))
        return cls(size, start.astype(np.int32), rows.astype(np.int32))

    @property
    def entries(self) -> int:
        """Number of stored entries."""
        return len(self.rows)

    @cached_property
    def columns(self) -> NDArray[np.int32]:
        """Column of every stored entry, shape (entries,)."""
        return np.repeat(np.arange(self.size, dtype=np.int32), np.diff(self.column_start))

    @cached_property
    def _keys(self) -> NDArray[np.int64]:
        return self.columns.astype(np.int64) * self.size + self.rows

    def slots(self, row: NDArray[np.int64], column: NDArray[np.int64]) -> NDArray[np.int64]:
        """Position of entries (row, column) in the value array; ``entries`` where either is supported."""
        row, column = np.broadcast_arrays(row, column)
        inside = (row < self.size) & (column < self.size)
        slots = np.full(row.shape, self.entries, dtype=np.int64)
        slots[inside] = np.searchsorted(self._keys, column[inside] * np.int64(self.size) + row[inside])
        return slots

    def matrix(self, values: Array) -> csc_array:
        """Sparse matrix (entries,) -> (size, size) that shares this pattern's index arrays."""
        result = csc_array((values, self.rows, self.column_start), shape=(self.size, self.size), copy=False)
        result.has_sorted_indices = True
        result.has_canonical_format = True
        return result

    def symmetric_matrix(self, values: Array) -> csr_array:
        """Symmetric matrix in compressed rows, whose product with a vector is faster; index arrays are shared."""
        result = csr_array((values, self.rows, self.column_start), shape=(self.size, self.size), copy=False)
        result.has_sorted_indices = True
        result.has_canonical_format = True
        return result

    @cached_property
    def transpose_slots(self) -> NDArray[np.int64]:
        """Position of (j, i) for every stored (i, j)."""
        return self.slots(self.columns.astype(np.int64), self.rows.astype(np.int64))

    @cached_property
    def upper(self) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int32]]:
        """Positions, column starts and rows of the upper triangle."""
        keep = np.flatnonzero(self.rows <= self.columns)
        start = np.searchsorted(self.columns[keep], np.arange(self.size + 1))
        return keep, start.astype(np.int32), self.rows[keep]

    def upper_matrix(self, values: Array) -> csc_array:
        """Upper triangle of a symmetric matrix given by its values."""
        keep, start, rows = self.upper
        result = csc_array((values[keep], rows, start), shape=(self.size, self.size), copy=False)
        result.has_sorted_indices = True
        return result
