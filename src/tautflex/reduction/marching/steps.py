"""Compiled time stepping of a reduced model: Newton iterations and steps without leaving machine code."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.dispatch import average_force, internal_force, tangent
from tautflex.reduction.marching.work import LOOKED, StageNumbers, Work
from tautflex.reduction.polynomial.forces import (
    FrameTerms,
    ReducedArrays,
    add_times,
    derivative_forces,
    dot,
    frame_matrices,
    slopes,
)

# A tangent is renewed when an iteration leaves more than this part of the error.
SLOW = 0.2
# As in the full model: the force scale never falls below this part of the largest one met.
SCALE_FLOOR = 1e-3
_EPSILON = 2.220446049250313e-16
MOST_ITERATIONS = 40
# Steps between two looks at the stability of an explicit method, and the part of its limit that is used.
CHECK_INTERVAL, STABLE_SHARE = 32, 0.8


@jit
def mix(a: float, x: Array, b: float, y: Array, c: float, z: Array) -> Array:
    """``a x + b y + c z``."""
    result = np.empty(x.size)
    for i in range(x.size):
        result[i] = a * x[i] + b * y[i] + c * z[i]
    return result


@jit
def invert(matrix: Array, tangent: int, size: float, work: Work) -> bool:
    """Keep the inverse of a numbered matrix for steps of a size; whether that was possible."""
    work.counts[2] += 1
    if not np.isfinite(matrix.sum()):
        return False
    inverse = np.linalg.inv(matrix)
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            work.inverse[tangent, i, j] = inverse[i, j]
    work.sizes[tangent] = size
    return True


@jit
def lagging(arrays: ReducedArrays, q: Array) -> Array:
    """Damping matrix of the static derivatives at q, shape (r, r)."""
    moved = arrays.viscous @ slopes(arrays, q)
    return moved.T @ moved


@jit
def _renew(arrays: ReducedArrays, c: StageNumbers, q: Array, given: Array, work: Work) -> bool:
    """Invert the effective stiffness at q; whether that was possible."""
    matrix = tangent(arrays, q, given)
    damping = lagging(arrays, q)
    for i in range(q.size):
        for j in range(q.size):
            rate = work.on_velocity[i, j] + damping[i, j]
            stiffness = matrix[i, j] + work.on_displacement[i, j] + c.velocity[0] * rate
            matrix[i, j] = c.inertia[0] * arrays.mass[i, j] + c.weight * stiffness
    return invert(matrix, c.tangent, c.step, work)


@jit
def recall(c: StageNumbers, work: Work) -> tuple[Array, Array]:
    """What a stage takes for velocity and acceleration at its start, see `Stage`."""
    v, a = np.zeros(work.q.size), np.zeros(work.q.size)
    for n in range(c.recalled.shape[0]):
        on_v, on_a, state = c.recalled[n, 0], c.recalled[n, 1], work.passed[n]
        for i in range(v.size):
            back, speed, change = state[0, i] - work.q[i], state[1, i], state[2, i]
            v[i] += on_v[0] * back + on_v[1] * speed + on_v[2] * change
            a[i] += on_a[0] * back + on_a[1] * speed + on_a[2] * change
    return v, a


@jit
def _residual(
    arrays: ReducedArrays, c: StageNumbers, work: Work, start: tuple[Array, Array], d: Array, known: Array,
    given: Array, forces: Array, parts: Array, result: Array,
) -> tuple[float, float]:  # fmt: skip
    """Fill residual and the part of the forces that depends on d; return norms of residual and internal force.

    ``parts`` gets the internal force, and the part of it that is not elastic, shape (2 r,).
    """
    r = d.size
    place = mix(1.0, work.q, 1.0, d, 0.0, d)
    velocity = mix(c.velocity[0], d, c.velocity[1], start[0], c.velocity[2], start[1])
    if c.average:
        average_force(arrays, work.q, mix(1.0, work.q, 1.0 / c.evaluation, d, 0.0, d), velocity, given, parts)
    else:
        internal_force(arrays, place, velocity, given, parts)
    for i in range(r):
        forces[i] = parts[i]
    work.counts[3] += 1
    inside = dot(forces, forces)
    add_times(c.velocity[0], work.on_velocity, d, forces)
    add_times(1.0, work.on_displacement, place, forces)
    for i in range(r):
        result[i] = known[i] + c.weight * forces[i]
    add_times(c.inertia[0], arrays.mass, d, result)
    return np.sqrt(dot(result, result)), c.weight * np.sqrt(inside)


@jit
def implicit_step(
    arrays: ReducedArrays, frame: FrameTerms, row: int, c: StageNumbers, work: Work, tolerance: float, trace: Array
) -> bool:
    """One stage; ``work`` holds the new state if it converged and the old one if not, ``trace`` what `_note` says."""
    r = work.q.size
    start = work.v, work.a
    if c.recalled.shape[0] > 0:
        start = recall(c, work)
    reach = c.evaluation * c.size
    d = mix(reach, work.v, 0.5 * reach * reach, work.a, reach**3 / 6.0, work.jerk)
    given, constant, known = np.empty(frame.stress.shape[1]), np.empty(r), np.zeros(r)
    speed = mix(c.velocity[1], start[0], c.velocity[2], start[1], 0.0, work.a)
    place, predicted = mix(1.0, work.q, 1.0, d, 0.0, d), mix(1.0, speed, c.velocity[0], d, 0.0, d)
    derivative_forces(arrays, frame, row, place, predicted, given, constant)
    frame_matrices(arrays, frame, row, work.on_velocity, work.on_displacement)
    load = frame.load[row % frame.load.shape[0]]
    add_times(1.0, work.on_velocity, speed, constant)
    add_times(1.0, arrays.mass, mix(c.inertia[1], start[0], c.inertia[2], start[1], 0.0, work.a), known)
    for i in range(r):
        constant[i] += load[i]
        known[i] += c.weight * constant[i] + (1.0 - c.weight) * work.forces[i]
    lost = 100.0 * _EPSILON / tolerance * np.sqrt(dot(known, known))
    floor = max(c.weight * np.sqrt(dot(load, load)), lost, SCALE_FLOOR * work.scale[0])
    forces, residual, trial, trial_forces = np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    parts, trial_parts = np.empty(2 * r), np.empty(2 * r)
    norm, size = _residual(arrays, c, work, start, d, known, given, forces, parts, residual)
    fresh, count = False, 0
    while not norm <= tolerance * max(size, floor):
        count += 1
        if count > MOST_ITERATIONS or not np.isfinite(norm):
            return False
        if work.sizes[c.tangent] != c.step:
            if not _renew(arrays, c, mix(1.0, work.q, 1.0, d, 0.0, d), given, work):
                return False
            fresh = True
        move = np.zeros(r)
        add_times(-1.0, work.inverse[c.tangent], residual, move)
        work.counts[1] += 1
        fraction = 1.0
        while True:
            moved = mix(1.0, d, fraction, move, 0.0, d)
            after, after_size = _residual(arrays, c, work, start, moved, known, given, trial_forces, trial_parts, trial)
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
        parts, trial_parts = trial_parts, parts
        fresh = False
    work.scale[0] = max(work.scale[0], size, floor if lost < floor else 0.0)
    acceleration = mix(c.inertia[0], d, c.inertia[1], start[0], c.inertia[2], start[1])
    velocity, place = mix(1.0, speed, c.velocity[0], d, 0.0, d), mix(1.0, work.q, 1.0, d, 0.0, d)
    for i in range(r):
        q, v, a, before = work.q[i], start[0][i], start[1][i], work.a[i]
        work.q[i] = q + c.end_displacement[0] * d[i] + c.end_displacement[1] * v + c.end_displacement[2] * a
        work.v[i] = c.end_velocity[0] * d[i] + c.end_velocity[1] * v + c.end_velocity[2] * a
        work.a[i] = c.end_acceleration[0] * d[i] + c.end_acceleration[1] * v + c.end_acceleration[2] * a
        work.jerk[i] = (work.a[i] - before) / c.size
        work.forces[i] = forces[i] + constant[i]
    # Given stresses are linear in the place, so that their mean over the stage is that of its middle.
    _note(arrays, acceleration, velocity, place, parts, given, work, trace)
    return True


@jit
def _note(
    arrays: ReducedArrays, acceleration: Array, velocity: Array, place: Array, parts: Array, given: Array, work: Work,
    trace: Array,
) -> None:  # fmt: skip
    """Fill the rows of ``trace``, shape (8, r), after a stage.

    They are coordinates, velocities and accelerations at its end, inertia, elastic forces and those of damping of its
    equilibrium, all forces but inertia of it, and where it holds.
    """
    r = place.size
    for i in range(r):
        trace[0, i], trace[1, i], trace[2, i] = work.q[i], work.v[i], work.a[i]
        trace[3, i], trace[4, i], trace[5, i] = 0.0, parts[i] - parts[r + i], parts[r + i]
        trace[6, i], trace[7, i] = work.forces[i], place[i]
    add_times(1.0, arrays.mass, acceleration, trace[3])
    add_times(1.0, arrays.damping, velocity, trace[5])
    for k in range(arrays.first.size):
        i, j = arrays.first[k], arrays.second[k]
        trace[5, i] -= given[k] * place[j]
        trace[5, j] -= given[k] * place[i]


@jit
def anew_power(arrays: Any, now: Array, last: Array, q: Array, rate: Array) -> float:
    """Power of what the given stress has changed by since an explicit step, which is no stiffness.

    Infinite where that is not known: where stresses act in elements.
    """
    total = 0.0
    for k in range(now.size):
        change = now[k] - last[k]
        if change != 0.0:
            if arrays.first.size == 0:
                return np.inf
            i, j = arrays.first[k], arrays.second[k]
            total += change * (q[i] * rate[j] + rate[i] * q[j])
    return total


@jit
def _given_anew(arrays: ReducedArrays, frame: FrameTerms, row: int, q: Array, rate: Array) -> float:
    """`anew_power` since the step before; infinite where that is not known, at the first of several steps."""
    if frame.stress.shape[0] == 1:
        return 0.0
    return np.inf if row == 0 else anew_power(arrays, frame.stress[row], frame.stress[row - 1], q, rate)


@jit
def explicit_step(arrays: ReducedArrays, frame: FrameTerms, row: int, size: float, work: Work, trace: Array) -> bool:
    """One step of central differences, ``M a + (C + G) v + ... = 0`` at its end; False where it is not stable.

    Damping and gyroscopic force at the end are solved for, as in the full model; the static derivatives'
    damping is taken at the predicted velocity.
    """
    r = work.q.size
    if work.sizes[0] != size or frame.turns:
        frame_matrices(arrays, frame, row, work.on_velocity, work.on_displacement)
        matrix = np.empty((r, r))
        for i in range(r):
            for j in range(r):
                matrix[i, j] = arrays.mass[i, j] + 0.5 * size * work.on_velocity[i, j]
        if not invert(matrix, 0, 0.0 if frame.turns else size, work):
            return False
    half = mix(1.0, work.v, 0.5 * size, work.a, 0.0, work.a)
    q = mix(1.0, work.q, size, half, 0.0, half)
    given, total, parts, inertia = np.empty(frame.stress.shape[1]), np.empty(r), np.empty(2 * r), np.zeros(r)
    predicted = mix(1.0, half, 0.5 * size, work.a, 0.0, half)
    derivative_forces(arrays, frame, row, q, predicted, given, total)
    internal_force(arrays, q, predicted, given, parts)
    internal = parts[:r].copy()
    work.counts[3] += 1
    # Stiffness that this very step has felt, against what central differences can follow.
    add_times(1.0, arrays.mass, half, inertia)
    felt, limit = size * (dot(half, internal) - dot(half, work.forces)), 4.0 * dot(half, inertia)
    felt -= size * _given_anew(arrays, frame, row, q, half)
    if not felt <= limit * (1.0 + 1e-9) + 1e-300:
        return False
    load = frame.load[row % frame.load.shape[0]]
    for i in range(r):
        total[i] += internal[i] + load[i]
    add_times(1.0, work.on_velocity, half, total)
    if frame.turns:
        add_times(1.0, work.on_displacement, q, total)
    a = np.zeros(r)
    add_times(-1.0, work.inverse[0], total, a)
    for i in range(r):
        work.q[i], work.v[i], work.a[i], work.forces[i] = q[i], half[i] + 0.5 * size * a[i], a[i], internal[i]
    _note(arrays, a, work.v, q, parts, given, work, trace)
    for i in range(r):
        trace[6, i] = total[i]
    add_times(0.5 * size, work.on_velocity, a, trace[6])
    work.counts[0] += 1
    return True


@jit
def _stable(arrays: ReducedArrays, frame: FrameTerms, row: int, size: float, work: Work) -> bool:
    """Whether central differences follow the stiffness, and the lagged damping, at the present state.

    Coordinates are mass-normalised, so eigenvalues of the tangent are squared frequencies.
    """
    given, other = np.empty(frame.stress.shape[1]), np.empty(work.q.size)
    derivative_forces(arrays, frame, row, work.q, work.v, given, other)
    stiffest = np.linalg.eigvalsh(tangent(arrays, work.q, given))[-1]
    damping, lagged = lagging(arrays, work.q), 0.0
    for i in range(work.q.size):
        lagged += damping[i, i]
    return size * size * stiffest <= STABLE_SHARE * 4.0 and size * lagged <= STABLE_SHARE


@jit
def march(
    arrays: ReducedArrays,
    frame: FrameTerms,
    stages: tuple[StageNumbers, ...],
    work: Work,
    rows: Indices,
    stored: tuple[Array, Array],
    tolerance: float,
    trace: Array,
) -> int:
    """Steps of equal size; state is stored in ``rows[n]`` (-1: not). Returns the number of steps that converged.

    The frame has a row for every stage of every step, and so has ``trace``, see `_note`.
    """
    for n in range(rows.size):
        for place in range(len(stages)):
            if len(stages) > 1:
                _copy(work.state, work.passed[place])
            row = len(stages) * n + place
            if not implicit_step(arrays, frame, row, stages[place], work, tolerance, trace[row]):
                if place > 0:
                    _copy(work.passed[0], work.state)
                return n
        work.counts[0] += 1
        _store(work, rows[n], stored)
    return rows.size


@jit
def _copy(state: Array, result: Array) -> None:
    for k in range(state.shape[0]):
        for i in range(state.shape[1]):
            result[k, i] = state[k, i]


@jit
def march_explicit(
    arrays: ReducedArrays,
    frame: FrameTerms,
    stages: tuple[StageNumbers, ...],
    work: Work,
    rows: Indices,
    stored: tuple[Array, Array],
    tolerance: float,
    trace: Array,
) -> int:
    """As `march`, by central differences."""
    c = stages[0]
    for n in range(rows.size):
        stable = work.counts[LOOKED] % CHECK_INTERVAL != 0 or _stable(arrays, frame, n, c.size, work)
        if not (stable and explicit_step(arrays, frame, n, c.size, work, trace[n])):
            return n
        work.counts[LOOKED] += 1
        _store(work, rows[n], stored)
    return rows.size


@jit
def _store(work: Work, row: int, stored: tuple[Array, Array]) -> None:
    if row >= 0:
        for i in range(work.q.size):
            stored[0][row, i], stored[1][row, i] = work.q[i], work.v[i]
