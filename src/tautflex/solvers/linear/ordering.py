"""Fill-reducing order of a symmetric pattern, found on groups of unknowns that have the same neighbours.

The unknowns of a node are coupled to the same unknowns of the same nodes, so the order is one of nodes: QDLDL's
approximate minimum degree [Amestoy, Davis & Duff 1996] sees a graph with a third of the vertices and a ninth of the
edges, and the pattern of L follows by writing every group out again.
"""

from __future__ import annotations

import numpy as np
import qdldl
from numpy.typing import NDArray
from scipy.sparse import csc_array

from tautflex.numeric import Indices, Places, jit


def order_and_fill(
    size: int, column_start: NDArray[np.int32], rows: NDArray[np.int32]
) -> tuple[Places, Indices, Places]:
    """Order and pattern of the factor L of a symmetric matrix.

    From compressed columns of its upper triangle, diagonal included, rows sorted: the row of the matrix that stands at
    each place of L, shape (size,), and compressed columns of the strictly lower triangle of L, rows sorted.
    """
    columns = np.repeat(np.arange(size, dtype=np.int32), np.diff(column_start))
    upper = csc_array((np.ones(len(rows), dtype=np.int8), rows, column_start), shape=(size, size))
    whole = csc_array(upper + upper.T)
    whole.sort_indices()
    group = _same_neighbours(whole.indptr, whole.indices)
    del upper, whole
    count = int(group.max(initial=-1)) + 1
    members = np.bincount(group, minlength=count)
    pairs = np.sort(_pairs(group, rows, columns, count))
    pairs = pairs[np.concatenate([[True], np.diff(pairs) > 0])]
    row, column = pairs % count, pairs // count
    # Any definite matrix of this pattern will do: diagonally dominant.
    values = np.where(row == column, 1.0 + 2.0 * len(pairs), 1.0)
    start = np.searchsorted(column, np.arange(count + 1)).astype(np.int32)
    solver = qdldl.Solver(csc_array((values, row.astype(np.int32), start), shape=(count, count)), upper=True)
    coarse, _, order = solver.factors()
    group_order = np.asarray(order, dtype=np.int64)
    width = members[group_order]
    begin = np.concatenate([[0], np.cumsum(width)]).astype(np.int64)
    # Unknowns by the place of their group, in their own order within it.
    place = np.empty(count, dtype=np.int64)
    place[group_order] = np.arange(count)
    fine_order = np.argsort(place[group], kind="stable").astype(np.uint32)
    fine_start = _column_starts(coarse.indptr.astype(np.int64), coarse.indices, begin)
    fine_rows = np.empty(fine_start[-1], dtype=np.uint32)
    _write_rows(coarse.indptr.astype(np.int64), coarse.indices, begin, fine_start, fine_rows)
    return fine_order, fine_start, fine_rows


@jit
def _pairs(group: Indices, row: NDArray[np.int32], column: NDArray[np.int32], count: int) -> Indices:
    """Keys of the group pairs of all entries, upper triangle, repeated neighbours left out."""
    keys, used = np.empty(row.size, dtype=np.int64), 0
    for k in range(row.size):
        a, b = group[row[k]], group[column[k]]
        key = max(a, b) * count + min(a, b)
        if used == 0 or keys[used - 1] != key:
            keys[used] = key
            used += 1
    return keys[:used].copy()


@jit
def _same_neighbours(start: NDArray[np.int32], rows: NDArray[np.int32]) -> Indices:
    """Number of the group of each unknown; groups are numbered by their first member.

    Members of a group are looked for among the next few unknowns, where those of the same node are: their columns of
    the whole symmetric pattern must be equal.
    """
    size = start.size - 1
    group, count = np.full(size, -1, dtype=np.int64), 0
    for j in range(size):
        if group[j] >= 0:
            continue
        group[j] = count
        length = start[j + 1] - start[j]
        for k in range(j + 1, min(j + 6, size)):
            if group[k] >= 0 or start[k + 1] - start[k] != length:
                continue
            same = True
            for m in range(length):
                if rows[start[j] + m] != rows[start[k] + m]:
                    same = False
                    break
            if same:
                group[k] = count
        count += 1
    return group


@jit
def _column_starts(start: Indices, rows: NDArray[np.int32], begin: Indices) -> Indices:
    """Column starts of L with every group written out; ``begin`` holds the first unknown of each group."""
    result = np.zeros(begin[-1] + 1, dtype=np.int64)
    for j in range(start.size - 1):
        below = 0
        for k in range(start[j], start[j + 1]):
            below += begin[rows[k] + 1] - begin[rows[k]]
        for column in range(begin[j], begin[j + 1]):
            result[column + 1] = result[column] + below + begin[j + 1] - 1 - column
    return result


@jit
def _write_rows(
    start: Indices, rows: NDArray[np.int32], begin: Indices, fine_start: Indices, fine_rows: Places
) -> None:
    for j in range(start.size - 1):
        for column in range(begin[j], begin[j + 1]):
            entry = fine_start[column]
            for row in range(column + 1, begin[j + 1]):
                fine_rows[entry] = row
                entry += 1
            for k in range(start[j], start[j + 1]):
                for row in range(begin[rows[k]], begin[rows[k] + 1]):
                    fine_rows[entry] = row
                    entry += 1
