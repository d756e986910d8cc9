"""Packed second-degree monomials: one number for every unordered pair of modal coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def pairs(count: int) -> tuple[Indices, Indices]:
    """Indices (i, j), i <= j, of the packed monomials ``y_ij = eta_i eta_j``, each of shape (count (count + 1) / 2,)."""
    first, second = np.triu_indices(count)
    return first.astype(np.int64), second.astype(np.int64)


def monomials(eta: Array) -> Array:
    """Packed products ``eta_i eta_j``, i <= j, over the last axis: (..., r) -> (..., m)."""
    first, second = pairs(eta.shape[-1])
    return eta[..., first] * eta[..., second]


def monomial_rates(eta: Array, rate: Array) -> Array:
    """Time derivatives of `monomials`: (..., r), (..., r) -> (..., m)."""
    first, second = pairs(eta.shape[-1])
    return eta[..., first] * rate[..., second] + rate[..., first] * eta[..., second]


def packed(table: Array) -> Array:
    """Coefficients of a quadratic form per monomial: (..., r, r), need not be symmetric, -> (..., m)."""
    first, second = pairs(table.shape[-1])
    both = table + np.swapaxes(table, -1, -2)
    result = both[..., first, second]
    result[..., first == second] *= 0.5
    return result


def unpacked(coefficients: Array, count: int) -> Array:
    """Symmetric matrices of quadratic forms given per monomial: (..., m) -> (..., r, r)."""
    first, second = pairs(count)
    result = np.zeros((*coefficients.shape[:-1], count, count))
    result[..., first, second] = 0.5 * coefficients
    result[..., second, first] += 0.5 * coefficients
    return result
