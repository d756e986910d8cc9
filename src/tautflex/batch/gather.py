"""Sums over elements and sparse products as gathers: the same on CPU and GPU, and the same for every batch size."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add

import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tautflex.batch.library import jax
from tautflex.numeric import Indices

Array = jax.Array


def gather_table(places: Indices, size: int) -> Indices:
    """Positions in ``places`` that hold each unknown, filled up with ``places.size``, shape (size, width)."""
    order = np.argsort(places, kind="stable")
    counts = np.bincount(places, minlength=size)[:size]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    column = np.arange(counts.max(initial=1))
    table = np.append(order, places.size)[np.minimum(starts[:, None] + column, places.size)]
    return np.where(column < counts[:, None], table, places.size)


def collect(parts: Array, table: Indices) -> Array:
    """Sum of ``parts`` (flat) over the rows of a table, shape (size,)."""
    return jnp.append(parts, 0.0)[table].sum(axis=1)


def shared_rows(matrices: Sequence[csr_array]) -> tuple[Indices, list[NDArray[np.float64]]]:
    """Columns (size, width) of the union of sparse square matrices, and the values of each there.

    Places that a row does not fill have column ``size`` and value 0.
    """
    size = matrices[0].shape[0]
    union = csr_array(reduce(add, (abs(matrix) for matrix in matrices)))
    union.sort_indices()
    counts = np.diff(union.indptr)
    column = np.arange(counts.max(initial=1))
    inside = column < counts[:, None]
    columns = np.full((size, len(column)), size)
    columns[inside] = union.indices
    keys = np.repeat(np.arange(size), counts) * size + union.indices
    values = []
    for matrix in matrices:
        entries = csr_array(matrix).tocoo()
        flat = np.zeros(len(keys))
        np.add.at(flat, np.searchsorted(keys, entries.row.astype(np.int64) * size + entries.col), entries.data)
        value = np.zeros(columns.shape)
        value[inside] = flat
        values.append(value)
    return columns, values


def multiply(columns: Indices, values: Array, vector: Array) -> Array:
    """Product of a matrix given by `shared_rows` with a vector, shape (size,)."""
    return (values * jnp.append(vector, 0.0)[columns]).sum(axis=1)
