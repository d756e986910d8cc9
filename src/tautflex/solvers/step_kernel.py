"""Compiled parts of one implicit step: what is known, the residual, and the state at the end."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.kernel import FASTMATH, add_forces
from tautflex.mechanics.products import add_pair_products

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Places = NDArray[np.uint32]

_jit = numba.njit(cache=True, fastmath=FASTMATH, error_model="numpy")


@_jit
def known_forces(
    start: Indices, column: Places, mass: Array, damping: Array, damped: bool, pairs: Any, coefficients: Array,
    q: Array, v: Array, a: Array, load: Array, gyroscopic: Array, turning: Array, known: Array,
) -> float:  # fmt: skip
    """Fill ``known`` with the forces of a step that do not depend on the increment, return their norm.

    Parameters
    ----------
    start, column, mass, damping
        Mass and damping in compressed rows.
    damped
        Whether there is damping at all.
    pairs
        Inertia products.
    coefficients
        Weight of the forces; factors of v and a in the inertia's acceleration; and in the velocity, shape (5,).
    q, v, a
        State at the start of the step.
    load
        Load on the left-hand side.
    gyroscopic, turning
        Matrices Z of the forces ``M(Z) velocity`` and ``M(Z) q``.
    known
        Result, shape (size,).
    """
    size = q.size
    weight, inertia_v, inertia_a, velocity_v, velocity_a = coefficients
    acceleration, velocity = np.empty(size), np.empty(size)
    for i in range(size):
        acceleration[i] = inertia_v * v[i] + inertia_a * a[i]
        velocity[i] = weight * (velocity_v * v[i] + velocity_a * a[i])
        known[i] = weight * load[i]
    for i in range(size):
        total = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += mass[k] * acceleration[column[k]]
        known[i] += total
    if damped:
        for i in range(size):
            total = 0.0
            for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
                total += damping[k] * velocity[column[k]]
            known[i] += total
    add_pair_products(pairs, gyroscopic, 1.0, velocity, known)
    add_pair_products(pairs, turning, weight, q, known)
    return np.sqrt(np.sum(known * known))


@_jit
def assemble_residual(
    start: Indices, column: Places, linear: Array, pairs: Any, turning: Array, weight: float, x: Array,
    reference: Array, known: Array, force: Array, residual: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill the residual of an increment from its internal forces.

    Returns the norms of the weighted internal forces above the reference and of the linear forces.
    """
    internal, inertia = 0.0, 0.0
    for i in range(x.size):
        f, part = weight * (force[i] - reference[i]), 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            part += linear[k] * x[column[k]]
        internal += f * f
        inertia += part * part
        residual[i] = f + part + known[i]
    add_pair_products(pairs, turning, 1.0, x, residual)
    return np.sqrt(internal), np.sqrt(inertia)


@_jit
def step_residual(
    store: Any, stresses: Array, q: Array, start: Indices, column: Places, linear: Array, pairs: Any, turning: Array,
    weight: float, x: Array, reference: Array, known: Array, residual: Array,
) -> tuple[float, float]:  # fmt: skip
    """Residual of the increment ``x`` from ``q``; returns the norms of `assemble_residual`."""
    size = x.size
    extended, force = np.empty(size + 1), np.zeros(size + 1)
    for i in range(size):
        extended[i] = q[i] + x[i]
    extended[size] = 0.0
    add_forces(store, extended, force, stresses, True, False)
    return assemble_residual(start, column, linear, pairs, turning, weight, x, reference, known, force, residual)


@_jit
def first_guess(reach: float, v: Array, a: Array, jerk: Array) -> Array:
    """Increment by Taylor's series; an empty ``jerk`` is none."""
    guess = np.empty(v.size)
    for i in range(v.size):
        guess[i] = reach * v[i] + 0.5 * reach * reach * a[i]
    third = reach * reach * reach / 6.0
    for i in range(jerk.size):
        guess[i] += third * jerk[i]
    return guess


@_jit
def end_of_step(coefficients: Array, size: float, d: Array, q: Array, v: Array, a: Array) -> Array:
    """Displacement, velocity, acceleration and jerk at the end of a step, shape (4, unknowns).

    ``coefficients`` holds the factors of (d, v, a) in the first three, shape (3, 3).
    """
    end = np.empty((4, d.size))
    for row in range(3):
        c, target = coefficients[row], end[row]
        for i in range(d.size):
            target[i] = c[0] * d[i] + c[1] * v[i] + c[2] * a[i]
    for i in range(d.size):
        end[0, i] += q[i]
        end[3, i] = (end[2, i] - a[i]) / size
    return end


@_jit
def scaled_norm(scale: Array, vector: Array) -> float:
    """Norm of ``scale * vector``."""
    total = 0.0
    for i in range(vector.size):
        total += scale[i] * scale[i] * vector[i] * vector[i]
    return np.sqrt(total)
