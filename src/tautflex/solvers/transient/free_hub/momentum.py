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
    """Constant moments of a structure and its hub; compiled code takes them as a plain tuple, which enters faster.

    Parameters
    ----------
    first, line, which
        Of the products ``int rho N_a' N_b``: first line of each pair (a, b), its row, and the product that it is.
    start, column, value
        The different products by rows: the three directions of a node that only moves share theirs.
    begin, place, moment
        For each direction a: unknowns that move along it, and ``int rho N_a' (1, x, y, z)`` of them.
    mass
        Of both [kg].
    center
        ``int rho x`` of both [kg m], shape (3,).
    second
        ``int rho x x'`` of the structure [kg m^2], shape (3, 3).
    tensor
        Inertia of the hub about O [kg m^2], shape (3, 3).
    """

    first: Indices
    line: Places
    which: Places
    start: Indices
    column: Places
    value: Array
    begin: Indices
    place: Places
    moment: Array
    mass: float
    center: Array
    second: Array
    tensor: Array

    @classmethod
    def of(cls, inertia: InertiaOperator, hub: FreeHub) -> Body:
        """Moments of a structure with this inertia on a hub."""
        first, line, start, column, value = inertia.pairs
        seen: dict[bytes, int] = {}
        which, kept = np.empty(line.size, dtype=np.uint32), list[int]()
        for k in range(line.size):
            key = column[start[k] : start[k + 1]].tobytes() + value[start[k] : start[k + 1]].tobytes()
            which[k] = seen.setdefault(key, len(seen))
            if len(kept) < len(seen):
                kept.append(k)
        entries = np.concatenate([np.zeros(0, dtype=np.int64), *(np.arange(start[k], start[k + 1]) for k in kept)])
        center = np.asarray(hub.center, dtype=float)
        moments = np.concatenate([inertia.zeroth_moment[:, None], inertia.first_moment], axis=1)
        places = [np.flatnonzero(np.any(moment != 0.0, axis=0)) for moment in moments]
        return cls(
            first,
            line,
            which,
            np.concatenate([[0], np.cumsum(np.diff(start)[kept])]),
            column[entries],
            value[entries],
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
    products
        ``int rho N_a' u_b`` and ``int rho N_a' du_b``, the different ones of all lines, shape (2, products).
    mass
        R(q), shape (6, 6).
    relative
        ``B dq``, shape (6,).
    flow
        D, shape (3, 3).
    push
        ``B ddq``, shape (6,).
    """

    products: Array
    mass: Array
    relative: Array
    flow: Array
    push: Array


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


_parts = jit_in_order(rigid_parts)


@jit
def _moment_of(lever: Array) -> Array:
    """``int rho x y`` from ``lever_ab = int rho_a y_b``, shape (3,)."""
    return np.array([lever[1, 2] - lever[2, 1], lever[2, 0] - lever[0, 2], lever[0, 1] - lever[1, 0]])


@jit
def _products(body: tuple[Any, ...], q: Array, v: Array) -> Array:
    """The different products of two vectors, shape (2, products)."""
    start, column, value = body[3], body[4], body[5]
    products = np.empty((2, start.size - 1))
    for k in range(start.size - 1):
        y, z = 0.0, 0.0
        for entry in range(np.uint64(start[k]), np.uint64(start[k + 1])):
            y += value[entry] * q[column[entry]]
            z += value[entry] * v[column[entry]]
        products[0, k], products[1, k] = y, z
    return products


@jit
def _forms(body: tuple[Any, ...], products: Array, q: Array, v: Array, a: Array) -> Array:
    """``int rho u_a y_b`` for y of the vectors q, v, a, shape (3, 3, 3), from the products of q."""
    first, line, which, forms = body[0], body[1], body[2], np.empty((3, 3, 3))
    for p in range(3):
        for r in range(3):
            e, f, g = 0.0, 0.0, 0.0
            for k in range(first[3 * p + r], first[3 * p + r + 1]):
                y, row = products[0, which[k]], line[k]
                e += q[row] * y
                f += v[row] * y
                g += a[row] * y
            forms[0, r, p], forms[1, r, p], forms[2, r, p] = e, f, g
    return forms


@jit
def _moments(body: tuple[Any, ...], q: Array, v: Array, a: Array) -> Array:
    """``int rho (1, x, y, z)_a y_b`` for y of the vectors q, v, a, shape (3, 4, 3)."""
    begin, place, moment, moments = body[6], body[7], body[8], np.empty((3, 4, 3))
    for p in range(3):
        for b in range(4):
            e, f, g = 0.0, 0.0, 0.0
            for k in range(begin[p], begin[p + 1]):
                c, row = moment[k, b], place[k]
                e += c * q[row]
                f += c * v[row]
                g += c * a[row]
            moments[0, b, p], moments[1, b, p], moments[2, b, p] = e, f, g
    return moments


@jit
def momenta_of(body: tuple[Any, ...], q: Array, v: Array, a: Array) -> Momenta:
    """Momenta of the structure at elastic unknowns, velocities and accelerations, each of shape (size,)."""
    products = _products(body, q, v)
    forms, moments = _forms(body, products, q, v, a), _moments(body, q, v, a)
    mixed, square = moments[0, 1:], forms[0]
    second = body[11] + mixed + mixed.T + 0.5 * (square + square.T)
    mass = np.zeros((6, 6))
    mass[3:, 3:] = body[12] - second
    x, y, z = body[10][0] + moments[0, 0, 0], body[10][1] + moments[0, 0, 1], body[10][2] + moments[0, 0, 2]
    for k in range(3):
        mass[k, k] = body[9]
        mass[3 + k, 3 + k] += second[0, 0] + second[1, 1] + second[2, 2]
    mass[5, 1] = mass[1, 5] = x
    mass[4, 2] = mass[2, 4] = -x
    mass[3, 2] = mass[2, 3] = y
    mass[5, 0] = mass[0, 5] = -y
    mass[4, 0] = mass[0, 4] = z
    mass[3, 1] = mass[1, 3] = -z
    flow, kick = moments[1, 1:] + forms[1], moments[2, 1:] + forms[2]
    relative, push = np.empty(6), np.empty(6)
    relative[:3], relative[3:] = moments[1, 0], _moment_of(flow)
    push[:3], push[3:] = moments[2, 0], _moment_of(kick)
    return Momenta(products, mass, relative, flow, push)


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
def _advance(momenta: Momenta, start: Array, reach: float, wrench: Array, twist: Array) -> Array:
    """Hub at ``reach`` [s] after ``start`` from the balance of momenta; attitude by the mean angular velocity.

    Parameters
    ----------
    momenta
        Of the structure at the end.
    start
        Hub before, shape (31,).
    reach
        Time between [s].
    wrench
        On the end, in hub axes, shape (6,).
    twist
        First guess of that of the end, shape (6,).

    Returns
    -------
    numpy.ndarray
        The hub, shape (31,), with the accelerations that balance its momenta. The impulse is that of the trapezoidal
        rule. A fixed-point iteration over attitude and velocities, which contracts by (reach times spin), down to
        round-off, where the changes stop falling.
    """
    before, lower, last = _parts(start), _cholesky(momenta.mass), np.inf
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
        twist = _solve(lower, _turned(axes.T, about) - momenta.relative)
        change = np.abs(twist - after.twist).max()
        after.twist[:] = twist
        if not 0.5 * _ROUND_OFF * np.abs(twist).max() < change < last:
            break
        last = change
    after.attitude[:] /= np.sqrt(np.sum(after.attitude * after.attitude))
    after.rates[:] = _solve(lower, _rate_forces(momenta, wrench, after.twist))
    return end


@jit_in_order
def _rate_forces(momenta: Momenta, wrench: Array, twist: Array) -> Array:
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
def _add_frame_forces(
    body: tuple[Any, ...], products: Array, twist: Array, rates: Array, weight: float, forces: Array
) -> tuple[float, float]:
    """Add the forces of a frame with this twist and these rates to ``forces``, shape (size,).

    They are ``weight (M(2 S(w)) dq + M(Z) q + int rho N' (Z x + a0))`` with ``Z = S(dw) + S(w)^2``. Returns the norms of
    the part that does not depend on q, and of all the forces after it.
    """
    first, line, which, _, _, _, begin, place, moment, _, _, _, _ = body
    x, y, z = twist[3], twist[4], twist[5]
    turning = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    moving = np.array(
        [
            [-y * y - z * z, x * y - rates[5], x * z + rates[4]],
            [x * y + rates[5], -x * x - z * z, y * z - rates[3]],
            [x * z - rates[4], y * z + rates[3], -x * x - y * y],
        ]
    )
    load = np.zeros(forces.size)
    for p in range(3):
        for r in range(3):
            c, d = weight * moving[p, r], 2.0 * weight * turning[p, r]
            if c != 0.0 or d != 0.0:
                for k in range(first[3 * p + r], first[3 * p + r + 1]):
                    forces[line[k]] += c * products[0, which[k]] + d * products[1, which[k]]
        a, b, c, d = weight * rates[p], weight * moving[p, 0], weight * moving[p, 1], weight * moving[p, 2]
        for k in range(begin[p], begin[p + 1]):
            load[place[k]] += a * moment[k, 0] + b * moment[k, 1] + c * moment[k, 2] + d * moment[k, 3]
    load_square, square = 0.0, 0.0
    for i in range(forces.size):
        forces[i] += load[i]
        load_square += load[i] * load[i]
        square += forces[i] * forces[i]
    return np.sqrt(load_square), np.sqrt(square)


@jit
def rigid_blocks(body: tuple[Any, ...], q: Array) -> tuple[Array, Array]:
    """R(q), shape (6, 6), and B(q), shape (6, size), whose rows are the forces of unit rates."""
    still, rates, coupling = np.zeros(q.size), np.eye(6), np.zeros((6, q.size))
    momenta = momenta_of(body, q, still, still)
    for k in range(6):
        _add_frame_forces(body, momenta.products, np.zeros(6), rates[k], 1.0, coupling[k])
    return momenta.mass, coupling


@jit
def add_forces_at_rates(body: tuple[Any, ...], q: Array, v: Array, a: Array, rigid: Array, forces: Array) -> Array:
    """Add the forces that a moving hub leaves to a structure at q, v, a to ``forces``; see `add_hub_forces`.

    The hub, shape (31,), is returned with the rates that balance its momenta.
    """
    momenta, end = momenta_of(body, q, v, a), rigid.copy()
    parts = _parts(end)
    parts.rates[:] = _solve(_cholesky(momenta.mass), _rate_forces(momenta, parts.wrench, parts.twist))
    _add_frame_forces(body, momenta.products, parts.twist, parts.rates, 1.0, forces)
    return end


@jit
def end_hub(
    body: tuple[Any, ...], q: Array, v: Array, a: Array, start: Array, reach: float, wrench: Array, twist: Array
) -> Array:
    """Hub at ``reach`` [s] after ``start`` with the structure at q, v, a there; see `_advance`."""
    return _advance(momenta_of(body, q, v, a), start, reach, wrench, twist)


@jit
def motion_at(numbers: Array, x: Array, q: Array, v: Array, a: Array, balanced: Array) -> tuple[Array, Array, Array]:
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
    body: tuple[Any, ...], numbers: Array, x: Array, q: Array, v: Array, a: Array, balanced: Array, start: Array,
    reach: float, wrench: Array, twist: Array, weight: float, forces: Array,
) -> tuple[Array, float, float]:  # fmt: skip
    """Add all that a hub under a wrench on the end leaves to an increment, see `motion_at`, to ``forces``.

    Returns the hub at the evaluation instant, shape (31,), and the norms of `_add_frame_forces`.
    """
    displacement, velocity, acceleration = motion_at(numbers, x, q, v, a, balanced)
    momenta = momenta_of(body, displacement, velocity, acceleration)
    end = _advance(momenta, start, reach, wrench, twist)
    parts = _parts(end)
    load, norm = _add_frame_forces(body, momenta.products, parts.twist, parts.rates, weight, forces)
    return end, load, norm
