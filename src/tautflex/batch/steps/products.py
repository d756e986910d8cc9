"""Products for many runs side by side: arrays have the run as last axis, so that neighbours in memory do the same.

Matrices that differ from run to run are multiplied row by row over all runs, those that all runs share with one matrix
product.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import lax

from tautflex.batch.library import jax, platform
from tautflex.reduction.polynomial.monomials import pair_table, pairs

Array = jax.Array


def one_by_one(function: Callable[..., Any], *arrays: Any) -> Any:
    """Function of one run for all runs, the first axis of arrays and results.

    On a processor one after the other: factorizations of many matrices at once wait for threads of the pool that they
    are computed in, and may wait for ever (jaxlib 0.10).
    """
    if platform() != "cpu":
        return jax.vmap(function)(*arrays)
    return lax.map(lambda some: function(*some), arrays)


def norm(vector: Array) -> Array:
    """Euclidean norm over the first axis: (n, ...) -> (...)."""
    return jnp.sqrt(jnp.sum(vector * vector, axis=0))


def product(matrix: Array, vector: Array) -> Array:
    """Matrix (n, k, runs), or (n, k) if all runs share it, times the vector of every run, (k, runs) -> (n, runs)."""
    return matrix @ vector if matrix.ndim == 2 else _product(matrix, vector)


def transposed(matrix: Array) -> Array:
    """Transposed matrices of all runs."""
    return jnp.swapaxes(matrix, 0, 1)


# Rows from which on a product with an identity costs less than a branch.
_TALL = 16


def branched(function: Callable[[Array], Array], x: Array) -> Array:
    """Function (n, runs) -> (k, runs) of settled arguments, whose results are computed once.

    The compiler would compute them again for every element that asks for them, but does not look into a branch. The
    other branch is taken where no run has finite numbers left.
    """
    usable = jnp.any(jnp.isfinite(lax.stop_gradient(x[0])))
    found = jax.eval_shape(function, x)
    return lax.cond(usable, function, lambda x: jnp.full(found.shape, jnp.nan, found.dtype), x)


def settled(x: Array) -> Array:
    """The same numbers (n, runs), computed once, whatever their elements are used for.

    Beside branches there are matrix products that the compiler does not look into: one with a small identity leaves the
    bits as they are, and the runs apart.
    """
    rows = next((k for k in range(3, len(x) + 1) if len(x) % k == 0), 0)
    if platform() != "cpu" or not rows:
        return x
    if len(x) < _TALL:
        return branched(lambda x: x, x)
    return jnp.matmul(jnp.eye(rows, dtype=x.dtype), x.reshape(rows, -1), precision="highest").reshape(x.shape)


# Terms of a sum that are unrolled.
_TERMS = 40


@jax.custom_jvp
def _product(matrix: Array, vector: Array) -> Array:
    # One sum per result, unrolled: the compiler then walks along the runs. Long ones are slower, and slow to compile.
    parts = []
    for first in range(0, vector.shape[0], _TERMS):
        total = matrix[:, first] * vector[first]
        for k in range(first + 1, min(first + _TERMS, vector.shape[0])):
            total = total + matrix[:, k] * vector[k]
        parts.append(total)
    return parts[0] if len(parts) == 1 else sum(map(settled, parts[1:]), settled(parts[0]))


@_product.defjvp
def _product_jvp(primals: tuple[Array, Array], tangents: tuple[Array, Array]) -> tuple[Array, Array]:
    (matrix, vector), (change, move) = primals, tangents
    return _product(matrix, vector), jnp.sum(change * vector + matrix * move, axis=1)


# Relative residual that refinement stops at in units of the last place, and the most turns it takes.
_REFINED, _MOST_TURNS = 4.5, 50


def refined(matrix: Callable[[Array], Array], approximate: Callable[[Array], Array], right: Array) -> Array:
    """Solution of a linear system by refinement with an approximate inverse, shape (n, runs)."""
    least = _REFINED * float(np.finfo(right.dtype).eps)

    def going(state: tuple[Array, Array, Array]) -> Array:
        _, left, turn = state
        return jnp.any(norm(left) > least * norm(right)) & (turn < _MOST_TURNS)

    def turn(state: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        x, left, count = state
        x = x + approximate(left)
        return x, right - matrix(x), count + 1

    return lax.while_loop(going, turn, (jnp.zeros_like(right), right, jnp.zeros((), int)))[0]


class Monomials:
    """The m products ``q_i q_j``, i <= j, of r coordinates, and the forces of stresses that work on them."""

    def __init__(self, count: int) -> None:
        self.first, self.second = pairs(count)
        self._place = pair_table(count)
        # The derivative of a square counts twice.
        self._twice = np.eye(count)[:, :, None] + 1.0

    def values(self, q: Array) -> Array:
        """Monomials, shape (m, runs)."""
        return q[self.first] * q[self.second]

    def rates(self, q: Array, v: Array) -> Array:
        """Their rates, shape (m, runs)."""
        return q[self.first] * v[self.second] + v[self.first] * q[self.second]

    def force(self, stress: Array, q: Array) -> Array:
        """Force ``Y' s`` on the coordinates of stresses that work on the monomials, Y = dy/dq, shape (r, runs)."""
        both, twice = stress[self._place], jnp.asarray(self._twice, q.dtype)
        total = both[:, 0] * (twice[0] * q[0])
        for j in range(1, q.shape[0]):
            total = total + both[:, j] * (twice[j] * q[j])
        return total

    def trace(self, matrix: Array) -> Array:
        """Matrix of the quadratic form ``trace(Y' C Y)`` in q, shapes (m, m) -> (r, r)."""
        w, place = self._twice[:, :, 0], self._place
        return jnp.sum(matrix[place[:, :, None], place[:, None, :]] * w[:, :, None] * w[:, None, :], axis=0)
