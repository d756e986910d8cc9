"""Balance of the momenta of hub and structure: where a free hub is after a step [theory.md 9]; compiled."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.products import inner, product
from tautflex.motion import rotations
from tautflex.numeric import Array, Indices, Places, cross, jit
from tautflex.solvers.transient.free_hub.momentum import (
    Momenta,
    add_frame_forces,
    held_apart,
    momenta_of,
    rigid_blocks,
)

_cross = jit(cross)
_matrix, _product, _exponential = rotations.matrix, rotations.product, rotations.exponential
_ROUND_OFF = float(np.finfo(float).eps)
_MOST_TURNS = 50


class RigidState(NamedTuple):
    """The hub at one instant, in parts of one array of shape (31,).

    Parameters
    ----------
    attitude
        Unit quaternion, shape (4,).
    position
        Origin of the floating frame, inertial axes [m], shape (3,).
    twist
        Velocity of the origin and angular velocity, hub axes [m/s], [rad/s], shape (6,).
    momentum
        Linear momentum, and angular momentum about the inertial origin, inertial axes, shape (6,).
    wrench
        Force, and torque about O, of everything outside, hub axes [N], [N m], shape (6,).
    rates
        Acceleration of the origin and angular acceleration, hub axes, shape (6,).
    """

    attitude: Array
    position: Array
    twist: Array
    momentum: Array
    wrench: Array
    rates: Array


def rigid_parts(rigid: Array) -> RigidState:
    """Views of the parts."""
    return RigidState(rigid[:4], rigid[4:7], rigid[7:13], rigid[13:19], rigid[19:25], rigid[25:])


_parts = jit(rigid_parts)


@jit
def cholesky(matrix: Array) -> Array:
    """Lower factor L of ``L L'``."""
    size = matrix.shape[0]
    lower = np.zeros((size, size))
    for i in range(size):
        for j in range(i + 1):
            value = matrix[i, j]
            for k in range(j):
                value -= lower[i, k] * lower[j, k]
            lower[i, j] = np.sqrt(value) if i == j else value / lower[j, j]
    return lower


@jit
def solve(lower: Array, right: Array) -> Array:
    """Solve ``L L' x = right``."""
    size, x = lower.shape[0], right.copy()
    for i in range(size):
        for k in range(i):
            x[i] -= lower[i, k] * x[k]
        x[i] /= lower[i, i]
    for i in range(size - 1, -1, -1):
        for k in range(i + 1, size):
            x[i] -= lower[k, i] * x[k]
        x[i] /= lower[i, i]
    return x


@jit
def _turned(axes: Array, vector: Array) -> Array:
    """``axes vector`` for both halves of a vector of shape (6,)."""
    result = np.zeros(6)
    for i in range(3):
        for k in range(3):
            result[i] += axes[i, k] * vector[k]
            result[3 + i] += axes[i, k] * vector[3 + k]
    return result


@jit
def inertial(attitude: Array, position: Array, vector: Array) -> Array:
    """Force and moment about O in hub axes as force and moment about the inertial origin in inertial axes, (6,)."""
    result = _turned(_matrix(attitude), vector)
    result[3:] += _cross(position, result[:3])
    return result


@jit
def advance(momenta: Momenta, freedom: Array, start: Array, reach: float, wrench: Array, twist: Array) -> Array:
    """Hub at ``reach`` [s] after ``start`` from the balance of momenta, with the accelerations that keep it.

    ``momenta`` are those of the structure at the end, ``wrench`` acts there, and ``twist`` is a first guess. Attitude
    follows the mean angular velocity, the impulse is that of the trapezoidal rule. A fixed-point iteration over
    attitude and velocities, which contracts by (reach times spin), down to round-off, where the changes stop falling.
    """
    before, lower, last = _parts(start), cholesky(held_apart(momenta.mass, freedom)), np.inf
    applied = inertial(before.attitude, before.position, before.wrench)
    velocity = _turned(_matrix(before.attitude), before.twist)
    end = start.copy()
    after = _parts(end)
    after.wrench[:], after.twist[:] = wrench, twist
    for _ in range(_MOST_TURNS):
        after.attitude[:] = _product(before.attitude, _exponential(0.5 * reach * (before.twist + after.twist)[3:]))
        axes = _matrix(after.attitude)
        after.position[:] = before.position + 0.5 * reach * (velocity + _turned(axes, after.twist))[:3]
        push = inertial(after.attitude, after.position, wrench)
        after.momentum[:] = before.momentum + 0.5 * reach * (applied + push)
        about = after.momentum.copy()
        about[3:] -= _cross(after.position, about[:3])
        twist = solve(lower, freedom * (_turned(axes.T, about) - momenta.relative))
        change = np.abs(twist - after.twist).max()
        after.twist[:] = twist
        if not 0.5 * _ROUND_OFF * np.abs(twist).max() < change < last:
            break
        last = change
    after.attitude[:] /= np.sqrt(np.sum(after.attitude * after.attitude))
    after.rates[:] = solve(lower, freedom * rate_forces(momenta, wrench, after.twist))
    if freedom.min() == 0.0:
        # What holds the hub takes up momentum.
        whole = momenta.mass @ after.twist + momenta.relative
        after.momentum[:] = inertial(after.attitude, after.position, whole)
    return end


@jit
def mobile_product(
    body: tuple[Any, ...], start: Indices, column: Places, mass: Array, q: Array, vector: Array
) -> Array:
    """Mass that elastic motion alone moves, ``M - B' R^-1 B``, times a vector of shape (size,)."""
    (rigid, coupling), result, shares = rigid_blocks(body, q), product(start, column, mass, vector), np.empty(6)
    for k in range(6):
        shares[k] = inner(coupling[k], vector)
    shares = solve(cholesky(rigid), shares)
    for k in range(6):
        row = coupling[k]
        for i in range(vector.size):
            result[i] -= shares[k] * row[i]
    return result


@jit
def rate_forces(momenta: Momenta, wrench: Array, twist: Array) -> Array:
    """What the rigid accelerations have to balance, ``R (a0, dw)``, shape (6,)."""
    spin, flow, mass = twist[3:], momenta.flow, momenta.mass
    first = np.array([mass[1, 5], mass[2, 3], mass[0, 4]])
    right = wrench - momenta.push
    right[:3] -= _cross(spin, _cross(spin, first)) + 2.0 * _cross(spin, momenta.relative[:3])
    for i in range(3):
        right[3 + i] -= 2.0 * (flow[0, 0] + flow[1, 1] + flow[2, 2]) * spin[i]
        for k in range(3):
            right[3 + i] += 2.0 * flow[k, i] * spin[k]
    right[3:] -= _cross(spin, mass[3:, 3:].copy() @ spin)
    return right


@jit
def add_forces_at_rates(body: tuple[Any, ...], q: Array, v: Array, a: Array, rigid: Array, forces: Array) -> Array:
    """Add the forces of a known hub with the structure at q, v, a to ``forces``; the hub with the rates that follow."""
    momenta, end = momenta_of(body, q, v, a), rigid.copy()
    parts = _parts(end)
    lower, free = cholesky(held_apart(momenta.mass, body[13])), body[13]
    parts.rates[:] = solve(lower, free * rate_forces(momenta, parts.wrench, parts.twist))
    add_frame_forces(body, momenta.products, parts.twist, parts.rates, 1.0, forces)
    return end


@jit
def end_hub(
    body: tuple[Any, ...], q: Array, v: Array, a: Array, start: Array, reach: float, wrench: Array, twist: Array
) -> Array:
    """Hub at ``reach`` [s] after ``start`` with the structure at q, v, a there; see `advance`."""
    return advance(momenta_of(body, q, v, a), body[13], start, reach, wrench, twist)


@jit
def motion_at(numbers: Array, x: Array, q: Array, v: Array, a: Array, balanced: Array) -> tuple[Array, Array, Array]:
    """Displacement, velocity and acceleration of the increment x from q, v, a, each of shape (size,).

    ``numbers`` holds the factors of (x, v, a) in the velocity and of (x, v, a, balanced) in the acceleration, shape
    (7,); an empty ``balanced`` has none.
    """
    displacement, velocity, acceleration = np.empty(x.size), np.empty(x.size), np.empty(x.size)
    for i in range(x.size):
        displacement[i] = q[i] + x[i]
        velocity[i] = numbers[0] * x[i] + numbers[1] * v[i] + numbers[2] * a[i]
        acceleration[i] = numbers[3] * x[i] + numbers[4] * v[i] + numbers[5] * a[i]
    for i in range(balanced.size):
        acceleration[i] += numbers[6] * balanced[i]
    return displacement, velocity, acceleration


@jit
def add_hub_forces(
    body: tuple[Any, ...], q: Array, v: Array, a: Array, start: Array, reach: float, wrench: Array, twist: Array,
    weight: float, forces: Array,
) -> tuple[Array, float, float]:  # fmt: skip
    """Add the forces of a hub at ``reach`` [s] after ``start``, with the structure at q, v, a there, to ``forces``.

    Returns the hub, see `advance`, and the norms of `add_frame_forces`.
    """
    momenta = momenta_of(body, q, v, a)
    end = advance(momenta, body[13], start, reach, wrench, twist)
    parts = _parts(end)
    load, norm = add_frame_forces(body, momenta.products, parts.twist, parts.rates, weight, forces)
    return end, load, norm
