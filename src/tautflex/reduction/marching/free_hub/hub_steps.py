"""Compiled time stepping of a reduced model on a free hub [theory.md 9].

Coordinates step as under a prescribed motion. The hub's velocities are not integrated: they follow from the momenta,
which forces from outside alone change, so that momenta are exact whatever the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.dispatch import internal_force
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import (
    MOMENTUM,
    RATES,
    TWIST,
    WRENCH,
    HubPlace,
    add_carried,
    add_centrifugal,
    add_coriolis,
    add_late_coriolis,
    place_hub,
    ride_to,
    shared_rates,
    solve_rates,
    spin,
    turn,
)
from tautflex.reduction.marching.free_hub.hub_mobile import mobile_square, solve_mass, stable
from tautflex.reduction.marching.free_hub.hub_work import (
    DONE,
    KNOWN,
    POWER,
    HubWork,
    enter_rigid,
    enter_rows,
    given_power,
    set_inputs,
)
from tautflex.reduction.marching.steps import CHECK_INTERVAL, anew_power
from tautflex.reduction.marching.work import Work
from tautflex.reduction.polynomial.forces import add_times, dot
from tautflex.solvers.transient.free_hub.balance import inertial


@jit
def explicit_step(
    arrays: Any, hub: HubArrays, inputs: HubInputs, row: int, size: float, work: Work, ride: HubWork
) -> bool:
    """One step of central differences; False where it is not stable.

    Damping at the end is solved for, and so are the accelerations that hub and coordinates share. Coriolis forces take
    the velocity at the end from the one before (they are smaller than the inertia by the step times the spin), those
    between monomials and coordinates the predicted one. ``work.inverse`` is that of ``M + h C / 2``.
    """
    r, at, end, inverse = work.q.size, ride.at, ride.moved, work.inverse[0]
    space = ride.space
    half, q, v, free, known, force = space[0], space[1], space[2], space[3], space[4], space[5]
    axis = 3 + hub.turns[0] if hub.turns.size == 1 else -1
    for i in range(r):
        half[i] = work.v[i] + 0.5 * size * work.a[i]
        q[i], v[i] = work.q[i] + size * half[i], half[i] + 0.5 * size * work.a[i]
    set_inputs(arrays, inputs, row, q, ride)
    internal_force(arrays, q, v, ride.given, ride.parts)
    work.counts[3] += 1
    place_hub(hub, arrays, q, at)
    # Stiffness that this very step has felt, against what central differences can follow.
    free.fill(0.0)
    add_times(1.0, arrays.mass, half, free)
    felt, moving = (
        -size * anew_power(arrays, ride.given, ride.last, q, half),
        dot(half, free) - mobile_square(hub, ride, half),
    )
    for i in range(r):
        felt += size * half[i] * (ride.parts[i] - work.forces[i])
    if not felt <= 4.0 * moving * (1.0 + 1e-9) + 1e-300:
        return False
    solve_mass(hub, inverse, ride)
    late = ride.rows[3]
    late.fill(0.0)
    for k in range(6):
        end[TWIST + k] = ride.rigid[TWIST + k] + size * ride.rigid[RATES + k]
        end[RATES + k] = ride.rigid[RATES + k]
    add_late_coriolis(hub, arrays, at, q, v, end[TWIST:MOMENTUM], late)
    for i in range(r):
        known[i] = ride.parts[i] + ride.load[0, i] + late[i]
    add_times(1.0, arrays.damping, half, known)
    twist, rates = end[TWIST:MOMENTUM], end[RATES:]
    for _ in range(2):
        if axis > 0:
            spin(axis, at.coupling[axis], at.mass[axis, axis], v, ride.rigid, size, ride.wrench, end)
        else:
            ride_to(hub, arrays, at, v, work.a, ride.rigid, size, ride.wrench, end)
        force.fill(0.0)
        add_coriolis(hub.turns, hub.spin, v, twist, force)
        add_centrifugal(hub.turns, hub.first, hub.second, at.pulls, twist, force)
        for i in range(r):
            known[i] += force[i]
        free.fill(0.0)
        add_times(-1.0, inverse, known, free)
        solve_rates(hub, arrays, at, ride.solved, v, free, twist, ride.wrench, rates)
        for i in range(r):
            known[i] -= force[i]
            for k in range(6):
                if rates[k] != 0.0:
                    free[i] -= rates[k] * ride.solved[k, i]
            v[i] = half[i] + 0.5 * size * free[i]
    add_carried(at.coupling, rates, force)
    if axis > 0:
        spin(axis, at.coupling[axis], at.mass[axis, axis], v, ride.rigid, size, ride.wrench, end)
        turn(axis - 3, ride.rigid, size, end)
    else:
        ride_to(hub, arrays, at, v, free, ride.rigid, size, ride.wrench, end)
    rows = ride.rows
    for i in range(r):
        rows[0, i], rows[2, i], rows[3, i] = 0.0, ride.parts[r + i] - ride.load[1, i], late[i] + force[i]
        rows[1, i], rows[4, i] = ride.parts[i] - ride.parts[r + i], ride.load[0, i] + ride.load[1, i]
    add_times(1.0, arrays.mass, free, rows[0])
    add_times(1.0, arrays.damping, v, rows[2])
    enter_rigid(ride, end, v, size)
    enter_rows(ride, 1.0, size, size, work.q, q)
    for i in range(r):
        work.q[i], work.v[i], work.a[i], work.forces[i] = q[i], v[i], free[i], ride.parts[i]
    for k in range(31):
        ride.rigid[k] = end[k]
    for k in range(ride.given.size):
        ride.last[k] = ride.given[k]
    work.counts[0] += 1
    return True


@jit
def balance(
    arrays: Any, hub: HubArrays, inputs: HubInputs, row: int, work: Work, ride: HubWork, explicit: bool
) -> None:
    """Accelerations that balance all forces at the present state, and the forces that steps take over from it."""
    r, at, rigid = work.q.size, ride.at, ride.rigid
    place_hub(hub, arrays, work.q, at)
    set_inputs(arrays, inputs, row, work.q, ride)
    internal_force(arrays, work.q, work.v, ride.given, ride.parts)
    twist, rates, now = rigid[TWIST:MOMENTUM], rigid[RATES:], ride.now
    frame, force, free = now[3], ride.space[0], ride.space[1]
    now.fill(0.0)
    free.fill(0.0)
    add_late_coriolis(hub, arrays, at, work.q, work.v, twist, frame)
    add_coriolis(hub.turns, hub.spin, work.v, twist, frame)
    add_centrifugal(hub.turns, hub.first, hub.second, at.pulls, twist, frame)
    add_times(1.0, arrays.damping, work.v, now[2])
    for i in range(r):
        force[i] = ride.parts[i] + now[2, i] + frame[i] + ride.load[0, i]
        now[1, i], now[4, i] = ride.parts[i] - ride.parts[r + i], ride.load[0, i] + ride.load[1, i]
        now[2, i] += ride.parts[r + i] - ride.load[1, i]
    add_times(-1.0, ride.inverse, force, free)
    solve_mass(hub, ride.inverse, ride)
    solve_rates(hub, arrays, at, ride.solved, work.v, free, twist, ride.wrench, rates)
    add_carried(at.coupling, rates, frame)
    add_carried(at.coupling, rates, force)
    for i in range(r):
        for k in range(6):
            free[i] -= rates[k] * ride.solved[k, i]
        work.a[i], work.jerk[i], ride.balanced[i] = free[i], 0.0, free[i]
        work.forces[i] = ride.parts[i] if explicit else force[i]
    for k in range(6):
        rigid[WRENCH + k] = ride.wrench[k]
    _restart(ride, work.v)


@jit
def _restart(ride: HubWork, v: Array) -> None:
    """Power of what acts from outside at the present state, and what is given; forces by kind are not known now."""
    ride.marks[KNOWN], ride.marks[POWER] = 0.0, given_power(ride, v)
    for k in range(ride.given.size):
        ride.last[k] = ride.given[k]
    for k in range(6):
        ride.marks[POWER] += ride.rigid[WRENCH + k] * ride.rigid[TWIST + k]


@jit
def start_hub(hub: HubArrays, arrays: Any, work: Work, ride: HubWork) -> None:
    """Momentum of the present state, from its attitude, position and velocities."""
    rigid, at = ride.rigid, ride.at
    place_hub(hub, arrays, work.q, at)
    if hub.turns.size == 1:
        row = 3 + hub.turns[0]
        momentum = at.mass[row, row] * rigid[TWIST + row] + dot(at.coupling[row], work.v)
        rigid[MOMENTUM + row] = momentum
        return
    whole = at.mass @ rigid[TWIST:MOMENTUM]
    for k in range(6):
        whole[k] += dot(at.coupling[k], work.v)
    rigid[MOMENTUM:WRENCH] = inertial(rigid[:4], rigid[4:7], whole)


@jit
def _given_force(arrays: Any, work: Work, ride: HubWork) -> Array:
    """The part of the internal force that depends on what inputs give to it, or all of it."""
    if ride.given.size == arrays.first.size:
        return ride.load[1].copy()
    internal_force(arrays, work.q, work.v, ride.given, ride.parts)
    return ride.parts[: work.q.size].copy()


@jit
def jump(
    arrays: Any, hub: HubArrays, before: HubInputs, last: int, after: HubInputs, row: int, work: Work, ride: HubWork,
    explicit: bool,
) -> bool:  # fmt: skip
    """Let what acts from outside jump; accelerations take up the change. Whether there is one."""
    r, at, rigid = work.q.size, ride.at, ride.rigid
    free, rates, wrench = np.zeros(r), np.zeros(6), np.empty(6)
    place_hub(hub, arrays, work.q, at)
    set_inputs(arrays, before, last, work.q, ride)
    load, inside, total = ride.load.copy(), _given_force(arrays, work, ride), 0.0
    for k in range(6):
        wrench[k] = ride.wrench[k]
    set_inputs(arrays, after, row, work.q, ride)
    inside = _given_force(arrays, work, ride) - inside
    change = inside + ride.load[0] - load[0]
    for i in range(r):
        total += abs(change[i])
    for k in range(6):
        wrench[k] = ride.wrench[k] - wrench[k]
        total += abs(wrench[k])
    if total == 0.0:
        return False
    add_times(-1.0, ride.inverse, change, free)
    solve_mass(hub, ride.inverse, ride)
    for k in range(6):
        wrench[k] = hub.freedom[k] * (wrench[k] - dot(at.coupling[k], free))
    if hub.turns.size == 1:
        k = 3 + hub.turns[0]
        rates[k] = wrench[k] / (at.mass[k, k] - dot(at.coupling[k], ride.solved[k]))
    else:
        rates[:] = shared_rates(hub, at, ride.solved, wrench)
    kind = 4 if ride.given.size == arrays.first.size else 1
    for i in range(r):
        ride.now[4, i] += ride.load[0, i] - load[0, i]
        ride.now[kind, i] += inside[i]
    add_carried(at.coupling, rates, change)
    add_carried(at.coupling, rates, ride.now[3])
    for i in range(r):
        for k in range(6):
            free[i] -= rates[k] * ride.solved[k, i]
        work.a[i] += free[i]
        ride.balanced[i] += free[i]
        work.jerk[i] = 0.0
        work.forces[i] += inside[i] if explicit else change[i]
    for k in range(6):
        rigid[WRENCH + k] = ride.wrench[k]
        rigid[RATES + k] += rates[k]
    _restart(ride, work.v)
    return True


@jit
def march_explicit(
    arrays: Any, hub: HubArrays, inputs: HubInputs, size: float, work: Work, ride: HubWork, rows: Indices,
    stored: tuple[Array, Array, Array, Array], trace: Array,
) -> int:  # fmt: skip
    """Steps of equal size [s]; how many were stable.

    Parameters
    ----------
    inputs
        At the end of every step.
    rows
        Where the state after each step is stored, -1: nowhere, shape (n,).
    stored
        Coordinates, their velocities, the hub and the work of what acts from outside, shapes (row, r), (row, r),
        (row, 31) and (row,).
    trace
        Gets coordinates, velocities and accelerations after every step, shape (n, 3, r), or (0, 3, r): not.
    """
    if work.sizes[0] != size:
        matrix = arrays.mass + 0.5 * size * arrays.damping
        work.inverse[0] = np.linalg.inv(matrix)
        work.sizes[0] = size
        work.counts[2] += 1
    for n in range(rows.size):
        if work.counts[0] % CHECK_INTERVAL == 0 and not stable(arrays, hub, inputs, n, size, work, ride):
            return n
        if not explicit_step(arrays, hub, inputs, n, size, work, ride):
            return n
        keep(work, ride, rows[n], stored, trace, n)
    return rows.size


@jit
def keep(
    work: Work, ride: HubWork, row: int, stored: tuple[Array, Array, Array, Array], trace: Array, number: int
) -> None:
    """Store the state after a step."""
    if trace.shape[0]:
        for i in range(work.q.size):
            trace[number, 0, i], trace[number, 1, i], trace[number, 2, i] = work.q[i], work.v[i], work.a[i]
    if row >= 0:
        for i in range(work.q.size):
            stored[0][row, i], stored[1][row, i] = work.q[i], work.v[i]
        for k in range(31):
            stored[2][row, k] = ride.rigid[k]
        stored[3][row] = ride.marks[DONE]


@jit
def carried(arrays: Any, whole: HubArrays, at: HubPlace, eta: Array, rate: Array, rigid: Array) -> Array:
    """Momenta about the inertial origin, inertial axes, and kinetic energy beside that of the elastic motion, (n, 7).

    ``whole`` are arrays of the hub with all its freedom: what holds it takes up momentum.
    """
    result = np.empty((eta.shape[0], 7))
    for n in range(eta.shape[0]):
        place_hub(whole, arrays, eta[n], at)
        twist = rigid[n, TWIST:MOMENTUM].copy()
        momentum, energy = at.mass @ twist, 0.0
        for k in range(6):
            relative = dot(at.coupling[k], rate[n])
            energy += twist[k] * (0.5 * momentum[k] + relative)
            momentum[k] += relative
        result[n, :6] = inertial(rigid[n, :4].copy(), rigid[n, 4:7].copy(), momentum)
        result[n, 6] = energy
    return result
