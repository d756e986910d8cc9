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

from tautflex.mechanics.products import add_low_rank, add_pair_products
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
def forces_by_kind(
    start: Indices, column: Places, mass: Array, damping: Array, damped: bool, vectors: Array, coefficients: Array,
    pairs: Any, numbers: Array, gyroscopic: Array, displacement: Array, internal: Array, reference: Array,
    frame: Array, load: Array, x: Array, q: Array, v: Array, a: Array,
) -> Array:  # fmt: skip
    """Forces of a stage at its evaluation instant by kind, shape (5, size), or (3, size) if the others are none.

    ``numbers`` holds the factors of (x, v, a) in the inertia's acceleration and in the velocity, shape (6,);
    ``gyroscopic`` and ``displacement`` are the matrices Z of the frame's forces, ``frame`` the rest of them; an empty
    ``frame`` is one at rest without loads.
    """
    size, moving = x.size, frame.size > 0
    rows = np.empty((5 if moving else 3, size))
    inertia, inside, loss = rows[0], rows[1], rows[2]
    velocity, acceleration = np.empty(size), np.empty(size)
    for i in range(size):
        acceleration[i] = numbers[0] * x[i] + numbers[1] * v[i] + numbers[2] * a[i]
        velocity[i] = numbers[3] * x[i] + numbers[4] * v[i] + numbers[5] * a[i]
        inside[i] = internal[i] - reference[i]
    for i in range(size):
        first, second = 0.0, 0.0
        for k in range(np.uint64(start[i]), np.uint64(start[i + 1])):
            j = column[k]
            first += mass[k] * acceleration[j]
            second += damping[k] * velocity[j]
        inertia[i], loss[i] = first, second
    if damped:
        add_low_rank(vectors, coefficients, 1.0, velocity, loss)
    if moving:
        place = np.empty(size)
        for i in range(size):
            place[i] = q[i] + x[i]
            rows[3, i], rows[4, i] = frame[i], -load[i]
        add_pair_products(pairs, gyroscopic, 1.0, velocity, rows[3])
        add_pair_products(pairs, displacement, 1.0, place, rows[3])
    return rows


@jit
def add_works(share: float, own: Array, before: Array, start: Array, end: Array, work: Array) -> Array:
    """Work on the way from ``start`` to ``end`` of ``share own + (1 - share) before``, added to that so far."""
    total = work.copy()
    for kind in range(own.shape[0]):
        last, done, other = own[kind], 0.0, 0.0
        if before.size:
            first = before[kind]
            for i in range(last.size):
                move = end[i] - start[i]
                done += last[i] * move
                other += first[i] * move
        else:
            for i in range(last.size):
                done += last[i] * (end[i] - start[i])
        total[kind] += share * done + (1.0 - share) * other
    return total


def written(
    books: Books, now: Array, then: Array, weight: float, instants: tuple[float, float], start: Array, end: Array
) -> Books:
    """Books after a stage.

    Parameters
    ----------
    books
        Before it.
    now, then
        Forces by kind at its evaluation instant, and those that it weighs at its start.
    weight
        Of the former.
    instants
        Of its equilibrium and of its end after its start [s].
    start, end
        Displacement at its start and end, shape (size,).
    """
    own, (at, size) = now, instants
    if weight < 1.0:
        wide = max(len(now), len(then))
        own = weight * _widened(now, wide) + (1.0 - weight) * _widened(then, wide)
        own[INERTIA] = now[INERTIA]
    before, share = books.own, 1.0
    if before.size:
        share = (0.5 * size - books.late) / (at - books.late)
        before = _widened(before, len(own))
    work = add_works(share, _widened(own, len(before)), before, start, end, books.work)
    return Books(work, own, now if weight < 1.0 else NONE, at - size)


def _widened(rows: Array, kinds: int) -> Array:
    """Forces with zeros for those of a frame at rest without loads, as many kinds as given at least."""
    if len(rows) >= kinds:
        return rows
    return np.concatenate([rows, np.zeros((kinds - len(rows), rows.shape[1]))])
