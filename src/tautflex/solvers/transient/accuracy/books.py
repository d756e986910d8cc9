r"""Books of energy: what the forces of every step's own equilibrium do on the displacement, by kind; compiled.

A stage solves ``M a_s + w P_e + (1 - w) P_n = 0``, whose forces P are internal, of damping, of the moving frame and of
loads. Times the displacement of the stage this is the energy that each kind takes up, and the sum over all kinds is
what Newton's method left. The equilibrium belongs to the instant ``w e`` of the stage, e its evaluation instant; what
the forces do over the stage is taken at its middle, from this equilibrium and the one before it, which is of second
order for all kinds: the trapezoidal rule for Newmark's method, the mid-point rule for the energy-conserving one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.mechanics.products import inner
from tautflex.numeric import Array, jit

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
    weight: float, internal: Array, reference: Array, load: Array, then: Array, place: Array, end: Array,
    instants: tuple[float, float, float], before: Array, done: Array, own: Array, now: Array,
) -> Array:  # fmt: skip
    """Fill in the forces of a stage by kind, shape (5, size); return the work done since the start of the run.

    Parameters
    ----------
    weight
        Of the forces at the evaluation instant, beside those at the start.
    internal, reference, load
        Internal force, what of it the reference carries, and load, at the evaluation instant, shape (size,).
    then
        Forces by kind that are weighed at the start, shape (5, size); else empty.
    place, end
        Displacement at the start and at the end.
    instants
        Of the equilibrium and of the end after the start, and of the equilibrium before after that [s].
    before, done
        Forces of that by kind, (0, 0) behind a jump, and the work until the start.
    own, now
        Forces of this equilibrium, with inertia, damping and the frame's at the evaluation instant filled in, and
        those of that instant alone where they differ.
    """
    size, other, inside, pushed = place.size, 1.0 - weight, own[INTERNAL], own[LOAD]
    for i in range(size):
        inside[i] = internal[i] - reference[i]
    for i in range(size):
        pushed[i] = -load[i]
    if then.size:
        now[:] = own
        for kind in range(5):
            if kind != INERTIA:
                mixed, last = own[kind], then[kind]
                for i in range(size):
                    mixed[i] = weight * mixed[i] + other * last[i]
    work, moved, part, (instant, length, late) = done.copy(), np.empty(size), np.empty(size), instants
    for i in range(size):
        moved[i] = end[i] - place[i]
    if not before.size:
        for kind in range(5):
            work[kind] += inner(own[kind], moved)
        return work
    share = (0.5 * length - late) / (instant - late)
    for kind in range(5):
        here, there = own[kind], before[kind]
        for i in range(size):
            part[i] = share * here[i] + (1.0 - share) * there[i]
        work[kind] += inner(part, moved)
    return work
