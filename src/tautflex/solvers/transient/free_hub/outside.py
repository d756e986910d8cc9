"""Wrench of everything outside on a free hub: forces on the nodes of the structure as the hub feels them; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.products import inner
from tautflex.mechanics.system import StructuralSystem
from tautflex.motion.triples import crossed, plus, put, triple
from tautflex.numeric import Array, jit


def points_of(system: StructuralSystem) -> tuple[Any, ...]:
    """Nodes, shape (node, 3), places of their displacements and of turning ones' rotations, for `wrench_of`."""
    model = system.model
    turning = np.flatnonzero(np.diff(model.dof_offset) == 6)
    turns = system.place[model.dof_offset[turning][:, None] + np.arange(3, 6)]
    places = system.place[model.translation_dofs].astype(np.int64), turns.astype(np.int64)
    return np.ascontiguousarray(model.nodes, dtype=np.float64), *places


@jit
def wrench_of(points: Any, load: Array, q: Array) -> Array:
    """Force, and torque about O, of forces on the free unknowns, hub axes, shape (6,)."""
    (nodes, moves, turns), result = points, np.zeros(6)
    for n in range(nodes.shape[0]):
        i, j, k = moves[n, 0], moves[n, 1], moves[n, 2]
        force = _of(load, i, 0.0), _of(load, j, 0.0), _of(load, k, 0.0)
        if force[0] != 0.0 or force[1] != 0.0 or force[2] != 0.0:
            arm = _of(q, i, nodes[n, 0]), _of(q, j, nodes[n, 1]), _of(q, k, nodes[n, 2])
            put(result, 0, plus(triple(result, 0), 1.0, force))
            put(result, 3, plus(triple(result, 3), 1.0, crossed(arm, force)))
    for n in range(turns.shape[0]):
        for i in range(3):
            result[3 + i] += _of(load, turns[n, i], 0.0)
    return result


@jit
def _of(vector: Array, place: int, base: float) -> float:
    """What an unknown has, or a supported one has not, beside a number."""
    return base + vector[place] if place < vector.size else base


@jit
def power_of(wrench: Array, twist: Array, load: Array, v: Array) -> float:
    """Power of all external forces [W]: of a wrench on the hub, and of forces on the free unknowns."""
    return inner(wrench, twist) + inner(load, v)
