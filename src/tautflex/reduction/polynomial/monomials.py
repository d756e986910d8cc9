"""Packed second-degree monomials: one number for every unordered pair of modal coordinates."""

from __future__ import annotations

from functools import cache

import numpy as np

from tautflex.numeric import Array, Indices

# Stress fields that store less than this part of the energy of the strongest one are left out.
WEAK_FIELD = 1e-5
# Rows up to which products are taken by indices.
_FEW = 16


def pairs(count: int) -> tuple[Indices, Indices]:
    """Indices (i, j), i <= j, of the packed monomials ``y_ij = eta_i eta_j``, shapes (count (count + 1) / 2,)."""
    first, second = np.triu_indices(count)
    return first.astype(np.int64), second.astype(np.int64)


_known_pairs = cache(pairs)


def pair_table(count: int) -> Indices:
    """Number of the monomial of every (i, j), either order, shape (count, count)."""
    first, second = pairs(count)
    table = np.zeros((count, count), dtype=np.int64)
    table[first, second] = table[second, first] = np.arange(len(first))
    return table


def _products(a: Array, b: Array) -> Array:
    """Packed products ``a_i b_j``, i <= j: (..., r) -> (..., m)."""
    count = a.shape[-1]
    if a.size <= _FEW * count:
        one, other = _known_pairs(count)
        return np.asarray(a[..., one] * b[..., other])
    # Row by row of the transposed table: fancy indices or short slices would cost several times as much.
    left, right = (np.ascontiguousarray(np.moveaxis(part, -1, 0)) for part in (a, b))
    result = np.empty((count * (count + 1) // 2, *a.shape[:-1]))
    first = 0
    for i in range(count):
        np.multiply(left[i], right[i:], out=result[first : first + count - i])
        first += count - i
    return np.moveaxis(result, 0, -1)


def monomials(eta: Array) -> Array:
    """Packed products ``eta_i eta_j``, i <= j, over the last axis: (..., r) -> (..., m)."""
    return _products(eta, eta)


def monomial_rates(eta: Array, rate: Array) -> Array:
    """Time derivatives of `monomials`: (..., r), (..., r) -> (..., m)."""
    return _products(eta, rate) + _products(rate, eta)


def packed(table: Array) -> Array:
    """Coefficients of a quadratic form per monomial: (..., r, r), need not be symmetric, -> (..., m)."""
    first, second = pairs(table.shape[-1])
    both = table + np.swapaxes(table, -1, -2)
    result = both[..., first, second]
    result[..., first == second] *= 0.5
    return result


def monomial_sizes(amplitude: Array) -> Array:
    """Typical sizes of the monomials of coordinates of given size: (r,) -> (m,)."""
    first, second = pairs(len(amplitude))
    size = amplitude[first] * amplitude[second]
    return np.maximum(size, 1e-8 * size.max())


def stress_fields(matrix: Array, amplitude: Array, weak: float = WEAK_FIELD) -> Array:
    """Factor F with few rows such that ``F'F`` is a positive semidefinite matrix over monomials, (m, m) -> (k, m).

    Fields with less than the part ``weak`` of the strongest one's energy at the typical sizes of the coordinates, shape
    (r,), are left out.
    """
    size = monomial_sizes(amplitude)
    values, vectors = np.linalg.eigh(size[:, None] * matrix * size)
    keep = values > weak * max(float(values[-1]), 0.0)
    if not np.any(matrix):
        keep[:] = False
    return np.ascontiguousarray((np.sqrt(values[keep])[:, None] * vectors.T[keep]) / size)
