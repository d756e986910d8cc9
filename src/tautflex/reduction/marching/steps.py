"""Compiled time stepping of a reduced model: Newton iterations and steps without leaving machine code."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex.numeric import jit
from tautflex.reduction.marching.dispatch import average_force, internal_force, tangent
from tautflex.reduction.polynomial.forces import Frame, Plant, derivative_forces, frame_matrices, slopes

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# A tangent is renewed when an iteration leaves more than this part of the error.
_SLOW = 0.2
# As in the full model: the force scale never falls below this part of the largest one met.
_SCALE_FLOOR = 1e-3
_EPSILON = 2.220446049250313e-16
_MOST_ITERATIONS = 40
# Steps between two looks at the stability of an explicit method, and the part of its limit that is used.
_CHECK_INTERVAL, _STABLE_SHARE = 32, 0.8


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


# Loops in place of array expressions: those make the compiler generate shape checks and error texts, half of its time.
@jit
def _mix(a: float, x: Array, b: float, y: Array, c: float, z: Array) -> Array:
    """``a x + b y + c z``."""
    result = np.empty(x.size)
    for i in range(x.size):
        result[i] = a * x[i] + b * y[i] + c * z[i]
    return result


@jit
def _add_times(factor: float, matrix: Array, vector: Array, result: Array) -> None:
    """Add ``factor * matrix @ vector`` to ``result``."""
    for i in range(result.size):
        total = 0.0
        for j in range(vector.size):
            total += matrix[i, j] * vector[j]
        result[i] += factor * total


@jit
def _dot(x: Array, y: Array) -> float:
    total = 0.0
    for i in range(x.size):
        total += x[i] * y[i]
    return total


@jit
def _invert(matrix: Array, size: float, work: Work) -> bool:
    """Keep the inverse of a matrix for steps of a size; whether that was possible."""
    work.counts[2] += 1
    if not np.isfinite(matrix.sum()):
        return False
    inverse = np.linalg.inv(matrix)
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            work.inverse[i, j] = inverse[i, j]
    work.numbers[1] = size
    return True


@jit
def _renew(plant: Plant, c: Coefficients, q: Array, given: Array, work: Work) -> bool:
    """Invert the effective stiffness at q; whether that was possible."""
    matrix = tangent(plant, q, given)
    moved = plant.viscous @ slopes(plant, q)
    damping = moved.T @ moved
    for i in range(q.size):
        for j in range(q.size):
            rate = work.on_velocity[i, j] + damping[i, j]
            stiffness = matrix[i, j] + work.on_displacement[i, j] + c.velocity[0] * rate
            matrix[i, j] = c.inertia[0] * plant.mass[i, j] + c.weight * stiffness
    return _invert(matrix, c.size, work)


@jit
def _residual(
    plant: Plant, c: Coefficients, work: Work, d: Array, known: Array, given: Array, forces: Array, result: Array
) -> tuple[float, float]:
    """Fill residual and the part of the forces that depends on d; return norms of residual and internal force."""
    r = d.size
    place = _mix(1.0, work.q, 1.0, d, 0.0, d)
    velocity = _mix(c.velocity[0], d, c.velocity[1], work.v, c.velocity[2], work.a)
    if c.average:
        average_force(plant, work.q, _mix(1.0, work.q, 1.0 / c.evaluation, d, 0.0, d), velocity, given, forces)
    else:
        internal_force(plant, place, velocity, given, forces)
    work.counts[3] += 1
    inside = _dot(forces, forces)
    _add_times(c.velocity[0], work.on_velocity, d, forces)
    _add_times(1.0, work.on_displacement, place, forces)
    for i in range(r):
        result[i] = known[i] + c.weight * forces[i]
    _add_times(c.inertia[0], plant.mass, d, result)
    return np.sqrt(_dot(result, result)), c.weight * np.sqrt(inside)


@jit
def implicit_step(plant: Plant, frame: Frame, row: int, c: Coefficients, work: Work, tolerance: float) -> bool:
    """One step; ``work`` holds the new state if it converged and the old one if not."""
    r = work.q.size
    reach = c.evaluation * c.size
    d = _mix(reach, work.v, 0.5 * reach * reach, work.a, work.numbers[2] * reach**3 / 6.0, work.jerk)
    given, constant, known = np.empty(plant.first.size), np.empty(r), np.zeros(r)
    speed = _mix(c.velocity[1], work.v, c.velocity[2], work.a, 0.0, work.a)
    place, predicted = _mix(1.0, work.q, 1.0, d, 0.0, d), _mix(1.0, speed, c.velocity[0], d, 0.0, d)
    derivative_forces(plant, frame, row, place, predicted, given, constant)
    frame_matrices(plant, frame, row, work.on_velocity, work.on_displacement)
    load = frame.load[row % frame.load.shape[0]]
    _add_times(1.0, work.on_velocity, speed, constant)
    _add_times(1.0, plant.mass, _mix(c.inertia[1], work.v, c.inertia[2], work.a, 0.0, work.a), known)
    for i in range(r):
        constant[i] += load[i]
        known[i] += c.weight * constant[i] + (1.0 - c.weight) * work.forces[i]
    lost = 100.0 * _EPSILON / tolerance * np.sqrt(_dot(known, known))
    floor = max(c.weight * np.sqrt(_dot(load, load)), lost, _SCALE_FLOOR * work.numbers[0])
    forces, residual, trial, trial_forces = np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    norm, size = _residual(plant, c, work, d, known, given, forces, residual)
    fresh, count = False, 0
    while not norm <= tolerance * max(size, floor):
        count += 1
        if count > _MOST_ITERATIONS or not np.isfinite(norm):
            return False
        if work.numbers[1] != c.size:
            if not _renew(plant, c, _mix(1.0, work.q, 1.0, d, 0.0, d), given, work):
                return False
            fresh = True
        move = np.zeros(r)
        _add_times(-1.0, work.inverse, residual, move)
        work.counts[1] += 1
        fraction = 1.0
        while True:
            moved = _mix(1.0, d, fraction, move, 0.0, d)
            after, after_size = _residual(plant, c, work, moved, known, given, trial_forces, trial)
            done = after <= tolerance * max(after_size, floor)
            if after < norm or done or not fresh or fraction < 1e-3:
                break
            fraction *= 0.5
        if not (after < norm or done or fresh):
            work.numbers[1] = 0.0
            continue
        if not (done or after <= _SLOW * norm):
            work.numbers[1] = 0.0
        d, norm, size = moved, after, after_size
        residual, trial = trial, residual
        forces, trial_forces = trial_forces, forces
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
    r = work.q.size
    if work.numbers[1] != size or frame.turns:
        frame_matrices(plant, frame, row, work.on_velocity, work.on_displacement)
        matrix = np.empty((r, r))
        for i in range(r):
            for j in range(r):
                matrix[i, j] = plant.mass[i, j] + 0.5 * size * work.on_velocity[i, j]
        if not _invert(matrix, 0.0 if frame.turns else size, work):
            return False
    half = _mix(1.0, work.v, 0.5 * size, work.a, 0.0, work.a)
    q = _mix(1.0, work.q, size, half, 0.0, half)
    given, total, internal, inertia = np.empty(plant.first.size), np.empty(r), np.empty(r), np.zeros(r)
    predicted = _mix(1.0, half, 0.5 * size, work.a, 0.0, half)
    derivative_forces(plant, frame, row, q, predicted, given, total)
    internal_force(plant, q, predicted, given, internal)
    work.counts[3] += 1
    # Stiffness that this very step has felt, against what central differences can follow.
    _add_times(1.0, plant.mass, half, inertia)
    felt, limit = size * (_dot(half, internal) - _dot(half, work.forces)), 4.0 * _dot(half, inertia)
    if not felt <= limit * (1.0 + 1e-9) + 1e-300:
        return False
    load = frame.load[row % frame.load.shape[0]]
    for i in range(r):
        total[i] += internal[i] + load[i]
    _add_times(1.0, work.on_velocity, half, total)
    if frame.turns:
        _add_times(1.0, work.on_displacement, q, total)
    a = np.zeros(r)
    _add_times(-1.0, work.inverse, total, a)
    for i in range(r):
        work.q[i], work.v[i], work.a[i], work.forces[i] = q[i], half[i] + 0.5 * size * a[i], a[i], internal[i]
    work.counts[0] += 1
    return True


@jit
def _stable(plant: Plant, frame: Frame, row: int, size: float, work: Work) -> bool:
    """Whether central differences follow the stiffness, and the lagged damping, at the present state.

    Coordinates are mass-normalised, so eigenvalues of the tangent are squared frequencies.
    """
    given, other = np.empty(plant.first.size), np.empty(work.q.size)
    derivative_forces(plant, frame, row, work.q, work.v, given, other)
    stiffest = np.linalg.eigvalsh(tangent(plant, work.q, given))[-1]
    moved = plant.viscous @ slopes(plant, work.q)
    lagged = 0.0
    for i in range(moved.shape[0]):
        for j in range(moved.shape[1]):
            lagged += moved[i, j] * moved[i, j]
    return size * size * stiffest <= _STABLE_SHARE * 4.0 and size * lagged <= _STABLE_SHARE


@jit
def march(
    plant: Plant,
    frame: Frame,
    c: Coefficients,
    work: Work,
    rows: Indices,
    stored: tuple[Array, Array],
    tolerance: float,
) -> int:
    """Steps of equal size; state is stored in ``rows[n]`` (-1: not). Returns the number of steps that converged."""
    for n in range(rows.size):
        if not implicit_step(plant, frame, n, c, work, tolerance):
            return n
        _store(work, rows[n], stored)
    return rows.size


@jit
def march_explicit(
    plant: Plant,
    frame: Frame,
    c: Coefficients,
    work: Work,
    rows: Indices,
    stored: tuple[Array, Array],
    tolerance: float,
) -> int:
    """As `march`, by central differences."""
    for n in range(rows.size):
        if n % _CHECK_INTERVAL == 0 and not _stable(plant, frame, n, c.size, work):
            return n
        if not explicit_step(plant, frame, n, c.size, work):
            return n
        _store(work, rows[n], stored)
    return rows.size


@jit
def _store(work: Work, row: int, stored: tuple[Array, Array]) -> None:
    if row >= 0:
        for i in range(work.q.size):
            stored[0][row, i], stored[1][row, i] = work.q[i], work.v[i]
