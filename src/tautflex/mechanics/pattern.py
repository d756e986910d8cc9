"""Fixed sparsity pattern of all square operators on the free unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, eye_array

from tautflex.numeric import Array, Indices, Places, jit

_ROUND_OFF = 1e-12


@jit
def find_slots(start: Any, rows: Any, row: Any, column: Any, slots: Any) -> None:
    """Place of every entry (row, column) in compressed columns with sorted rows; their number where either is none."""
    size = start.size - 1
    for k in range(slots.size):
        if row[k] >= size or column[k] >= size:
            slots[k] = rows.size
            continue
        low, high = start[column[k]], start[column[k] + 1]
        while low < high:
            middle = (low + high) // 2
            if rows[middle] < row[k]:
                low = middle + 1
            else:
                high = middle
        slots[k] = low


@dataclass(frozen=True)
class SparsityPattern:
    """Compressed-column pattern of ``size`` unknowns with sorted rows, symmetric in structure.

    ``column_start`` has shape (size + 1,), ``rows`` (entries,). ``memo`` is what solvers found out about parts of the
    pattern (fill-reducing orders), for all who share it.
    """

    size: int
    column_start: NDArray[np.int32]
    rows: NDArray[np.int32]
    memo: dict[bytes, dict[str, Any]] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def from_elements(cls, size: int, element_dofs: list[Indices]) -> SparsityPattern:
        """Union of the dense blocks of all elements; slots equal to ``size`` (supported unknowns) are left out."""
        free = [dofs < size for dofs in element_dofs]
        ends = np.cumsum(np.concatenate([[0], *(kept.sum(axis=1) for kept in free)]))
        columns = np.concatenate(
            [np.zeros(0, int), *(dofs[kept] for dofs, kept in zip(element_dofs, free, strict=True))]
        )
        incidence = csr_array((np.ones(len(columns), dtype=np.int32), columns, ends), shape=(len(ends) - 1, size))
        # The diagonal is always there, even of an unknown without elements.
        whole = csr_array(incidence.T @ incidence + eye_array(size, dtype=np.int32))
        whole.sort_indices()
        return cls(size, whole.indptr.astype(np.int32), whole.indices.astype(np.int32))

    @property
    def entries(self) -> int:
        """Number of stored entries."""
        return len(self.rows)

    @cached_property
    def columns(self) -> NDArray[np.int32]:
        """Column of every stored entry, shape (entries,)."""
        return np.repeat(np.arange(self.size, dtype=np.int32), np.diff(self.column_start))

    def slots(self, row: NDArray[np.integer], column: NDArray[np.integer]) -> Places:
        """Position of entries (row, column) in the value array; ``entries`` where either is supported.

        Entries that the pattern does not have are an error of the caller; their position is meaningless.
        """
        return _places(self.column_start, self.rows, row, column)

    def element_slots(self, dofs: Indices) -> Places:
        """Positions of the element matrices' entries, shape (dof, dof, element), for dofs (element, dof)."""
        return self.slots(dofs.T[:, None], dofs.T)

    def upper_slots(self, dofs: Indices) -> Places:
        """Positions in the upper triangle of the pairs (i, j <= i) of element unknowns, for dofs (element, dof).

        Shape (pair, element), pairs in the order (0, 0), (1, 0), (1, 1), (2, 0) ...
        """
        i, j = np.tril_indices(dofs.shape[1])
        one, other = dofs.T[i], dofs.T[j]
        return _places(*self.upper[1:], np.minimum(one, other), np.maximum(one, other))

    def matrix(self, values: Array) -> csc_array:
        """Sparse matrix (entries,) -> (size, size) that shares this pattern's index arrays."""
        return self._compressed(csc_array, values)

    def symmetric_matrix(self, values: Array) -> csr_array:
        """Symmetric matrix in compressed rows, whose product with a vector is faster; index arrays are shared."""
        return self._compressed(csr_array, values)

    def _compressed(self, kind: type[Any], values: Array) -> Any:
        result = kind((values, self.rows, self.column_start), shape=(self.size, self.size), copy=False)
        result.has_sorted_indices = result.has_canonical_format = True
        return result

    @cached_property
    def transpose_slots(self) -> Places:
        """Position of (j, i) for every stored (i, j)."""
        return self.slots(self.columns, self.rows)

    def is_symmetric(self, values: Array) -> bool:
        """Whether a matrix is symmetric but for the round-off of its largest entry."""
        skew = np.abs(values - values[self.transpose_slots]).max(initial=0.0)
        return bool(skew <= _ROUND_OFF * np.abs(values).max(initial=0.0))

    @cached_property
    def upper(self) -> tuple[Indices, NDArray[np.int32], NDArray[np.int32]]:
        """Positions, column starts and rows of the upper triangle."""
        keep = np.flatnonzero(self.rows <= self.columns)
        start = np.searchsorted(self.columns[keep], np.arange(self.size + 1))
        return keep, start.astype(np.int32), self.rows[keep]

    @cached_property
    def from_upper(self) -> Places:
        """Position in the upper triangle of every stored entry of a symmetric matrix, shape (entries,)."""
        keep, _, _ = self.upper
        place = np.empty(self.entries, dtype=np.uint32)
        place[keep] = np.arange(len(keep))
        lower = np.flatnonzero(self.rows > self.columns)
        place[lower] = place[self.transpose_slots[lower]]
        return place

    @cached_property
    def upper_diagonal(self) -> Indices:
        """Position in the upper triangle of the diagonal: the last entry of every column, shape (size,)."""
        return self.upper[1][1:].astype(np.int64) - 1

    @cached_property
    def diagonal(self) -> Indices:
        """Position of the diagonal, shape (size,)."""
        return self.upper[0][self.upper_diagonal]


def _places(start: NDArray[np.int32], rows: NDArray[np.int32], row: Any, column: Any) -> Places:
    every = np.broadcast_arrays(row, column)
    slots = np.empty(every[0].shape, dtype=np.uint32)
    find_slots(start, rows, *(array.astype(np.int32, order="C").ravel() for array in every), slots.reshape(-1))
    return slots
