"""Nonlinear equations of one step, solved to a residual and differentiated implicitly.

The iteration is the one of the full NumPy model: a constant approximate inverse (there old factors, here the natural
frequencies of the reference) and Anderson acceleration that makes it act like a fresh tangent. Derivatives do not go
through the iteration: ``dx = -A^-1 dr`` with the exact tangent A of the solution, forward and reverse.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import lax
from jax.scipy.sparse.linalg import bicgstab

from tautflex.batch.library import jax
from tautflex.batch.steps.products import norm, one_by_one

Array = jax.Array
Residual = Callable[[Array], tuple[Array, Array]]

# The ridge keeps nearly parallel pairs from cancelling each other with huge weights.
_RIDGE = 1e-8
_MOST_ITERATIONS = 60
# Coordinates up to this number are solved for at once when derivatives are taken.
_DENSE = 64


class Memory(NamedTuple):
    """Pairs of Anderson acceleration from earlier iterations; shapes (depth, n) twice, (depth, depth)."""

    changes: Array
    shifts: Array
    gram: Array


class Solution(NamedTuple):
    """Root, memory for the next one, residual left and its scale, and how the iteration went."""

    x: Array
    memory: Memory
    residual: Array
    scale: Array
    converged: Array
    iterations: Array


class _Iteration(NamedTuple):
    x: Array
    residual: Array
    scale: Array
    error: Array
    plain: Array
    move: Array
    turn: Array
    memory: Memory


def empty_memory(depth: int, like: Array) -> Memory:
    """Memory without pairs for unknowns like these."""
    shape, kind = like.shape, like.dtype
    none, unit = jnp.zeros((depth, *shape), kind), jnp.eye(depth, dtype=kind)
    unit = unit.reshape(depth, depth, *(1 for _ in shape[1:]))
    return Memory(none, none, unit * jnp.ones(shape[1:], kind))


def _dot(a: Array, b: Array) -> Array:
    """Inner products over the last axis but that of the runs: (..., n, runs) or (..., n)."""
    return jnp.sum(a * b, axis=a.ndim - b.ndim)


def _learn(memory: Memory, move: Array, change: Array, answer: Array, wanted: Array) -> Memory:
    """Put a pair first and drop the last one; everything stays as it is if the pair is of no use."""
    energy = _dot(change, answer)
    good = wanted & (energy > 0.0) & jnp.isfinite(energy)
    scale = jnp.where(good, 1.0 / jnp.sqrt(jnp.where(good, energy, 1.0)), 0.0)
    changes = jnp.concatenate([scale * change[None], memory.changes[:-1]])
    shifts = jnp.concatenate([scale * (answer - move)[None], memory.shifts[:-1]])
    # A pair has unit energy; places without one keep the row of a unit matrix.
    row = jnp.concatenate([jnp.ones_like(energy)[None], scale * _dot(memory.changes[:-1], answer)])
    gram = jnp.concatenate([row[None], jnp.concatenate([row[1:, None], memory.gram[:-1, :-1]], axis=1)])
    learned = Memory(changes, shifts, gram)
    return Memory(*(jnp.where(good, new, old) for new, old in zip(learned, memory, strict=True)))


def _correct(memory: Memory, plain: Array) -> Array:
    if len(memory.gram) == 1:
        return plain - _dot(memory.changes[0], plain) * memory.shifts[0]
    ridge = _RIDGE * jnp.eye(len(memory.gram))
    gram = memory.gram + ridge.reshape(*ridge.shape, *(1 for _ in plain.shape[1:]))
    weights = _solve_small(gram, _dot(memory.changes, plain))
    return plain - jnp.sum(weights[:, None] * memory.shifts, axis=0)


def _solve_small(matrix: Array, right: Array) -> Array:
    """Solve with a small positive definite matrix by elimination, unrolled so that all runs go side by side."""
    rows = [jnp.concatenate([matrix[i], right[i][None]]) for i in range(len(right))]
    for i, pivot in enumerate(rows):
        for j in range(i + 1, len(rows)):
            rows[j] = rows[j] - rows[j][i] / pivot[i] * pivot
    solution: list[Array] = []
    for i in reversed(range(len(rows))):
        known = sum((rows[i][j] * x for j, x in zip(range(len(rows) - 1, i, -1), solution, strict=True)), 0.0)
        solution.append((rows[i][-1] - known) / rows[i][i])
    return jnp.stack(solution[::-1])


def find_root(
    residual: Residual,
    guess: Array,
    inverse: Callable[[Array], Array],
    memory: Memory,
    tolerance: float,
    active: Array,
) -> Solution:
    """Solve ``residual(x) = 0`` until the ratio of the residual's norm to its scale is as small as the tolerance.

    ``residual`` gives both, ``inverse`` is a symmetric positive approximate inverse of the tangent, ``memory`` has the
    pairs of earlier, similar equations, and ``active`` tells whether to iterate at all.
    """

    def iterate(state: _Iteration) -> _Iteration:
        x = state.x + state.move
        value, scale = residual(x)
        size = norm(value)
        error = jnp.where(size == 0.0, 0.0, size / scale)
        plain = -inverse(value)
        change, answer = value - state.residual, state.plain - plain
        known = _learn(state.memory, state.move, change, answer, state.turn >= 0.0)
        after = _Iteration(x, value, scale, error, plain, _correct(known, plain), state.turn + 1.0, known)
        # Runs that are done wait for the others.
        still = going(state)
        return jax.tree.map(lambda new, old: jnp.where(still, new, old), after, state)

    def going(state: _Iteration) -> Array:
        return active & ~(state.error <= tolerance) & (state.turn < _MOST_ITERATIONS)

    def solve(function: Any, start: Array) -> tuple[Array, tuple[Memory, Array, Array, Array, Array]]:
        # The first turn does not move: it measures the guess. One residual in the loop keeps compiling short.
        zero, one = jnp.zeros_like(start), jnp.ones(start.shape[1:], start.dtype)
        first = _Iteration(start, zero, one, jnp.inf * one, zero, zero, -one, memory)
        last = lax.while_loop(lambda state: jnp.any(going(state)), iterate, first)
        done = (last.error <= tolerance).astype(float)
        return last.x, (last.memory, last.residual, last.scale, done, last.turn)

    def tangent_solve(linear: Callable[[Array], Array], right: Array) -> Array:
        if right.ndim > 1:
            units = jnp.eye(len(right), dtype=right.dtype)[:, :, None] * jnp.ones(right.shape[1:], right.dtype)
            matrices = jnp.moveaxis(jax.vmap(linear)(units), (0, 1), (2, 1))
            return one_by_one(jnp.linalg.solve, matrices, right.T).T
        if right.size <= _DENSE:
            return jnp.linalg.solve(jax.vmap(linear)(jnp.eye(right.size, dtype=right.dtype)).T, right)
        found, _ = bicgstab(linear, right, tol=1e-12, maxiter=400, M=inverse)  # type: ignore[no-untyped-call]
        return found

    x, (after, left, scale, converged, count) = lax.custom_root(
        lambda x: residual(x)[0], guess, solve, tangent_solve, has_aux=True
    )
    return Solution(x, after, left, scale, converged > 0.5, count)
