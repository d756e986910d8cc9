"""Compiled time stepping of a reduced model: forces, Newton iterations and steps without leaving machine code."""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_jit = numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"}, error_model="numpy")

# A tangent is renewed when an iteration leaves more than this part of the error.
_SLOW = 0.2
# As in the full model: the force scale never falls below this part of the largest one met.
_SCALE_FLOOR = 1e-3
_EPSILON = 2.220446049250313e-16


class Plant(NamedTuple):
    """Constant arrays of a reduced model; r coordinates, m monomials.

    Parameters
    ----------
    first, second
        Indices of the monomials, shape (m,).
    mass, damping, linear
        Shape (r, r).
    quadratic
        Second-degree force per monomial, shape (r, m); ``has_quadratic`` says whether there is any.
    cubic
        A quarter of the condensed fourth-degree coefficients, shape (m, m): ``s = cubic y`` and force ``Y' s``.
    viscous
        Damping of the companions, shape (m, m): ``s += viscous dy/dt``.
    turning
        ``M(Z)`` of the coordinates by (row, column) of Z, shape (3, 3, r, r).
    turning_companions
        The same between companions (per monomial) and coordinates, shape (3, 3, m, r).
    """

    first: Indices
    second: Indices
    mass: Array
    damping: Array
    linear: Array
    quadratic: Array
    has_quadratic: bool
    cubic: Array
    viscous: Array
    turning: Array
    turning_companions: Array


class Frame(NamedTuple):
    """Terms of the moving frame at a row of instants; arrays with one row hold for all.

    Parameters
    ----------
    velocity, displacement
        Matrices Z of G and K_T, shape (n, 3, 3).
    load
        Inertial load less inputs, shape (n, r).
    stress
        Part of ``s`` that the load on the companions makes, shape (n, m).
    turns
        Whether any Z is not zero.
    """

    velocity: Array
    displacement: Array
    load: Array
    stress: Array
    turns: bool


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
    """Vectors that survive from step to step.

    Parameters
    ----------
    q, v, a, jerk, forces
        State at the last instant; ``forces`` are all but inertia.
    inverse
        Inverse of an effective stiffness, shape (r, r).
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
    numbers: Array
    counts: Indices


@_jit
def internal_force(plant: Plant, q: Array, s: Array, force: Array) -> float:
    """Fill ``force`` with ``K q + Q y + Y' s``, s extended by ``cubic y``; return the strain energy without given s."""
    r, m = q.size, plant.first.size
    y = np.empty(m)
    for k in range(m):
        y[k] = q[plant.first[k]] * q[plant.second[k]]
    energy = 0.0
    for i in range(r):
        total = 0.0
        for j in range(r):
            total += plant.linear[i, j] * q[j]
        force[i] = total
        energy += 0.5 * total * q[i]
    if plant.has_quadratic:
        for i in range(r):
            total = 0.0
            for k in range(m):
                total += plant.quadratic[i, k] * y[k]
            force[i] += total
            energy += total * q[i] / 3.0
    for k in range(m):
        total = 0.0
        for l in range(m):
            total += plant.cubic[k, l] * y[l]
        energy += 0.5 * total * y[k]
        stress = s[k] + total
        i, j = plant.first[k], plant.second[k]
        force[i] += stress * q[j]
        force[j] += stress * q[i]
    return energy


@_jit
def _frame_matrix(weight: Array, parts: Array, result: Array) -> None:
    """Sum over a, b of ``weight[a, b] parts[a, b]``."""
    result.fill(0.0)
    for a in range(3):
        for b in range(3):
            if weight[a, b] != 0.0:
                for i in range(result.shape[0]):
                    for j in range(result.shape[1]):
                        result[i, j] += weight[a, b] * parts[a, b, i, j]


@_jit
def add_frame_forces(plant: Plant, frame: Frame, row: int, q: Array, v: Array, s: Array, force: Array) -> None:
    """Add to ``force`` damping, gyroscopic, K_T and load, and to ``s`` what the companions feel of them."""
    r, m = q.size, plant.first.size
    rate = np.empty(m)
    for k in range(m):
        i, j = plant.first[k], plant.second[k]
        rate[k] = q[i] * v[j] + v[i] * q[j]
        s[k] += frame.stress[row % frame.stress.shape[0], k]
    for k in range(m):
        total = 0.0
        for l in range(m):
            total += plant.viscous[k, l] * rate[l]
        s[k] += total
    for i in range(r):
        total = frame.load[row % frame.load.shape[0], i]
        for j in range(r):
            total += plant.damping[i, j] * v[j]
        force[i] += total
    if frame.turns:
        at = row % frame.velocity.shape[0]
        _add_turning(plant, frame.velocity[at], q, v, v, rate, s, force)
        y = np.empty(m)
        for k in range(m):
            y[k] = q[plant.first[k]] * q[plant.second[k]]
        _add_turning(plant, frame.displacement[at], q, v, q, y, s, force)


@_jit
def _add_turning(
    plant: Plant, weight: Array, q: Array, v: Array, moved: Array, followed: Array, s: Array, force: Array
) -> None:
    """Add ``M(Z) moved`` on the coordinates, and the same between coordinates and companions, both ways."""
    r, m = q.size, plant.first.size
    for a in range(3):
        for b in range(3):
            z = weight[a, b]
            if z == 0.0:
                continue
            for i in range(r):
                for j in range(r):
                    force[i] += z * plant.turning[a, b, i, j] * moved[j]
            for k in range(m):
                for j in range(r):
                    s[k] += z * plant.turning_companions[a, b, k, j] * moved[j]
                    # M_ap(Z) = M_pa(Z')'
                    force[j] += z * plant.turning_companions[b, a, k, j] * followed[k]


@_jit
def total_force(plant: Plant, frame: Frame, row: int, q: Array, v: Array, force: Array) -> float:
    """Fill ``force`` with all forces but inertia; return the norm of the internal one."""
    s, own, other = np.zeros(plant.first.size), np.empty(q.size), np.zeros(q.size)
    add_frame_forces(plant, frame, row, q, v, s, other)
    internal_force(plant, q, s, own)
    norm = 0.0
    for i in range(q.size):
        norm += own[i] * own[i]
        force[i] = own[i] + other[i]
    return np.sqrt(norm)


@_jit
def _average_force(
    plant: Plant, frame: Frame, row: int, q: Array, d: Array, reach: float, v: Array, force: Array
) -> float:
    """As `total_force`, with the internal force averaged along the way from q to q + d / reach.

    Two Gauss points are exact for a force of third degree, so its work is the change of the energy [Quispel & McLaren
    2008, average vector field].
    """
    s, other, own = np.zeros(plant.first.size), np.zeros(q.size), np.empty(q.size)
    add_frame_forces(plant, frame, row, q + d, v, s, other)
    mean, norm = np.zeros(q.size), 0.0
    for side in (-1.0, 1.0):
        share = (0.5 + side * 0.5 / np.sqrt(3.0)) / reach
        internal_force(plant, q + share * d, s, own)
        mean += 0.5 * own
    for i in range(q.size):
        norm += mean[i] * mean[i]
        force[i] = mean[i] + other[i]
    return np.sqrt(norm)


@_jit
def tangent(plant: Plant, q: Array, s: Array) -> Array:
    """Derivative of the internal force at q under given ``s``, shape (r, r)."""
    r, m = q.size, plant.first.size
    slope = np.zeros((m, r))
    for k in range(m):
        slope[k, plant.first[k]] += q[plant.second[k]]
        slope[k, plant.second[k]] += q[plant.first[k]]
    y = np.empty(m)
    for k in range(m):
        y[k] = q[plant.first[k]] * q[plant.second[k]]
    stress = s + plant.cubic @ y
    result = plant.linear + slope.T @ (plant.cubic @ slope)
    if plant.has_quadratic:
        result += plant.quadratic @ slope
    for k in range(m):
        result[plant.first[k], plant.second[k]] += stress[k]
        result[plant.second[k], plant.first[k]] += stress[k]
    return result


@_jit
def _renew(plant: Plant, frame: Frame, row: int, c: Coefficients, q: Array, v: Array, work: Work) -> bool:
    """Invert the effective stiffness at (q, v); whether that was possible."""
    r, m = q.size, plant.first.size
    s, force = np.zeros(m), np.zeros(r)
    add_frame_forces(plant, frame, row, q, v, s, force)
    matrix = c.inertia[0] * plant.mass + c.weight * (tangent(plant, q, s) + c.velocity[0] * plant.damping)
    slope = np.zeros((m, r))
    for k in range(m):
        slope[k, plant.first[k]] += q[plant.second[k]]
        slope[k, plant.second[k]] += q[plant.first[k]]
    matrix += c.weight * c.velocity[0] * (slope.T @ (plant.viscous @ slope))
    if frame.turns:
        at, part = row % frame.velocity.shape[0], np.empty((r, r))
        _frame_matrix(frame.velocity[at], plant.turning, part)
        matrix += c.weight * c.velocity[0] * part
        _frame_matrix(frame.displacement[at], plant.turning, part)
        matrix += c.weight * part
    work.counts[2] += 1
    if not np.all(np.isfinite(matrix)):
        return False
    work.inverse[:] = np.linalg.inv(matrix)
    work.numbers[1] = c.size
    return True


@_jit
def _residual(
    plant: Plant,
    frame: Frame,
    row: int,
    c: Coefficients,
    work: Work,
    d: Array,
    known: Array,
    forces: Array,
    result: Array,
) -> tuple[float, float]:
    """Fill residual and forces at the evaluation instant; return norms of residual and weighed internal force."""
    r = d.size
    velocity = np.empty(r)
    for i in range(r):
        velocity[i] = c.velocity[0] * d[i] + c.velocity[1] * work.v[i] + c.velocity[2] * work.a[i]
    if c.average:
        norm = _average_force(plant, frame, row, work.q, d, c.evaluation, velocity, forces)
    else:
        norm = total_force(plant, frame, row, work.q + d, velocity, forces)
    work.counts[3] += 1
    square = 0.0
    for i in range(r):
        total = known[i] + c.weight * forces[i]
        for j in range(r):
            total += c.inertia[0] * plant.mass[i, j] * d[j]
        result[i] = total
        square += total * total
    return np.sqrt(square), c.weight * norm


@_jit
def step(plant: Plant, frame: Frame, row: int, c: Coefficients, work: Work, tolerance: float, most: int) -> bool:
    """One step; ``work`` holds the new state if it converged and the old one if not."""
    r = work.q.size
    known, load = np.zeros(r), 0.0
    for i in range(r):
        for j in range(r):
            known[i] += plant.mass[i, j] * (c.inertia[1] * work.v[j] + c.inertia[2] * work.a[j])
        known[i] += (1.0 - c.weight) * work.forces[i]
        load += frame.load[row % frame.load.shape[0], i] ** 2
    load = c.weight * np.sqrt(load)
    reach = c.evaluation * c.size
    d = reach * work.v + 0.5 * reach * reach * work.a + (work.numbers[2] * reach**3 / 6.0) * work.jerk
    lost = 100.0 * _EPSILON / tolerance * np.sqrt(np.sum(known * known))
    forces, residual, trial, trial_forces = np.empty(r), np.empty(r), np.empty(r), np.empty(r)
    norm, size = _residual(plant, frame, row, c, work, d, known, forces, residual)
    scale = max(size, load, lost, _SCALE_FLOOR * work.numbers[0])
    fresh, count = False, 0
    while not norm <= tolerance * scale:
        count += 1
        if count > most or not np.isfinite(norm):
            return False
        if work.numbers[1] != c.size:
            velocity = c.velocity[0] * d + c.velocity[1] * work.v + c.velocity[2] * work.a
            if not _renew(plant, frame, row, c, work.q + d, velocity, work):
                return False
            fresh = True
        move = -(work.inverse @ residual)
        work.counts[1] += 1
        fraction = 1.0
        while True:
            after, size = _residual(plant, frame, row, c, work, d + fraction * move, known, trial_forces, trial)
            if after < norm or not fresh or fraction < 1e-3 or after <= tolerance * scale:
                break
            fraction *= 0.5
        slow = not after <= _SLOW * norm
        if not after < norm and not fresh and not after <= tolerance * scale:
            work.numbers[1] = 0.0
            continue
        d += fraction * move
        residual[:], forces[:], norm = trial, trial_forces, after
        scale = max(size, load, lost, _SCALE_FLOOR * work.numbers[0])
        fresh = False
        if slow:
            work.numbers[1] = 0.0
    work.numbers[0] = max(work.numbers[0], size, load)
    for i in range(r):
        q, v, a = work.q[i], work.v[i], work.a[i]
        work.q[i] = q + c.end_displacement[0] * d[i] + c.end_displacement[1] * v + c.end_displacement[2] * a
        work.v[i] = c.end_velocity[0] * d[i] + c.end_velocity[1] * v + c.end_velocity[2] * a
        work.a[i] = c.end_acceleration[0] * d[i] + c.end_acceleration[1] * v + c.end_acceleration[2] * a
        work.jerk[i] = (work.a[i] - a) / c.size
        work.forces[i] = forces[i]
    work.numbers[2] = 1.0
    work.counts[0] += 1
    return True


@_jit
def march(
    plant: Plant,
    frame: Frame,
    c: Coefficients,
    work: Work,
    rows: Indices,
    stored: tuple[Array, Array],
    tolerance: float,
    most: int,
) -> int:
    """Steps of equal size; state is stored in ``rows[n]`` (-1: not). Returns the number of steps that converged."""
    for n in range(rows.size):
        if not step(plant, frame, n, c, work, tolerance, most):
            return n
        if rows[n] >= 0:
            stored[0][rows[n]], stored[1][rows[n]] = work.q, work.v
    return rows.size


@_jit
def energies(plant: Plant, q: Array, v: Array) -> Array:
    """Kinetic and strain energy [J] of rows of states (n, r), shape (n, 2)."""
    result, force, none = np.empty((len(q), 2)), np.empty(q.shape[1]), np.zeros(plant.first.size)
    for n in range(len(q)):
        kinetic = 0.0
        for i in range(q.shape[1]):
            for j in range(q.shape[1]):
                kinetic += 0.5 * v[n, i] * plant.mass[i, j] * v[n, j]
        result[n, 0], result[n, 1] = kinetic, internal_force(plant, q[n], none, force)
    return result


def rows_from(frame: Frame, first: int) -> Frame:
    """Frame terms from one instant on; those that hold for all stay."""
    parts = [part if len(part) == 1 else part[first:] for part in frame[:4]]
    return Frame(*parts, frame.turns)


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
