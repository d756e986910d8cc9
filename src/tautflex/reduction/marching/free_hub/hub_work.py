"""What a reduced model's steps on a free hub keep, and the works of their forces by kind; compiled."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.numeric import Array, jit
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import TWIST, WRENCH, HubPlace, add_slopes, new_place
from tautflex.reduction.polynomial.forces import dot
from tautflex.solvers.transient.accuracy.books import RIGID

KNOWN, LATE, POWER, DONE = range(4)


class HubWork(NamedTuple):
    """What survives from step to step beside `Work`, and space.

    Parameters
    ----------
    rigid
        The hub, shape (31,), see `RigidState`; about one axis its momentum is that about this axis.
    balanced
        Acceleration that balances all forces, shape (r,).
    work
        As of `Books`, shape (7,).
    own, now
        Forces of the last equilibrium by kind, and those at its evaluation instant, shape (5, r).
    marks
        Whether they are known, how late they are [s]; power of all that acts from outside [W], and its work [J].
    moved
        Space for the hub, shape (31,).
    at
        The last place.
    solved
        ``M^-1 G'`` by rows, shape (6, r).
    rows
        Forces of a stage by kind, shape (5, r).
    space
        Shape (6, r).
    parts
        Internal force, and the part of it that is not elastic, shape (2 r,).
    given, last
        What inputs give to the internal force, shape (m,), and what they gave at the end of the last explicit step.
    load
        Load of the inputs on the coordinates, on the left-hand side, what the internal force holds of them, and what of
        both is due to changes of stress, shape (3, r).
    wrench
        Of everything outside, shape (6,).
    inverse
        Of the mass, shape (r, r).
    seen, seen_hub
        Coordinates, their velocities and the hub at the evaluation instant of the last stage, shapes (2, r) and (31,).
    """

    rigid: Array
    balanced: Array
    work: Array
    own: Array
    now: Array
    marks: Array
    moved: Array
    at: HubPlace
    solved: Array
    rows: Array
    space: Array
    parts: Array
    given: Array
    last: Array
    load: Array
    wrench: Array
    inverse: Array
    seen: Array
    seen_hub: Array


def new_hub_work(hub: HubArrays, mass: Array, given: int) -> HubWork:
    """Zeros of the right shapes; ``given`` numbers are given to the internal force."""
    r, zeros = len(mass), np.zeros
    return HubWork(
        rigid=zeros(31),
        balanced=zeros(r),
        work=zeros(7),
        own=zeros((5, r)),
        now=zeros((5, r)),
        marks=zeros(4),
        moved=zeros(31),
        at=new_place(hub),
        solved=zeros((6, r)),
        rows=zeros((5, r)),
        space=zeros((6, r)),
        parts=zeros(2 * r),
        given=zeros(given),
        last=zeros(given),
        load=zeros((3, r)),
        wrench=zeros(6),
        inverse=np.ascontiguousarray(np.linalg.inv(mass)),
        seen=zeros((2, r)),
        seen_hub=zeros(31),
    )


@jit
def set_inputs(arrays: Any, inputs: HubInputs, row: int, q: Array, ride: HubWork) -> None:
    """Fill load, stress and wrench of the inputs at q."""
    load, stress = inputs.load[row % inputs.load.shape[0]], inputs.stress[row % inputs.stress.shape[0]]
    inside, pulled = (
        inputs.inside[row % inputs.inside.shape[0]],
        inputs.inside_stress[row % inputs.inside_stress.shape[0]],
    )
    for i in range(q.size):
        ride.load[0, i], ride.load[1, i], ride.load[2, i] = load[i], 0.0, inside[i]
    for k in range(stress.size):
        ride.given[k] = stress[k]
    # Stresses in elements are part of the internal force.
    add_slopes(arrays.first, arrays.second, stress[: arrays.first.size], q, ride.load[1])
    add_slopes(arrays.first, arrays.second, pulled, q, ride.load[2])
    given, arms = inputs.wrench[row % inputs.wrench.shape[0]], inputs.arms[row % inputs.arms.shape[0]]
    for k in range(6):
        ride.wrench[k] = given[k]
    for k in range(arms.shape[0]):
        ride.wrench[6 - arms.shape[0] + k] += dot(arms[k], q)


@jit
def given_power(ride: HubWork, v: Array) -> float:
    """Power of forces of inputs on the coordinates, but for changes of stress [W]."""
    return dot(ride.load[2], v) - dot(ride.load[0], v) - dot(ride.load[1], v)


@jit
def enter_rigid(ride: HubWork, end: Array, v: Array, size: float) -> None:
    """Enter what acts from outside during a stage of a size [s] that ends with this hub and these velocities."""
    power, before = 0.0, 0.0
    for k in range(6):
        before += ride.rigid[WRENCH + k] * ride.rigid[TWIST + k]
        power += end[WRENCH + k] * end[TWIST + k]
    ride.work[RIGID] += 0.5 * size * (before + power)
    power += given_power(ride, v)
    ride.marks[DONE] += 0.5 * size * (ride.marks[POWER] + power)
    ride.marks[POWER] = power


@jit
def enter_rows(ride: HubWork, weight: float, late: float, size: float, start: Array, end: Array) -> None:
    """Enter the works of a stage's forces by kind on the way from start to end, as `written` does for a full run.

    ``late`` is the instant of its equilibrium after the start [s], ``weight`` that of the forces at its evaluation.
    """
    known, share = ride.marks[KNOWN] != 0.0, 1.0
    if known:
        share = (0.5 * size - ride.marks[LATE]) / (late - ride.marks[LATE])
    for kind in range(5):
        row, own, now, done, other = ride.rows[kind], ride.own[kind], ride.now[kind], 0.0, 0.0
        for i in range(start.size):
            mixed = row[i] if kind == 0 else weight * row[i] + (1.0 - weight) * now[i]
            done += mixed * (end[i] - start[i])
            other += own[i] * (end[i] - start[i])
            now[i], own[i] = row[i], mixed
        ride.work[kind] += share * done + (1.0 - share) * other
    ride.marks[KNOWN], ride.marks[LATE] = 1.0, late - size
