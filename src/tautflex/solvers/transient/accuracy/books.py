r"""Books of energy: what the forces of every step's own equilibrium do on the displacement, by kind; compiled.

A stage solves ``M a_s + w P_e + (1 - w) P_n = 0``, whose forces P are internal, of damping, of the moving frame and of
loads. Times the displacement of the stage this is the energy that each kind takes up, and the sum over all kinds is
what Newton's method left. The equilibrium belongs to the instant ``w e`` of the stage, e its evaluation instant; what
the forces do over the stage is taken at its middle, from this equilibrium and the one before it, which is of second
order for all kinds: the trapezoidal rule for Newmark's method, the mid-point rule for the energy-conserving one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.products import add_pair_products
from tautflex.numeric import Array, Indices, Places, jit

NONE = np.zeros((0, 0))
INERTIA, INTERNAL, DAMPING, FRAME, LOAD, STRESS, RIGID = range(7)


class Books(NamedTuple):
    """Work done since the start of a run, and what the next step needs to go on.

    Parameters
    ----------
    work
        Of inertia, internal forces, damping, moving frame and loads, all on the left-hand side, on the elastic
        displacement; of changes of tension and temperature; of the wrench of all loads on a free hub [J], shape (7,).
    own
        Forces of the last equilibrium by kind, shape (5, size); (0, 0) behind a jump.
    now
        The same at its evaluation instant alone, where it mixes two instants, else (0, 0).
    late
        Instant of that equilibrium after the end of the step [s].
    """

    work: Array
    own: Array = NONE
    now: Array = NONE
    late: float = 0.0


@jit
def write_books(
    start: Indices, column: Places, mass: Array, damped: bool, pairs: Any, weight: float, inertia: Array,
    velocity: Array, gyroscopic: Array, displacement: Array, internal: Array, reference: Array, frame: Array,
    load: Array, residual: Array, then: Array, x: Array, q: Array, v: Array, a: Array, end: Array,
    instants: tuple[float, float, float], before: Array, done: Array, own: Array, now: Array,
) -> Array:  # fmt: skip
    """Fill in the forces of a stage by kind, shape (5, size); return the work done since the start of the run.

    Damping is what the others leave of the residual: one walk through a matrix less.

    Parameters
    ----------
    start, column, mass, damped, pairs
        Mass in compressed rows, whether there is damping, parts of the `PairProducts` of the frame's forces.
    weight
        Of the forces at the evaluation instant, beside those at the start.
    inertia, velocity
        Factors of (x, v, a) in the inertia's acceleration and in the velocity, shape (3,).
    gyroscopic, displacement, frame, load
        Matrices Z of the frame's forces and the rest of them, and loads, at the evaluation instant.
    internal, reference, residual
        Internal force, what of it the reference carries, and all forces together.
    then
        Forces by kind that are weighed at the start, shape (5, size); else empty.
    x, q, v, a, end
        Increment to the evaluation instant, what it starts from, and the displacement at the end, shape (size,).
    instants
        Of the equilibrium and of the end after the start, and of the equilibrium before after that [s].
    before, done
        Forces of that by kind, (0, 0) behind a jump, and the work until the start.
    own, now
        Forces of this equilibrium and those at its evaluation instant alone, which are filled in if they differ.
    """
    size, other = x.size, 1.0 - weight
    acceleration, speed, place = np.empty(size), np.empty(size), np.empty(size)
    for i in range(size):
        acceleration[i] = inertia[0] * x[i] + inertia[1] * v[i] + inertia[2] * a[i]
        speed[i] = velocity[0] * x[i] + velocity[1] * v[i] + velocity[2] * a[i]
        place[i] = q[i] + x[i]
        own[INTERNAL, i], own[FRAME, i], own[LOAD, i] = internal[i] - reference[i], frame[i], -load[i]
    for i in range(size):
        total = 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            total += mass[k] * acceleration[column[k]]
        own[INERTIA, i] = total
    add_pair_products(pairs, gyroscopic, 1.0, speed, own[FRAME])
    add_pair_products(pairs, displacement, 1.0, place, own[FRAME])
    if then.size:
        for kind in (INERTIA, INTERNAL, FRAME, LOAD):
            for i in range(size):
                now[kind, i] = own[kind, i]
                if kind != INERTIA:
                    own[kind, i] = weight * own[kind, i] + other * then[kind, i]
    for i in range(size):
        rest = own[INERTIA, i] + own[INTERNAL, i] + own[FRAME, i] + own[LOAD, i]
        own[DAMPING, i] = residual[i] - rest if damped else 0.0
        if then.size:
            now[DAMPING, i] = (own[DAMPING, i] - other * then[DAMPING, i]) / weight
    middle, share, work = 0.5 * instants[1], 1.0, done.copy()
    if before.size:
        share = (middle - instants[2]) / (instants[0] - instants[2])
    for kind in range(5):
        last, first = 0.0, 0.0
        for i in range(size):
            last += own[kind, i] * (end[i] - q[i])
        if before.size:
            for i in range(size):
                first += before[kind, i] * (end[i] - q[i])
        work[kind] += share * last + (1.0 - share) * first
    return work
