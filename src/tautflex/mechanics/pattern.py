"""Fixed sparsity pattern of all square operators on the free unknowns."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array

from tautflex.numeric import Array, Indices, Places, jit_in_order

_ROUND_OFF = 1e-12


@jit_in_order
def _elements_of_unknowns(size: int, first: Indices, dofs: Indices) -> tuple[Indices, Indices]:
    """Elements that each unknown belongs to, as starts and element numbers."""
    start = np.zeros(size + 2, dtype=np.int64)
    for dof in dofs:
        if dof < size:
            start[dof + 2] += 1
    start = np.cumsum(start)
    owner = np.empty(start[-1], dtype=np.int64)
    for element in range(first.size - 1):
        for k in range(first[element], first[element + 1]):
            if dofs[k] < size:
                owner[start[dofs[k] + 1]] = element
                start[dofs[k] + 1] += 1
    return start[:-1].copy(), owner


@jit_in_order
def _merge_elements(
    size: int, first: Indices, dofs: Indices, owner_start: Indices, owner: Indices, rows: NDArray[np.int32]
) -> Indices:
    """Column starts of the union of element blocks; sorted rows are filled in unless ``rows`` is empty."""
    start, seen = np.zeros(size + 1, dtype=np.int64), np.full(size, -1, dtype=np.int64)
    for column in range(size):
        count = start[column]
        # The diagonal is always there, even of an unknown without elements.
        seen[column] = column
        if rows.size:
            rows[count] = column
        count += 1
        for k in range(owner_start[column], owner_start[column + 1]):
            for m in range(first[owner[k]], first[owner[k] + 1]):
                row = dofs[m]
                if row < size and seen[row] != column:
                    seen[row] = column
                    if rows.size:
                        rows[count] = row
                    count += 1
        if rows.size:
            rows[start[column] : count].sort()
        start[column + 1] = count
    return start


@jit_in_order
def _find_slot(size: int, start: NDArray[np.int32], rows: NDArray[np.int32], row: int, column: int) -> int:
    if row >= size or column >= size:
        return rows.size
    low, high = start[column], start[column + 1]
    while low < high:
        middle = (low + high) // 2
        if rows[middle] < row:
            low = middle + 1
        else:
            high = middle
    return low


@jit_in_order
def _find_slots(
    size: int, start: NDArray[np.int32], rows: NDArray[np.int32], row: Indices, column: Indices,
    slots: Places,
) -> None:  # fmt: skip
    for k in range(slots.size):
        slots[k] = _find_slot(size, start, rows, row[k], column[k])


@jit_in_order
def _find_element_slots(
    size: int, start: NDArray[np.int32], rows: NDArray[np.int32], dofs: Indices, slots: Places
) -> None:
    for e in range(dofs.shape[0]):
        for i in range(dofs.shape[1]):
            for j in range(dofs.shape[1]):
                slots[i, j, e] = _find_slot(size, start, rows, dofs[e, i], dofs[e, j])


@jit_in_order
def _find_upper_slots(
    size: int, start: NDArray[np.int32], rows: NDArray[np.int32], dofs: Indices, slots: Places
) -> None:
    for e in range(dofs.shape[0]):
        pair = 0
        for i in range(dofs.shape[1]):
            for j in range(i + 1):
                row, column = min(dofs[e, i], dofs[e, j]), max(dofs[e, i], dofs[e, j])
                slots[pair, e] = _find_slot(size, start, rows, row, column)
                pair += 1


@dataclass(frozen=True)
class SparsityPattern:
    """Compressed-column pattern with sorted rows, symmetric in structure.

    Parameters
    ----------
    size
        Number of free unknowns.
    column_start, rows
        Compressed-column index arrays, shapes (size + 1,) and (entries,).
    memo
        What solvers found out about parts of the pattern (fill-reducing orders), for all who share it.
    """

    size: int
    column_start: NDArray[np.int32]
    rows: NDArray[np.int32]
    memo: dict[bytes, dict[str, Any]] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def from_elements(cls, size: int, element_dofs: list[Indices]) -> SparsityPattern:
        """Union of the dense blocks of all elements; slots equal to ``size`` (supported unknowns) are left out."""
        widths = np.concatenate([[0], *(np.full(len(dofs), dofs.shape[1]) for dofs in element_dofs)])
        first = np.cumsum(widths, dtype=np.int64)
        dofs = np.concatenate([np.zeros(0, dtype=np.int64), *(dofs.ravel() for dofs in element_dofs)])
        owner_start, owner = _elements_of_unknowns(size, first, dofs)
        start = _merge_elements(size, first, dofs, owner_start, owner, np.zeros(0, dtype=np.int32))
        rows = np.empty(start[-1], dtype=np.int32)
        _merge_elements(size, first, dofs, owner_start, owner, rows)
        return cls(size, start.astype(np.int32), rows)

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
        every = np.broadcast_arrays(row, column)
        rows, columns = (array.astype(np.int64).reshape(-1) for array in every)
        slots = np.empty(every[0].shape, dtype=np.uint32)
        _find_slots(self.size, self.column_start, self.rows, rows, columns, slots.reshape(-1))
        return slots

    def element_slots(self, dofs: Indices) -> Places:
        """Positions of the element matrices' entries, shape (dof, dof, element), for dofs (element, dof)."""
        slots = np.empty((dofs.shape[1], dofs.shape[1], len(dofs)), dtype=np.uint32)
        _find_element_slots(self.size, self.column_start, self.rows, dofs, slots)
        return slots

    def upper_slots(self, dofs: Indices) -> Places:
        """Positions in the upper triangle of the pairs (i, j <= i) of element unknowns, for dofs (element, dof).

        Shape (pair, element), pairs in the order (0, 0), (1, 0), (1, 1), (2, 0) ...
        """
        _, start, rows = self.upper
        slots = np.empty((dofs.shape[1] * (dofs.shape[1] + 1) // 2, len(dofs)), dtype=np.uint32)
        _find_upper_slots(self.size, start, rows, dofs, slots)
        return slots

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
