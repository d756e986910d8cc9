"""Compiled parts of one implicit step: what is known before, the residual, and the state at the end."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.kernel import add_average_forces, add_forces
from tautflex.mechanics.products import add_low_rank, add_pair_products, add_two_pair_products, inner
from tautflex.numeric import Array, Indices, Places, jit
from tautflex.solvers.transient.accuracy.books import DAMPING, FRAME, INERTIA, write_books


@jit
def begin_step(
    start: Indices, column: Places, mass: Array, damping: Array, damped: bool, pairs: Any, coefficients: Array,
    gyroscopic: Array, displacement: Array, load: Array, diagonal: Array, q: Array, v: Array, a: Array,
) -> tuple[Array, Array, float, float, float]:  # fmt: skip
    """What a step does not have to compute again for every increment.

    ``coefficients`` holds the weight of the forces and the factors of v and a in the inertia's acceleration and of v, a
    and the increment in the velocity, shape (6,); ``gyroscopic`` and ``displacement`` are the matrices Z of the frame's
    forces ``M(Z) velocity`` and ``M(Z) q``; ``load`` stands on the left-hand side.

    Returns rows, shape (6, size): the forces that do not depend on the increment; what of them the moving frame adds
    beside the load; room for what it adds to the residual; inertia and damping among the first; and room for those of
    the increment together. Then the matrix Z of the third, ``M(Z) increment``, and the norms of the first, of the
    weighted load and of ``diagonal * q``.
    """
    size, rows = q.size, np.empty((6, q.size))
    weight, inertia_v, inertia_a, velocity_v, velocity_a, velocity_d = coefficients
    acceleration, velocity, known, stiff = np.empty(size), np.empty(size), np.empty(size), rows[2]
    # One result per loop: of more the compiler cannot tell that they do not overlap.
    for i in range(size):
        acceleration[i] = inertia_v * v[i] + inertia_a * a[i]
    for i in range(size):
        velocity[i] = weight * (velocity_v * v[i] + velocity_a * a[i])
    for i in range(size):
        known[i] = weight * load[i]
    for i in range(size):
        stiff[i] = diagonal[i] * q[i]
    load_norm, stiff_norm = np.sqrt(inner(known, known)), np.sqrt(inner(stiff, stiff))
    turned, whole, inertial, lossy = rows[1], rows[0], rows[3], rows[4]
    for i in range(size):
        first, second = 0.0, 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            first += mass[k] * acceleration[column[k]]
            second += damping[k] * velocity[column[k]]
        inertial[i], lossy[i] = first, second
    turned.fill(0.0)
    add_two_pair_products(pairs, gyroscopic, velocity, weight * displacement, q, turned)
    for i in range(size):
        whole[i] = known[i] + (inertial[i] + lossy[i]) + turned[i]
    # Gyroscopic and K_T forces are both M(Z) times something, so one product serves the increment.
    turning = weight * (velocity_d * gyroscopic + displacement)
    return rows, turning, np.sqrt(inner(whole, whole)), load_norm, stiff_norm


@jit
def assemble_residual(
    x: Array, force: Array, start: Indices, column: Places, linear: Array, pairs: Any, turning: Array, weight: float,
    reference: Array, rows: Array,
) -> tuple[Array, float, float, float]:  # fmt: skip
    """Residual of an increment from its internal forces; ``rows`` are those of `begin_step`, whose room is filled in.

    Returns it with its norm and those of the weighted internal forces above the reference and of the linear forces.
    """
    residual, known, turned, parts = np.empty(x.size), rows[0], rows[2], rows[5]
    for i in range(x.size):
        part = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            part += linear[k] * x[column[k]]
        parts[i] = part
    turned.fill(0.0)
    add_pair_products(pairs, turning, 1.0, x, turned)
    for i in range(x.size):
        residual[i] = weight * (force[i] - reference[i])
    internal = np.sqrt(inner(residual, residual))
    for i in range(x.size):
        residual[i] = residual[i] + parts[i] + known[i] + turned[i]
    return residual, np.sqrt(inner(residual, residual)), internal, np.sqrt(inner(parts, parts))


@jit
def step_residual(
    x: Array, q: Array, store: Any, stresses: Array, held: Array, start: Indices, column: Places, linear: Array,
    pairs: Any, turning: Array, weight: float, reference: Array, rows: Array, energies: bool, part: float,
) -> tuple[Array, Array, float, float, float, float]:  # fmt: skip
    """Internal force and residual of the increment ``x`` from ``q``, the norms of `assemble_residual`, strain energy.

    ``held`` is where moved unknowns are; ``energies`` tells whether stresses and energy are wanted, see `add_forces`;
    of the average stress of a stage ``part`` is the share of it that the increment is, and nothing else is known; 0: of
    the stress at the increment.
    """
    size, energy = x.size, 0.0
    extended, force = np.zeros(size + held.size + 1), np.zeros(size + held.size + 1)
    extended[size : size + held.size] = held
    if part != 0.0:
        before = extended.copy()
        for i in range(size):
            before[i], extended[i] = q[i], q[i] + x[i] / part
        add_average_forces(store, before, extended, force)
    else:
        for i in range(size):
            extended[i] = q[i] + x[i]
        energy = add_forces(store, extended, force, stresses, True, energies, False)
    residual, norm, internal, inertia = assemble_residual(
        x, force, start, column, linear, pairs, turning, weight, reference, rows
    )
    return force, residual, norm, internal, inertia, energy


@jit
def recalled(factors: Array, passed: Array) -> Array:
    """Velocity and acceleration that a stage takes at its start, shape (2, size), see `Stage`.

    ``factors`` are those of `Stage.factors`; ``passed`` holds displacement, velocity and acceleration of all states
    that the step has passed, the start of the stage last, shape (state, 3, size).
    """
    found, (count, _, size) = np.zeros((2, passed.shape[2])), passed.shape
    start = passed[count - 1]
    for k in range(2):
        for n in range(count):
            d, v, a = factors[k, n]
            for i in range(size):
                found[k, i] += d * (passed[n, 0, i] - start[0, i]) + v * passed[n, 1, i] + a * passed[n, 2, i]
    return found


@jit
def first_guess(reach: float, v: Array, a: Array, jerk: Array) -> Array:
    """Increment by Taylor's series; an empty ``jerk`` is none."""
    guess = np.empty(v.size)
    for i in range(v.size):
        guess[i] = reach * v[i] + 0.5 * reach * reach * a[i]
    third = reach * reach * reach / 6.0
    for i in range(jerk.size):
        guess[i] += third * jerk[i]
    return guess


@jit
def end_of_step(
    coefficients: Array, size: float, instant: float, late: float, start: Indices, column: Places, mass: Array,
    damped: bool, vectors: Array, strengths: Array, weight: float, rows: Array, internal: Array, reference: Array,
    frame: Array, load: Array, then: Array, before: Array, done: Array, d: Array, q: Array, v: Array, a: Array,
) -> tuple[Array, Array, float]:  # fmt: skip
    """State at the end of a step and its books, see `write_books`.

    ``coefficients`` holds the factors of (d, v, a) in displacement, velocity and acceleration at the end and in the
    inertia's acceleration and the velocity, shape (5, 3); ``damped`` tells whether there is damping in the matrix, and
    ``vectors`` with ``strengths`` have what is beside it; ``rows`` are those of `begin_step`, and ``frame`` is what the
    moving frame adds beside them.

    Returns displacement, velocity, acceleration and jerk, then the forces of the step by kind, and where these mix two
    instants those at the last one, shape (9 or 14, unknowns); the work since the start of the run; and the energy of
    the motion at the end, which shares a walk through the mass matrix.
    """
    end, moved = np.empty((14 if then.size else 9, d.size)), np.empty(d.size)
    own, inertia_d, factor, place, speed = end[4:9], coefficients[3, 0], 1.0 / weight, end[0], end[1]
    for row in range(3):
        share, target = coefficients[row], end[row]
        for i in range(d.size):
            target[i] = share[0] * d[i] + share[1] * v[i] + share[2] * a[i]
    jerk, pace, kinetic = end[3], end[2], 0.0
    for i in range(d.size):
        jerk[i] = (pace[i] - a[i]) / size
    for i in range(d.size):
        place[i] += q[i]
    inertial, lossy, framed = own[INERTIA], own[DAMPING], own[FRAME]
    for i in range(d.size):
        total, momentum = 0.0, 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += mass[k] * d[column[k]]
            momentum += mass[k] * speed[column[k]]
        moved[i] = inertia_d * total
        kinetic += speed[i] * momentum
    for i in range(d.size):
        inertial[i] = rows[3, i] + moved[i]
    lossy.fill(0.0)
    if damped:  # what the increment's linear forces are beside inertia
        for i in range(d.size):
            lossy[i] = factor * (rows[4, i] + rows[5, i] - moved[i])
    for i in range(d.size):
        framed[i] = frame[i] + factor * (rows[1, i] + rows[2, i])
    if vectors.shape[0]:
        share = coefficients[4]
        add_low_rank(vectors, strengths, 1.0, share[0] * d + share[1] * v + share[2] * a, lossy)
    instants = instant, size, late
    work = write_books(weight, internal, reference, load, then, q, place, instants, before, done, own, end[9:])
    return end, work, 0.5 * kinetic
