"""Wrench of everything outside on a free hub: forces on the nodes of the structure as the hub feels them; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.products import inner
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, cross, jit

_cross = jit(cross)


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
    (nodes, moves, turns), result, force, arm = points, np.zeros(6), np.empty(3), np.empty(3)
    for n in range(nodes.shape[0]):
        for i in range(3):
            place = moves[n, i]
            force[i], arm[i] = (load[place], nodes[n, i] + q[place]) if place < q.size else (0.0, nodes[n, i])
        if force[0] != 0.0 or force[1] != 0.0 or force[2] != 0.0:
            result[:3] += force
            result[3:] += _cross(arm, force)
    for n in range(turns.shape[0]):
        for i in range(3):
            if turns[n, i] < q.size:
                result[3 + i] += load[turns[n, i]]
    return result


@jit
def power_of(wrench: Array, twist: Array, load: Array, v: Array) -> float:
    """Power of all external forces [W]: of a wrench on the hub, and of forces on the free unknowns."""
    return inner(wrench, twist) + inner(load, v)
