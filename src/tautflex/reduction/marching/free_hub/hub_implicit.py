"""Compiled implicit steps of a reduced model on a free hub, by the stages of any method; twin of those of a full run.

As there, the hub's accelerations enter with the true elastic accelerations of the evaluation instant, which balance all
forces there, and the momenta that the increment leads to give its velocities; see
`tautflex.solvers.transient.free_hub.equation`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.dispatch import average_force, internal_force, tangent
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import (
    MOMENTUM,
    RATES,
    TWIST,
    add_carried,
    add_centrifugal,
    add_coriolis,
    add_late_coriolis,
    place_hub,
    ride_to,
)
from tautflex.reduction.marching.free_hub.hub_mobile import carried_mass
from tautflex.reduction.marching.free_hub.hub_steps import keep
from tautflex.reduction.marching.free_hub.hub_work import HubWork, enter_rigid, enter_rows, set_inputs
from tautflex.reduction.marching.steps import MOST_ITERATIONS, SCALE_FLOOR, SLOW, invert, lagging, mix, recall
from tautflex.reduction.marching.work import StageNumbers, Work
from tautflex.reduction.polynomial.forces import add_times, dot

_EPSILON = 2.220446049250313e-16


@jit
def _residual(
    arrays: Any, hub: HubArrays, inputs: HubInputs, row: int, c: StageNumbers, work: Work, ride: HubWork,
    start: tuple[Array, Array], d: Array, end: Array, rows: Array, forces: Array, result: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill residual, all forces but inertia at the evaluation instant, the same by kind, and the hub there.

    Returns the norms of the residual, and the largest of those of internal and frame forces.
    """
    r, parts, at = d.size, ride.parts, ride.at
    place = mix(1.0, work.q, 1.0, d, 0.0, d)
    velocity = mix(c.velocity[0], d, c.velocity[1], start[0], c.velocity[2], start[1])
    acceleration = mix(c.inertia[0], d, c.inertia[1], start[0], c.inertia[2], start[1])
    true = mix(1.0 / c.weight, acceleration, 1.0 - 1.0 / c.weight, ride.balanced, 0.0, d)
    set_inputs(arrays, inputs, row, place, ride)
    if c.average:
        average_force(arrays, work.q, mix(1.0, work.q, 1.0 / c.evaluation, d, 0.0, d), velocity, ride.given, parts)
    else:
        internal_force(arrays, place, velocity, ride.given, parts)
    work.counts[3] += 1
    place_hub(hub, arrays, place, at)
    ride_to(hub, arrays, at, velocity, true, ride.rigid, c.evaluation * c.size, ride.wrench, end)
    twist, frame = end[TWIST:MOMENTUM], rows[3]
    rows.fill(0.0)
    add_late_coriolis(hub, arrays, at, place, velocity, twist, frame)
    add_coriolis(hub.turns, hub.spin, velocity, twist, frame)
    add_centrifugal(hub.turns, hub.first, hub.second, at.pulls, twist, frame)
    add_carried(at.coupling, end[RATES:], frame)
    add_times(1.0, arrays.mass, acceleration, rows[0])
    add_times(1.0, arrays.damping, velocity, rows[2])
    inside, moving = 0.0, dot(frame, frame)
    for i in range(r):
        inside += parts[i] * parts[i]
        forces[i] = parts[i] + rows[2, i] + frame[i] + ride.load[0, i]
        rows[1, i], rows[4, i] = parts[i] - parts[r + i], ride.load[0, i] + ride.load[1, i]
        rows[2, i] += parts[r + i] - ride.load[1, i]
        result[i] = rows[0, i] + c.weight * forces[i] + (1.0 - c.weight) * work.forces[i]
    return np.sqrt(dot(result, result)), c.weight * np.sqrt(max(inside, moving))


@jit
def _renew(
    arrays: Any, hub: HubArrays, inputs: HubInputs, row: int, c: StageNumbers, q: Array, twist: Array, work: Work,
    ride: HubWork,
) -> bool:  # fmt: skip
    """Invert the effective stiffness at q, the last place of the hub; whether that was possible."""
    matrix, damping, carried = tangent(arrays, q, ride.given), lagging(arrays, q), carried_mass(hub, ride)
    damping += arrays.damping
    for n in range(hub.turns.size):
        damping += 2.0 * twist[3 + hub.turns[n]] * hub.spin[n]
    for p in range(hub.first.size):
        a, b = hub.turns[hub.first[p]], hub.turns[hub.second[p]]
        matrix += (twist[3 + a] * twist[3 + b] * (1.0 if a == b else 2.0)) * hub.square[p]
    matrix += c.velocity[0] * damping
    return invert(c.inertia[0] * (arrays.mass - carried) + c.weight * matrix, c.tangent, c.step, work)


@jit
def implicit_step(
    arrays: Any, hub: HubArrays, inputs: HubInputs, ends: HubInputs, row: int, c: StageNumbers, work: Work,
    ride: HubWork, tolerance: float,
) -> bool:  # fmt: skip
    """One stage; ``work`` and ``ride`` hold the new state if it converged and the old one if not."""
    r, end = work.q.size, ride.moved
    start = work.v, work.a
    if c.recalled.shape[0] > 0:
        start = recall(c, work)
    reach = c.evaluation * c.size
    d = mix(reach, work.v, 0.5 * reach * reach, work.a, reach**3 / 6.0, work.jerk)
    for k in range(6):
        end[TWIST + k] = ride.rigid[TWIST + k] + reach * ride.rigid[RATES + k]
        end[RATES + k] = ride.rigid[RATES + k]
    known = np.zeros(r)
    add_times(1.0, arrays.mass, mix(c.inertia[1], start[0], c.inertia[2], start[1], 0.0, d), known)
    rows, trial_rows = np.empty((5, r)), np.empty((5, r))
    forces, residual, trial, trial_forces = np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    norm, size = _residual(arrays, hub, inputs, row, c, work, ride, start, d, end, rows, forces, residual)
    lost = 100.0 * _EPSILON / tolerance * (np.sqrt(dot(known, known)) + np.sqrt(dot(work.forces, work.forces)))
    floor = max(c.weight * np.sqrt(dot(ride.load[0], ride.load[0])), lost, SCALE_FLOOR * work.scale[0])
    fresh, count = False, 0
    while not norm <= tolerance * max(size, floor):
        count += 1
        if count > MOST_ITERATIONS or not np.isfinite(norm):
            return False
        if work.sizes[c.tangent] != c.step:
            place = mix(1.0, work.q, 1.0, d, 0.0, d)
            place_hub(hub, arrays, place, ride.at)
            if not _renew(arrays, hub, inputs, row, c, place, end[TWIST:MOMENTUM], work, ride):
                return False
            fresh = True
        move = np.zeros(r)
        add_times(-1.0, work.inverse[c.tangent], residual, move)
        work.counts[1] += 1
        fraction = 1.0
        while True:
            moved = mix(1.0, d, fraction, move, 0.0, d)
            after, after_size = _residual(
                arrays, hub, inputs, row, c, work, ride, start, moved, end, trial_rows, trial_forces, trial
            )
            done = after <= tolerance * max(after_size, floor)
            if after < norm or done or not fresh or fraction < 1e-3:
                break
            fraction *= 0.5
        if not (after < norm or done or fresh):
            work.sizes[c.tangent] = 0.0
            continue
        if not (done or after <= SLOW * norm):
            work.sizes[c.tangent] = 0.0
        d, norm, size = moved, after, after_size
        residual, trial = trial, residual
        forces, trial_forces = trial_forces, forces
        rows, trial_rows = trial_rows, rows
        fresh = False
    work.scale[0] = max(work.scale[0], size, floor if lost < floor else 0.0)
    acceleration = mix(c.inertia[0], d, c.inertia[1], start[0], c.inertia[2], start[1])
    q = mix(c.end_displacement[0], d, c.end_displacement[1], start[0], c.end_displacement[2], start[1])
    v = mix(c.end_velocity[0], d, c.end_velocity[1], start[0], c.end_velocity[2], start[1])
    a = mix(c.end_acceleration[0], d, c.end_acceleration[1], start[0], c.end_acceleration[2], start[1])
    true = a
    if c.weight < 1.0:
        true = mix(1.0 / c.weight, acceleration, 1.0 - 1.0 / c.weight, ride.balanced, 0.0, d)
    for i in range(r):
        q[i] += work.q[i]
        ride.seen[0, i] = work.q[i] + d[i]
        ride.seen[1, i] = c.velocity[0] * d[i] + c.velocity[1] * start[0][i] + c.velocity[2] * start[1][i]
    ride.seen_hub[:] = end
    if c.evaluation != 1.0:
        set_inputs(arrays, ends, row, q, ride)
        place_hub(hub, arrays, q, ride.at)
        for k in range(6):
            end[TWIST + k] = ride.rigid[TWIST + k] + c.size * ride.rigid[RATES + k]
        ride_to(hub, arrays, ride.at, v, true, ride.rigid, c.size, ride.wrench, end)
    for kind in range(5):
        for i in range(r):
            ride.rows[kind, i] = rows[kind, i]
    enter_rigid(ride, end, v, c.size)
    enter_rows(ride, c.weight, c.weight * c.evaluation * c.size, c.size, work.q, q)
    for i in range(r):
        work.jerk[i] = (a[i] - work.a[i]) / c.size
        work.q[i], work.v[i], work.a[i], work.forces[i], ride.balanced[i] = q[i], v[i], a[i], forces[i], true[i]
    for k in range(31):
        ride.rigid[k] = end[k]
    return True


@jit
def march(
    arrays: Any, hub: HubArrays, inputs: HubInputs, ends: HubInputs, stages: tuple[StageNumbers, ...], work: Work,
    ride: HubWork, rows: Indices, stored: tuple[Array, Array, Array, Array], tolerance: float, trace: Array,
) -> int:  # fmt: skip
    """Steps of equal size; how many converged.

    ``inputs`` has a row for the evaluation instant of every stage of every step, ``ends`` one for their ends; the rest
    is as in `march_explicit`.
    """
    before, books, marks = np.empty(31), np.empty((2, 5, work.q.size)), np.empty(4)
    balanced, works = np.empty(work.q.size), np.empty(7)
    for n in range(rows.size):
        before[:], marks[:], balanced[:], works[:] = ride.rigid, ride.marks, ride.balanced, ride.work
        books[0], books[1] = ride.own, ride.now
        for place in range(len(stages)):
            if len(stages) > 1:
                work.passed[place] = work.state
            row = len(stages) * n + place
            if not implicit_step(arrays, hub, inputs, ends, row, stages[place], work, ride, tolerance):
                if place > 0:
                    work.state[:] = work.passed[0]
                    ride.rigid[:], ride.marks[:], ride.balanced[:], ride.work[:] = before, marks, balanced, works
                    ride.own[:], ride.now[:] = books[0], books[1]
                return n
        work.counts[0] += 1
        keep(work, ride, rows[n], stored, trace, n)
    return rows.size
