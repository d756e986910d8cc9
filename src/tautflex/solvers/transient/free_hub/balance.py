"""Balance of the momenta of hub and structure: where a free hub is after a step [theory.md 9]; compiled."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.products import inner, product
from tautflex.motion.triples import Axes, Triple, after, axes_of, back, crossed, plus, put, quaternion_of, times, triple
from tautflex.numeric import Array, Indices, Places, jit
from tautflex.solvers.transient.free_hub.momentum import (
    Momenta,
    add_frame_forces,
    held_apart,
    momenta_of,
    rigid_blocks,
)

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


@jit
def _factorize(matrix: Array, first: int) -> None:
    """Put the lower factor L of ``L L'`` in the place of a matrix, shape (6, 6), from a row on.

    Its upper triangle stays, and what is before the row counts as zeros and ones.
    """
    for i in range(first, 6):
        for j in range(first, i + 1):
            value = matrix[i, j]
            for k in range(first, j):
                value -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = np.sqrt(value) if i == j else value / matrix[j, j]


@jit
def _substitute(lower: Array, first: int, x: Array) -> None:
    """Put the solution of ``L L' x = right`` in the place of the right-hand side, from a row on."""
    for i in range(first, 6):
        for k in range(first, i):
            x[i] -= lower[i, k] * x[k]
        x[i] /= lower[i, i]
    for i in range(5, first - 1, -1):
        for k in range(i + 1, 6):
            x[i] -= lower[k, i] * x[k]
        x[i] /= lower[i, i]


@jit
def cholesky(matrix: Array) -> Array:
    """Factor for `solve` of a matrix, shape (6, 6)."""
    lower = matrix.copy()
    _factorize(lower, 0)
    return lower


@jit
def solve(lower: Array, right: Array) -> Array:
    """Solution with a matrix that `cholesky` has factorized, shape (6,)."""
    x = right.copy()
    _substitute(lower, 0, x)
    return x


@jit
def _rigid_factor(mass: Array, freedom: Array) -> tuple[Array, int]:
    """Factor of the mass of the free velocities, and the first of these, for `_substitute`."""
    lower, first = held_apart(mass, freedom), 0
    while first < 5 and freedom[first] == 0.0:
        first += 1
    _factorize(lower, first)
    return lower, first


@jit
def _with_moment(axes: Axes, place: Triple, force: Triple, moment: Triple) -> tuple[Triple, Triple]:
    """Force and moment about O in hub axes as those about the inertial origin in inertial axes."""
    turned = times(axes, force)
    return turned, plus(times(axes, moment), 1.0, crossed(place, turned))


@jit
def inertial(attitude: Array, position: Array, vector: Array) -> Array:
    """Force and moment about O in hub axes as force and moment about the inertial origin in inertial axes, (6,)."""
    axes = axes_of((attitude[0], attitude[1], attitude[2], attitude[3]))
    result = np.empty(6)
    force, moment = _with_moment(axes, triple(position, 0), triple(vector, 0), triple(vector, 3))
    put(result, 0, force)
    put(result, 3, moment)
    return result


@jit
def advance(momenta: Momenta, freedom: Array, start: Array, reach: float, wrench: Array, twist: Array) -> Array:
    """Hub at ``reach`` [s] after ``start`` from the balance of momenta, with the accelerations that keep it.

    ``momenta`` are those of the structure at the end, ``wrench`` acts there, and ``twist`` is a first guess. Attitude
    follows the mean angular velocity, the impulse is that of the trapezoidal rule. A fixed-point iteration over
    attitude and velocities, which contracts by (reach times spin), down to round-off, where the changes stop falling.
    """
    lower, first = _rigid_factor(momenta.mass, freedom)
    half, last, relative = 0.5 * reach, np.inf, momenta.relative
    before, place, spin = (start[0], start[1], start[2], start[3]), triple(start, 4), triple(start, 10)
    axes = axes_of(before)
    velocity = times(axes, triple(start, 7))
    pulled, bent = _with_moment(axes, place, triple(start, 19), triple(start, 22))
    attitude, position, linear, angular = before, place, pulled, bent
    # The hub, and behind it what is solved for.
    room = np.empty(37)
    end, new = room[:31], room[31:]
    for k in range(6):
        end[7 + k], end[19 + k] = twist[k], wrench[k]
    for _ in range(_MOST_TURNS):
        mean = plus(spin, 1.0, triple(end, 10))
        attitude = after(before, quaternion_of((half * mean[0], half * mean[1], half * mean[2])))
        axes = axes_of(attitude)
        position = plus(place, half, plus(velocity, 1.0, times(axes, triple(end, 7))))
        pull, bend = _with_moment(axes, position, triple(wrench, 0), triple(wrench, 3))
        linear = plus(triple(start, 13), half, plus(pulled, 1.0, pull))
        angular = plus(triple(start, 16), half, plus(bent, 1.0, bend))
        put(new, 0, back(axes, linear))
        put(new, 3, back(axes, plus(angular, -1.0, crossed(position, linear))))
        for k in range(6):
            new[k] = freedom[k] * (new[k] - relative[k])
        _substitute(lower, first, new)
        change, largest = 0.0, 0.0
        for k in range(6):
            change, largest = max(change, abs(new[k] - end[7 + k])), max(largest, abs(new[k]))
            end[7 + k] = new[k]
        if not 0.5 * _ROUND_OFF * largest < change < last:
            break
        last = change
    w, x, y, z = attitude
    length = np.sqrt(w * w + x * x + y * y + z * z)
    end[0], end[1], end[2], end[3] = w / length, x / length, y / length, z / length
    put(end, 4, position)
    if first > 0:
        # What holds the hub takes up momentum.
        for k in range(6):
            new[k] = inner(momenta.mass[k], end[7:13]) + relative[k]
        linear, angular = _with_moment(
            axes_of((end[0], end[1], end[2], end[3])), position, triple(new, 0), triple(new, 3)
        )
    put(end, 13, linear)
    put(end, 16, angular)
    _put_rates(momenta, freedom, lower, first, end)
    return end


@jit
def _put_rates(momenta: Momenta, freedom: Array, lower: Array, first: int, hub: Array) -> None:
    """Put the accelerations of a hub under its wrench in their place; the factor is that of `_rigid_factor`."""
    rates, right = hub[25:31], rate_forces(momenta, hub[19:25], hub[7:13])
    for k in range(6):
        rates[k] = freedom[k] * right[k]
    _substitute(lower, first, rates)


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
    spin, flow, mass, push, right = triple(twist, 3), momenta.flow, momenta.mass, momenta.push, np.empty(6)
    inertia = triple(mass[3], 3), triple(mass[4], 3), triple(mass[5], 3)
    moment, whirled = (mass[1, 5], mass[2, 3], mass[0, 4]), times(inertia, spin)
    linear = crossed(spin, plus(crossed(spin, moment), 2.0, triple(momenta.relative, 0)))
    angular, trace = crossed(spin, whirled), flow[0, 0] + flow[1, 1] + flow[2, 2]
    columns = triple(flow[0], 0), triple(flow[1], 0), triple(flow[2], 0)
    angular = plus(plus(angular, 2.0 * trace, spin), -2.0, back(columns, spin))
    for k in range(6):
        right[k] = wrench[k] - push[k]
    put(right, 0, plus(triple(right, 0), -1.0, linear))
    put(right, 3, plus(triple(right, 3), -1.0, angular))
    return right


@jit
def add_forces_at_rates(body: tuple[Any, ...], q: Array, v: Array, a: Array, rigid: Array, forces: Array) -> Array:
    """Add the forces of a known hub with the structure at q, v, a to ``forces``; the hub with the rates that follow."""
    momenta, end = momenta_of(body, q, v, a), rigid.copy()
    lower, first = _rigid_factor(momenta.mass, body[13])
    _put_rates(momenta, body[13], lower, first, end)
    add_frame_forces(body, momenta.products, end[7:13], end[25:31], 1.0, forces)
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
    rows = np.empty((3, x.size))
    displacement, velocity, acceleration = rows[0], rows[1], rows[2]
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
    load, norm = add_frame_forces(body, momenta.products, end[7:13], end[25:31], weight, forces)
    return end, load, norm
