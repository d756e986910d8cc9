"""Stages on a free hub under a wrench that is known beforehand, in a stretch: what `HubForces` does, compiled.

``hub`` holds the parts of a `Body`, those of `points_of`, and factors of `motion_at` for every stage of a step;
wrenches on the hub at the evaluation instant and at the end of every stage of the stretch, shape (row, 2, 6), different
loads, what of each pushes the hub, and which one acts at these instants, shape (row, 2), see `Ahead`; where the stretch
begins: the hub, shape (31,), the accelerations that balance all forces, if they are not those of the scheme, power and
work; then room for the hub and the work at the end of every step, shape (steps, 32).

``start`` holds of a stage velocity and acceleration of the structure, the balanced one and the hub at its start, then
its number in the step and its row in the stretch.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.products import inner
from tautflex.numeric import Array, jit
from tautflex.solvers.transient.accuracy.books import RIGID
from tautflex.solvers.transient.free_hub.balance import add_hub_forces, end_hub, motion_at
from tautflex.solvers.transient.free_hub.outside import power_of, wrench_of


@jit
def foretold(rigid: Array, reach: float) -> Array:
    """Hub with the twist that its rates lead to."""
    guess = rigid.copy()
    guess[7:13] += reach * rigid[25:]
    return guess


@jit
def _pushed(hub: Any, row: int, end: int, q: Array) -> Array:
    """Whole wrench of a stage at its evaluation instant (0) or its end (1), where the structure is at ``q``."""
    return hub[3][row, end] + wrench_of(hub[1], hub[5][hub[6][row, end]], q)


@jit
def add_reaction(
    hub: Any, start: Any, guess: Array, x: Array, q: Array, reach: float, weight: float, residual: Array
) -> tuple[Array, Array, float, float]:
    """Add the forces of the hub's motion to a residual; they over the weight, hub, and norms of `add_hub_forces`."""
    (v, a, true, rigid), stage, row = start
    displacement, velocity, acceleration = motion_at(hub[2][stage], x, q, v, a, true)
    frame, push = residual.copy(), _pushed(hub, row, 0, displacement)
    end, load_norm, norm = add_hub_forces(
        hub[0], displacement, velocity, acceleration, rigid, reach, push, guess[7:13], weight, residual
    )
    for i in range(x.size):
        frame[i] = (residual[i] - frame[i]) / weight
    return frame, end, load_norm, norm


@jit
def end_of_hub(
    hub: Any, start: Any, met: Array, x: Array, q: Array, end: Array, reach: float, size: float, weight: float,
    before: Array, work: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Hub at the end of a stage, balanced acceleration, and power and work there; ``met`` is the hub at ``reach``.

    ``end`` has displacement, velocity and acceleration there, ``before`` power and work at the start; the work of the
    wrench is added to that of the books.
    """
    (v, a, true, rigid), stage, row = start
    acceleration = end[2]
    if weight < 1.0:
        acceleration = true = motion_at(hub[2][stage], x, q, v, a, true)[2]
    if reach != size:
        push = _pushed(hub, row, 1, end[0])
        met = end_hub(hub[0], end[0], end[1], acceleration, rigid, size, push, foretold(rigid, size)[7:13])
    power = power_of(met[19:25], met[7:13], hub[4][hub[6][row, 1]], end[1])
    work[RIGID] += 0.5 * size * (inner(rigid[19:25], rigid[7:13]) + inner(met[19:25], met[7:13]))
    return met, true, np.array([power, before[1] + 0.5 * size * (before[0] + power)])
