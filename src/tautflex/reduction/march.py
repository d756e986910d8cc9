"""Compiled time stepping of a reduced model: Newton iterations and steps without leaving machine code."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex.reduction.dispatch import average_force, internal_force, tangent
from tautflex.reduction.forces import Frame, Plant, companion_forces, frame_matrices, jit, slopes

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# A tangent is renewed when an iteration leaves more than this part of the error.
_SLOW = 0.2
# As in the full model: the force scale never falls below this part of the largest one met.
_SCALE_FLOOR = 1e-3
_EPSILON = 2.220446049250313e-16
_MOST_ITERATIONS = 40


class Coefficients(NamedTuple):
    """A `StepScheme` as plain numbers; triples multiply (increment, velocity, acceleration)."""

    evaluation: float
    weight: float
    inertia: tuple[float, float, float]
    velocity: tuple[float, float, float]
    end_displacement: tuple[float, float, float]
    end_velocity: tuple[float, float, float]
    end_acceleration: tuple[float, float, float]
    average: bool
    size: float


class Work(NamedTuple):
    """What survives from step to step.

    Parameters
    ----------
    q, v, a, jerk, forces
        State at the last instant; ``forces`` are all but inertia.
    inverse
        Inverse of an effective stiffness (or of an explicit method's effective mass), shape (r, r).
    on_velocity, on_displacement
        Matrices of the frame in this step, shape (r, r).
    numbers
        [largest scale so far, step size of ``inverse`` (0: none), 1 if ``jerk`` is known].
    counts
        [steps, iterations, factorizations, force evaluations].
    """

    q: Array
    v: Array
    a: Array
    jerk: Array
    forces: Array
    inverse: Array
    on_velocity: Array
    on_displacement: Array
    numbers: Array
    counts: Indices


def new_work(size: int) -> Work:
    """Zeros for ``size`` coordinates."""
    q, v, a, jerk, forces = (np.zeros(size) for _ in range(5))
    inverse, on_velocity, on_displacement = (np.zeros((size, size)) for _ in range(3))
    numbers, counts = np.zeros(3), np.zeros(4, dtype=np.int64)
    return Work(q, v, a, jerk, forces, inverse, on_velocity, on_displacement, numbers, counts)


def coefficients(scheme: Any, size: float) -> Coefficients:
    """Plain numbers of a step scheme."""

    def triple(c: Any) -> tuple[float, float, float]:
        return float(c.d), float(c.v), float(c.a)

    return Coefficients(
        float(scheme.evaluation),
        float(scheme.weight),
        triple(scheme.inertia),
        triple(scheme.velocity),
        triple(scheme.end_displacement),
        triple(scheme.end_velocity),
        triple(scheme.end_acceleration),
        bool(scheme.average_stress),
        float(size),
    )


# What an explicit step needs of a scheme: frame terms at its end, and its size.
_NOTHING = (0.0, 0.0, 0.0)
EXPLICIT = Coefficients(1.0, 1.0, _NOTHING, _NOTHING, _NOTHING, _NOTHING, _NOTHING, False, 0.0)


@jit
def _renew(plant: Plant, c: Coefficients, q: Array, given: Array, work: Work) -> bool:
    """Invert the effective stiffness at q; whether that was possible."""
    slope = slopes(plant, q)
    moved = plant.viscous @ slope
    matrix = c.inertia[0] * plant.mass + c.weight * c.velocity[0] * (work.on_velocity + moved.T @ moved)
    matrix += c.weight * (tangent(plant, q, given) + work.on_displacement)
    work.counts[2] += 1
    if not np.all(np.isfinite(matrix)):
        return False
    work.inverse[:] = np.linalg.inv(matrix)
    work.numbers[1] = c.size
    return True


@jit
def _residual(
    plant: Plant, c: Coefficients, work: Work, d: Array, known: Array, given: Array, forces: Array, result: Array
) -> tuple[float, float]:
    """Fill residual and the part of the forces that depends on d; return norms of residual and internal force."""
    r = d.size
    place = work.q + d
    velocity = c.velocity[0] * d + c.velocity[1] * work.v + c.velocity[2] * work.a
    if c.average:
        average_force(plant, work.q, work.q + d / c.evaluation, velocity, given, forces)
    else:
        internal_force(plant, place, velocity, given, forces)
    work.counts[3] += 1
    inside = 0.0
    for i in range(r):
        inside += forces[i] * forces[i]
    square = 0.0
    for i in range(r):
        inertia, other = 0.0, 0.0
        for j in range(r):
            inertia += plant.mass[i, j] * d[j]
            other += work.on_velocity[i, j] * d[j] * c.velocity[0] + work.on_displacement[i, j] * place[j]
        forces[i] += other
        total = known[i] + c.inertia[0] * inertia + c.weight * forces[i]
        result[i] = total
        square += total * total
    return np.sqrt(square), c.weight * np.sqrt(inside)


@jit
def implicit_step(plant: Plant, frame: Frame, row: int, c: Coefficients, work: Work, tolerance: float) -> bool:
    """One step; ``work`` holds the new state if it converged and the old one if not."""
    r = work.q.size
    reach = c.evaluation * c.size
    d = reach * work.v + 0.5 * reach * reach * work.a + (work.numbers[2] * reach**3 / 6.0) * work.jerk
    given, constant = np.empty(plant.first.size), np.empty(r)
    speed = c.velocity[1] * work.v + c.velocity[2] * work.a
    companion_forces(plant, frame, row, work.q + d, speed + c.velocity[0] * d, given, constant)
    frame_matrices(plant, frame, row, work.on_velocity, work.on_displacement)
    load = frame.load[row % frame.load.shape[0]]
    constant += load + work.on_velocity @ speed
    known = plant.mass @ (c.inertia[1] * work.v + c.inertia[2] * work.a)
    known += c.weight * constant + (1.0 - c.weight) * work.forces
    lost = 100.0 * _EPSILON / tolerance * np.sqrt(np.sum(known * known))
    floor = max(c.weight * np.sqrt(np.sum(load * load)), lost, _SCALE_FLOOR * work.numbers[0])
    forces, residual, trial, trial_forces = np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    norm, size = _residual(plant, c, work, d, known, given, forces, residual)
    fresh, count = False, 0
    while not norm <= tolerance * max(size, floor):
        count += 1
        if count > _MOST_ITERATIONS or not np.isfinite(norm):
            return False
        if work.numbers[1] != c.size:
            if not _renew(plant, c, work.q + d, given, work):
                return False
            fresh = True
        move = -(work.inverse @ residual)
        work.counts[1] += 1
        fraction = 1.0
        while True:
            after, after_size = _residual(plant, c, work, d + fraction * move, known, given, trial_forces, trial)
            done = after <= tolerance * max(after_size, floor)
            if after < norm or done or not fresh or fraction < 1e-3:
                break
            fraction *= 0.5
        if not (after < norm or done or fresh):
            work.numbers[1] = 0.0
            continue
        if not (done or after <= _SLOW * norm):
            work.numbers[1] = 0.0
        d += fraction * move
        residual[:], forces[:], norm, size = trial, trial_forces, after, after_size
        fresh = False
    work.numbers[0] = max(work.numbers[0], size, floor if lost < floor else 0.0)
    for i in range(r):
        q, v, a = work.q[i], work.v[i], work.a[i]
        work.q[i] = q + c.end_displacement[0] * d[i] + c.end_displacement[1] * v + c.end_displacement[2] * a
        work.v[i] = c.end_velocity[0] * d[i] + c.end_velocity[1] * v + c.end_velocity[2] * a
        work.a[i] = c.end_acceleration[0] * d[i] + c.end_acceleration[1] * v + c.end_acceleration[2] * a
        work.jerk[i] = (work.a[i] - a) / c.size
        work.forces[i] = forces[i] + constant[i]
    work.numbers[2] = 1.0
    work.counts[0] += 1
    return True


@jit
def explicit_step(plant: Plant, frame: Frame, row: int, size: float, work: Work) -> bool:
    """One step of central differences, ``M a + (C + G) v + ... = 0`` at its end; False where it is not stable.

    Damping and gyroscopic force at the end are solved for, as in the full model; the companions' damping is taken at
    the predicted velocity.
    """
    if work.numbers[1] != size or frame.turns:
        frame_matrices(plant, frame, row, work.on_velocity, work.on_displacement)
        work.inverse[:] = np.linalg.inv(plant.mass + 0.5 * size * work.on_velocity)
        work.numbers[1] = 0.0 if frame.turns else size
        work.counts[2] += 1
    half = work.v + 0.5 * size * work.a
    move = size * half
    q = work.q + move
    given, other, internal = np.empty(plant.first.size), np.empty(q.size), np.empty(q.size)
    predicted = half + 0.5 * size * work.a
    companion_forces(plant, frame, row, q, predicted, given, other)
    internal_force(plant, q, predicted, given, internal)
    work.counts[3] += 1
    # Stiffness that this very step has felt, against what central differences can follow.
    felt, limit = 0.0, 4.0 / size**2 * np.dot(move, plant.mass @ move)
    for i in range(q.size):
        felt += move[i] * (internal[i] - work.forces[i])
    if not felt <= limit * (1.0 + 1e-9) + 1e-300:
        return False
    total = internal + other + work.on_velocity @ half
    total += frame.load[row % frame.load.shape[0]]
    if frame.turns:
        total += work.on_displacement @ q
    a = -(work.inverse @ total)
    work.q[:], work.v[:], work.a[:] = q, half + 0.5 * size * a, a
    work.forces[:] = internal
    work.counts[0] += 1
    return True


@jit
def march(
    plant: Plant,
    frame: Frame,
    c: Coefficients,
    explicit: bool,
    work: Work,
    rows: Indices,
    stored: tuple[Array, Array],
    tolerance: float,
) -> int:
    """Steps of equal size; state is stored in ``rows[n]`` (-1: not). Returns the number of steps that converged."""
    for n in range(rows.size):
        if explicit:
            good = explicit_step(plant, frame, n, c.size, work)
        else:
            good = implicit_step(plant, frame, n, c, work, tolerance)
        if not good:
            return n
        if rows[n] >= 0:
            stored[0][rows[n]], stored[1][rows[n]] = work.q, work.v
    return rows.size
