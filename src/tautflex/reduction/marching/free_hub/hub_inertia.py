"""Where a free hub is that carries a reduced model, and the forces of its frame [theory.md 9]; compiled.

What depends on the place alone is computed once (`place_hub`); then momentum, Coriolis and centrifugal forces of any
velocities are products of few numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays
from tautflex.reduction.polynomial.forces import dot
from tautflex.solvers.transient.free_hub.balance import advance, cholesky, rate_forces, solve
from tautflex.solvers.transient.free_hub.momentum import Momenta, held_apart

# Parts of the hub's state, shape (31,), see `RigidState`.
TWIST, MOMENTUM, WRENCH, RATES = 7, 13, 19, 25


class HubPlace(NamedTuple):
    """What the last place of the coordinates makes of the hub's inertia.

    Parameters
    ----------
    mass
        R, shape (6, 6).
    coupling
        G = ``B dz/deta``, shape (6, r): the structure's momentum is ``G deta/dt``.
    follow
        B on the monomials, shape (6, m).
    pulls
        Centrifugal force of unit rates about pairs of axes, shape (k, r): ``dJ/dt = -2 pulls deta/dt``.
    monomials, monomial_rates
        Monomials, and space for their rates, shape (m,).
    on_monomials
        Space, shape (m,).
    """

    mass: Array
    coupling: Array
    follow: Array
    pulls: Array
    monomials: Array
    monomial_rates: Array
    on_monomials: Array


def new_place(hub: HubArrays) -> HubPlace:
    """Zeros of the right shapes."""
    (_, size), (_, count), pairs = hub.reach.shape, hub.reach_follow.shape, len(hub.first)
    shapes = (6, 6), (6, size), (6, count), (pairs, size), (count,), (count,), (count,)
    return HubPlace(*(np.zeros(shape) for shape in shapes))


@jit
def add_slopes(first: Indices, second: Indices, stress: Array, q: Array, force: Array) -> None:
    """Add ``Y' stress`` to ``force``."""
    for k in range(stress.size):
        i, j = first[k], second[k]
        force[i] += stress[k] * q[j]
        force[j] += stress[k] * q[i]


@jit
def _follow(table: Array, sign: float, q: Array, y: Array, on_q: Array, on_y: Array) -> None:
    """Add ``sign T y`` to ``on_q`` and ``T' q`` to ``on_y``."""
    for j in range(q.size):
        total, factor = 0.0, q[j]
        for k in range(y.size):
            total += table[j, k] * y[k]
            on_y[k] += factor * table[j, k]
        on_q[j] += sign * total


@jit
def place_hub(hub: HubArrays, arrays: Any, q: Array, at: HubPlace) -> None:
    """Fill ``at`` for coordinates q."""
    r, y = q.size, at.monomials
    for k in range(y.size):
        y[k] = q[arrays.first[k]] * q[arrays.second[k]]
    for n in range(hub.turns.size):
        row = 3 + hub.turns[n]
        on_q, on_y = at.coupling[row], at.follow[row]
        for k in range(y.size):
            on_y[k] = hub.reach_follow[row, k]
        for i in range(r):
            total = hub.reach[row, i]
            for j in range(r):
                total += hub.spin[n, i, j] * q[j]
            on_q[i] = total
        if hub.spun[n] != 0.0:
            _follow(hub.spin_follow[n], -1.0, q, y, on_q, on_y)
        add_slopes(arrays.first, arrays.second, on_y, q, on_q)
    for p in range(hub.first.size):
        on_q, on_y, inertia = at.pulls[p], at.on_monomials, 0.0
        for k in range(y.size):
            on_y[k] = hub.pull_follow[p, k]
        for i in range(r):
            total = hub.pull[p, i]
            for j in range(r):
                total += hub.square[p, i, j] * q[j]
            on_q[i] = total
        if hub.squared[p] != 0.0:
            _follow(hub.square_follow[p], 1.0, q, y, on_q, on_y)
        inertia = dot(on_q, q) + dot(on_y, y) + dot(hub.pull[p], q) + dot(hub.pull_follow[p], y)
        add_slopes(arrays.first, arrays.second, on_y, q, on_q)
        a, b = hub.turns[hub.first[p]], hub.turns[hub.second[p]]
        at.mass[3 + a, 3 + b] = at.mass[3 + b, 3 + a] = hub.tensor[a, b] - inertia
    if hub.turns.size == 3:
        for p in range(3):
            on_q, on_y, moment = at.coupling[p], at.follow[p], hub.center[p]
            for k in range(y.size):
                on_y[k] = hub.reach_follow[p, k]
                moment += on_y[k] * y[k]
            for i in range(r):
                on_q[i] = hub.reach[p, i]
                moment += on_q[i] * q[i]
            add_slopes(arrays.first, arrays.second, on_y, q, on_q)
            at.mass[p, p] = hub.mass
            # -S(s) above, S(s) below the diagonal.
            b, c = (p + 1) % 3, (p + 2) % 3
            at.mass[b, 3 + c] = at.mass[3 + c, b] = moment
            at.mass[c, 3 + b] = at.mass[3 + b, c] = -moment


@jit
def momenta_at(hub: HubArrays, arrays: Any, at: HubPlace, v: Array, a: Array) -> Momenta:
    """Momenta of the structure at the place with velocities and accelerations of its coordinates."""
    relative, push, flow = np.zeros(6), np.zeros(6), np.zeros((3, 3))
    for k in range(6):
        relative[k], push[k] = (
            dot(at.coupling[k], v),
            dot(at.coupling[k], a) + bend(arrays.first, arrays.second, at.follow[k], v),
        )
    # The rate of J, and int rho_a du_b that belongs to it.
    for p in range(hub.first.size):
        i, j = hub.turns[hub.first[p]], hub.turns[hub.second[p]]
        flow[i, j] = flow[j, i] = dot(at.pulls[p], v)
    trace = -0.5 * (flow[0, 0] + flow[1, 1] + flow[2, 2])
    for k in range(3):
        flow[k, k] += trace
        i, j = (k + 1) % 3, (k + 2) % 3
        flow[i, j] += 0.5 * relative[3 + k]
        flow[j, i] -= 0.5 * relative[3 + k]
    return Momenta(at.follow, at.mass, relative, flow, push)


@jit
def bend(first: Indices, second: Indices, on_y: Array, v: Array) -> float:
    """``2 B y(v)``: what the monomials' curvature adds to the rate of a momentum."""
    total = 0.0
    for k in range(on_y.size):
        total += on_y[k] * v[first[k]] * v[second[k]]
    return 2.0 * total


@jit
def ride_to(
    hub: HubArrays, arrays: Any, at: HubPlace, v: Array, a: Array, start: Array, reach: float, wrench: Array, end: Array
) -> None:
    """Fill ``end`` with the hub at ``reach`` [s] after ``start``, the structure at the place with v and a.

    About one axis the momentum is that about it; else ``end`` holds a first guess of the twist, see `advance`.
    """
    if hub.turns.size > 1:
        end[:] = advance(momenta_at(hub, arrays, at, v, a), hub.freedom, start, reach, wrench, end[TWIST:MOMENTUM])
        return
    row = 3 + hub.turns[0]
    spin(row, at.coupling[row], at.mass[row, row], v, start, reach, wrench, end)
    turn(row - 3, start, reach, end)
    left = (
        wrench[row]
        + 2.0 * dot(at.pulls[0], v) * end[TWIST + row]
        - bend(arrays.first, arrays.second, at.follow[row], v)
    )
    end[RATES + row] = (left - dot(at.coupling[row], a)) / at.mass[row, row]


@jit
def spin(
    row: int, coupling: Array, inertia: float, v: Array, start: Array, reach: float, wrench: Array, end: Array
) -> None:
    """Fill momentum, rate and wrench of a hub that turns about one axis with this inertia, see `ride_to`."""
    momentum = start[MOMENTUM + row] + 0.5 * reach * (start[WRENCH + row] + wrench[row])
    end[MOMENTUM + row] = momentum
    end[TWIST + row] = (momentum - dot(coupling, v)) / inertia
    for k in range(6):
        end[WRENCH + k] = wrench[k]


@jit
def turn(axis: int, start: Array, reach: float, end: Array) -> None:
    """Fill the attitude of a hub that turns about one axis: it follows the mean rate."""
    half = 0.25 * reach * (start[TWIST + 3 + axis] + end[TWIST + 3 + axis])
    w, s = np.cos(half), np.sin(half)
    one, two = 1 + (axis + 1) % 3, 1 + (axis + 2) % 3
    q, x, y, z = start[0], start[1 + axis], start[one], start[two]
    end[0], end[1 + axis], end[one], end[two] = q * w - x * s, q * s + x * w, y * w + z * s, z * w - y * s
    scale = 1.0 / np.sqrt(q * q + x * x + y * y + z * z)
    for k in range(4):
        end[k] *= scale


@jit
def add_coriolis(turns: Indices, spin: Array, v: Array, twist: Array, force: Array) -> None:
    """Add the Coriolis forces ``2 w A deta/dt`` of the coordinates alone."""
    for n in range(turns.size):
        factor = 2.0 * twist[3 + turns[n]]
        for i in range(v.size):
            total = 0.0
            for j in range(v.size):
                total += spin[n, i, j] * v[j]
            force[i] += factor * total


@jit
def add_late_coriolis(
    hub: HubArrays, arrays: Any, at: HubPlace, q: Array, v: Array, twist: Array, force: Array
) -> None:
    """Add the Coriolis forces between monomials and coordinates."""
    stress, rate = at.on_monomials, at.monomial_rates
    for k in range(rate.size):
        i, j = arrays.first[k], arrays.second[k]
        rate[k], stress[k] = q[i] * v[j] + v[i] * q[j], 0.0
    for n in range(hub.turns.size):
        factor = 2.0 * twist[3 + hub.turns[n]]
        if factor != 0.0 and hub.spun[n] != 0.0:
            table = hub.spin_follow[n]
            for j in range(v.size):
                total, forth = 0.0, factor * v[j]
                for k in range(rate.size):
                    total += table[j, k] * rate[k]
                    stress[k] += forth * table[j, k]
                force[j] -= factor * total
    add_slopes(arrays.first, arrays.second, stress, q, force)


@jit
def add_centrifugal(turns: Indices, first: Indices, second: Indices, pulls: Array, twist: Array, force: Array) -> None:
    """Add the centrifugal forces of a twist."""
    for p in range(first.size):
        a, b = turns[first[p]], turns[second[p]]
        factor = twist[3 + a] * twist[3 + b] * (1.0 if a == b else 2.0)
        for i in range(force.size):
            force[i] += factor * pulls[p, i]


@jit
def add_carried(coupling: Array, rates: Array, force: Array) -> None:
    """Add ``G' rates``, shape (6,); held rates are zero."""
    for k in range(6):
        if rates[k] != 0.0:
            for i in range(force.size):
                force[i] += rates[k] * coupling[k, i]


@jit
def solve_rates(
    hub: HubArrays, arrays: Any, at: HubPlace, solved: Array, v: Array, free: Array, twist: Array,
    wrench: Array, rates: Array,
) -> None:  # fmt: skip
    """Fill the rates with which ``M a = M a_free - G' rates`` and the hub's own balance hold.

    ``free`` is the acceleration without them, ``solved`` holds ``M^-1 G'`` by rows, shape (6, r), of free rates.
    """
    if hub.turns.size == 1:
        row = 3 + hub.turns[0]
        left = (
            wrench[row] + 2.0 * dot(at.pulls[0], v) * twist[row] - bend(arrays.first, arrays.second, at.follow[row], v)
        )
        left -= dot(at.coupling[row], free)
        rates[row] = left / (at.mass[row, row] - dot(at.coupling[row], solved[row]))
        return
    right = hub.freedom * rate_forces(momenta_at(hub, arrays, at, v, free), wrench, twist)
    rates[:] = shared_rates(hub, at, solved, right)


@jit
def shared_rates(hub: HubArrays, at: HubPlace, solved: Array, right: Array) -> Array:
    """Solution of ``(R - G M^-1 G') rates = right`` on the free rates, shape (6,)."""
    matrix = np.empty((6, 6))
    for i in range(6):
        for k in range(i + 1):
            matrix[i, k] = matrix[k, i] = at.mass[i, k] - dot(at.coupling[i], solved[k])
    return solve(cholesky(held_apart(matrix, hub.freedom)), right)
