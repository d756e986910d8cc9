r"""Momentum balance of a hub with an elastic structure [theory.md 9]; compiled, because every iteration asks for it.

All components are in hub axes, moments about the floating frame's origin O. With rigid velocities (v0, w), elastic
unknowns q and rho = x + u,

    (p, h) = R(q) (v0, w) + B(q) dq,    R = [[m 1, -S(s)], [S(s), J]],    B = [int N; int S(rho) N],

where every block comes from the constant moments of the inertia operator. The rate of (p, h) gives

    R (a0, dw) = (F, T) - B ddq - (w x (w x s) + 2 w x Z dq,  w x J w + 2 (tr(D) 1 - D') w),   D_ab = int rho_a du_b,

and the elastic equation gains B' (a0, dw), which is Q_T and K_T of a prescribed motion written at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.inertia import InertiaOperator
from tautflex.motion import rotations
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array, Indices, Places, cross, jit, jit_in_order

_cross = jit_in_order(cross)
_matrix, _product, _exponential = rotations.matrix, rotations.product, rotations.exponential
_ROUND_OFF = float(np.finfo(float).eps)
_MOST_TURNS = 50


class Body(NamedTuple):
    """Constant moments of a structure and its hub.

    Parameters
    ----------
    pairs
        The products ``int rho N_a' N_b`` of the inertia operator, the parts of a `PairProducts`.
    start, place, moment
        For each direction a: unknowns that move along it, and ``int rho N_a' (1, x, y, z)`` of them, shape (moments, 4).
    mass
        Of both [kg].
    first
        ``int rho x`` of both [kg m], shape (3,).
    second
        ``int rho x x'`` of the structure [kg m^2], shape (3, 3).
    tensor
        Inertia of the hub about O [kg m^2], shape (3, 3).
    """

    pairs: tuple[Any, ...]
    start: Indices
    place: Places
    moment: Array
    mass: float
    first: Array
    second: Array
    tensor: Array

    @classmethod
    def of(cls, inertia: InertiaOperator, hub: FreeHub) -> Body:
        """Moments of a structure with this inertia on a hub."""
        center = np.asarray(hub.center, dtype=float)
        moments = np.concatenate([inertia.zeroth_moment[:, None], inertia.first_moment], axis=1)
        places = [np.flatnonzero(np.any(moment != 0.0, axis=0)) for moment in moments]
        return cls(
            inertia.pairs,
            np.cumsum([0, *(place.size for place in places)]),
            np.concatenate(places).astype(np.uint32),
            np.concatenate([moment[:, place].T for moment, place in zip(moments, places, strict=True)]),
            inertia.mass + hub.mass,
            inertia.mass_moment + hub.mass * center,
            inertia.second_moment,
            hub.tensor + hub.mass * (center @ center * np.eye(3) - np.outer(center, center)),
        )


class Momenta(NamedTuple):
    """Momentum of a moving structure beside that of its rigid motion.

    Parameters
    ----------
    lines
        ``int rho N_a' u_b`` and ``int rho N_a' du_b`` by lines of the pairs, shape (2, lines).
    first
        s = int rho [kg m], shape (3,).
    tensor
        J about O [kg m^2], shape (3, 3).
    relative
        ``B dq``, shape (6,).
    flow
        D, shape (3, 3).
    push
        ``B ddq``, shape (6,).
    """

    lines: Array
    first: Array
    tensor: Array
    relative: Array
    flow: Array
    push: Array


class RigidState(NamedTuple):
    """The hub at one instant.

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


@jit
def _moment_of(lever: Array) -> Array:
    """``int rho x y`` from ``lever_ab = int rho_a y_b``, shape (3,)."""
    return np.array([lever[1, 2] - lever[2, 1], lever[2, 0] - lever[0, 2], lever[0, 1] - lever[1, 0]])


@jit
def momenta_of(body: Body, q: Array, v: Array, a: Array) -> Momenta:
    """Momenta of the structure at elastic unknowns, velocities and accelerations, each of shape (size,)."""
    first, line, start, column, value = body.pairs
    lines, zeroth = np.empty((2, line.size)), np.zeros((3, 3))
    # mixed_ab = int x_a u_b, square_ab = int u_a u_b; flow and kick are int rho_a du_b and int rho_a ddu_b.
    mixed, square, flow, kick = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    for p in range(3):
        for r in range(3):
            for k in range(first[3 * p + r], first[3 * p + r + 1]):
                y, z, row = 0.0, 0.0, line[k]
                for entry in range(np.uint64(start[k]), np.uint64(start[k + 1])):
                    y += value[entry] * q[column[entry]]
                    z += value[entry] * v[column[entry]]
                lines[0, k], lines[1, k] = y, z
                square[r, p] += q[row] * y
                flow[r, p] += v[row] * y
                kick[r, p] += a[row] * y
        for k in range(body.start[p], body.start[p + 1]):
            row, moment = body.place[k], body.moment[k]
            zeroth[0, p] += moment[0] * q[row]
            zeroth[1, p] += moment[0] * v[row]
            zeroth[2, p] += moment[0] * a[row]
            for b in range(3):
                mixed[b, p] += moment[1 + b] * q[row]
                flow[b, p] += moment[1 + b] * v[row]
                kick[b, p] += moment[1 + b] * a[row]
    second = body.second + mixed + mixed.T + 0.5 * (square + square.T)
    tensor = np.trace(second) * np.eye(3) - second + body.tensor
    relative, push = np.empty(6), np.empty(6)
    relative[:3], relative[3:] = zeroth[1], _moment_of(flow)
    push[:3], push[3:] = zeroth[2], _moment_of(kick)
    return Momenta(lines, body.first + zeroth[0], tensor, relative, flow, push)


@jit_in_order
def rigid_mass(mass: float, momenta: Momenta) -> Array:
    """R(q), shape (6, 6)."""
    x, y, z = momenta.first[0], momenta.first[1], momenta.first[2]
    result = np.zeros((6, 6))
    for k in range(3):
        result[k, k] = mass
    result[3, 1] = result[1, 3] = -z
    result[3, 2] = result[2, 3] = y
    result[4, 0] = result[0, 4] = z
    result[4, 2] = result[2, 4] = -x
    result[5, 0] = result[0, 5] = -y
    result[5, 1] = result[1, 5] = x
    result[3:, 3:] = momenta.tensor
    return result


@jit_in_order
def _cholesky(matrix: Array) -> Array:
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


@jit_in_order
def _solve(lower: Array, right: Array) -> Array:
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


@jit_in_order
def _turned(axes: Array, vector: Array) -> Array:
    """``axes vector`` for both halves of a vector of shape (6,)."""
    result = np.zeros(6)
    for i in range(3):
        for k in range(3):
            result[i] += axes[i, k] * vector[k]
            result[3 + i] += axes[i, k] * vector[3 + k]
    return result


@jit_in_order
def inertial(attitude: Array, position: Array, vector: Array) -> Array:
    """Force and moment about O in hub axes as force and moment about the inertial origin in inertial axes, (6,)."""
    result = _turned(_matrix(attitude), vector)
    result[3:] += _cross(position, result[:3])
    return result


@jit_in_order
def advance(body: Body, momenta: Momenta, start: RigidState, reach: float, wrench: Array, twist: Array) -> RigidState:
    """Hub at ``reach`` [s] after ``start`` from the balance of momenta; attitude by the mean angular velocity.

    Parameters
    ----------
    body, momenta
        The structure at the end.
    start
        Hub before.
    reach
        Time between [s].
    wrench
        On the end, in hub axes, shape (6,).
    twist
        First guess of that of the end, shape (6,).

    Returns
    -------
    RigidState
        Without its rates. The impulse is that of the trapezoidal rule. A fixed-point iteration over attitude and
        velocities, which contracts by (reach times spin), down to round-off, where the changes stop falling.
    """
    lower = _cholesky(rigid_mass(body.mass, momenta))
    applied = inertial(start.attitude, start.position, start.wrench)
    velocity = _turned(_matrix(start.attitude), start.twist)
    attitude, position, momentum = start.attitude, start.position, start.momentum
    last = np.inf
    for _ in range(_MOST_TURNS):
        attitude = _product(start.attitude, _exponential(0.5 * reach * (start.twist[3:] + twist[3:])))
        axes = _matrix(attitude)
        position = start.position + 0.5 * reach * (velocity + _turned(axes, twist))[:3]
        momentum = start.momentum + 0.5 * reach * (applied + inertial(attitude, position, wrench))
        about = momentum.copy()
        about[3:] -= _cross(position, momentum[:3])
        before, twist = twist, _solve(lower, _turned(axes.T, about) - momenta.relative)
        change = np.abs(twist - before).max()
        if change >= last or change <= 0.5 * _ROUND_OFF * np.abs(twist).max():
            break
        last = change
    attitude = attitude / np.sqrt(np.sum(attitude * attitude))
    return RigidState(attitude, position, twist, momentum, wrench, start.rates)


@jit_in_order
def with_rates(body: Body, momenta: Momenta, hub: RigidState) -> RigidState:
    """The hub with the accelerations that balance its momenta."""
    spin, flow = hub.twist[3:], momenta.flow
    right = hub.wrench - momenta.push
    right[:3] -= _cross(spin, _cross(spin, momenta.first)) + 2.0 * _cross(spin, momenta.relative[:3])
    right[3:] -= _cross(spin, momenta.tensor @ spin) + 2.0 * (np.trace(flow) * spin - flow.T @ spin)
    rates = _solve(_cholesky(rigid_mass(body.mass, momenta)), right)
    return RigidState(hub.attitude, hub.position, hub.twist, hub.momentum, hub.wrench, rates)


@jit
def add_frame_forces(
    body: Body, momenta: Momenta, spin: Array, rates: Array, weight: float, forces: Array
) -> tuple[float, float]:
    """Add the forces of a frame with this spin and these rates to ``forces``, shape (size,).

    They are ``weight (M(2 S(w)) dq + M(Z) q + int rho N' (Z x + a0))`` with ``Z = S(dw) + S(w)^2``. Returns the norms of
    the part that does not depend on q, and of all the forces after it.
    """
    first, line = body.pairs[0], body.pairs[1]
    turning = np.array([[0.0, -spin[2], spin[1]], [spin[2], 0.0, -spin[0]], [-spin[1], spin[0], 0.0]])
    moving = turning @ turning
    moving += np.array([[0.0, -rates[5], rates[4]], [rates[5], 0.0, -rates[3]], [-rates[4], rates[3], 0.0]])
    load = np.zeros(forces.size)
    for p in range(3):
        for r in range(3):
            c, d = weight * moving[p, r], 2.0 * weight * turning[p, r]
            if c != 0.0 or d != 0.0:
                for k in range(first[3 * p + r], first[3 * p + r + 1]):
                    forces[line[k]] += c * momenta.lines[0, k] + d * momenta.lines[1, k]
        for k in range(body.start[p], body.start[p + 1]):
            moment = body.moment[k]
            total = rates[p] * moment[0]
            for b in range(3):
                total += moving[p, b] * moment[1 + b]
            load[body.place[k]] += weight * total
    load_square, square = 0.0, 0.0
    for i in range(forces.size):
        forces[i] += load[i]
        load_square += load[i] * load[i]
        square += forces[i] * forces[i]
    return np.sqrt(load_square), np.sqrt(square)


@jit
def rigid_coupling(body: Body, momenta: Momenta, size: int) -> Array:
    """B(q), shape (6, size): its rows are the forces of unit rates."""
    result, rates, still = np.zeros((6, size)), np.eye(6), np.zeros(3)
    for k in range(6):
        add_frame_forces(body, momenta, still, rates[k], 1.0, result[k])
    return result


@jit
def motion_at(
    numbers: Array, x: Array, q: Array, v: Array, a: Array, balanced: Array
) -> tuple[Array, Array, Array]:
    """Displacement, velocity and acceleration of an iterate, each of shape (size,).

    Parameters
    ----------
    numbers
        Factors of (x, v, a) in the velocity, and of (x, v, a, balanced) in the acceleration, shape (7,).
    x
        Increment.
    q, v, a, balanced
        At the start of the step; an empty ``balanced`` has no factor.
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
    body: Body, numbers: Array, x: Array, q: Array, v: Array, a: Array, balanced: Array, start: RigidState,
    reach: float, wrench: Array, twist: Array, weight: float, forces: Array,
) -> tuple[RigidState, float, float]:  # fmt: skip
    """All that a hub under a known wrench adds to the forces of an iterate: `motion_at` to `add_frame_forces`."""
    displacement, velocity, acceleration = motion_at(numbers, x, q, v, a, balanced)
    momenta = momenta_of(body, displacement, velocity, acceleration)
    rigid = with_rates(body, momenta, advance(body, momenta, start, reach, wrench, twist))
    load, norm = add_frame_forces(body, momenta, rigid.twist[3:], rigid.rates, weight, forces)
    return rigid, load, norm
