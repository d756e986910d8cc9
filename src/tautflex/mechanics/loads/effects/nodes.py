"""Forces that nodes share: their patterns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.prepared import PatternLoad
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices


def checked_nodes(system: StructuralSystem, nodes: Sequence[int]) -> Indices:
    """Node numbers as an array; InputError if there is none, one is not in the model, or one stands twice."""
    found = checks.indices("nodes", nodes, len(system.model.nodes))
    if not len(found):
        raise InputError("nodes: expected at least one node, got none; give its number")
    if len(np.unique(found)) < len(found):
        raise InputError(f"nodes: expected every node once, got {found.tolist()}; leave repeated ones out")
    return found


def unit_vector(name: str, vector: Sequence[float]) -> Array:
    """Vector of length 1 along a given one, shape (3,); InputError if that has no length."""
    given = checks.vector3(name, vector)
    length = float(np.linalg.norm(given))
    if not length:
        raise InputError(f"{name}: expected a vector with a length, got {given.tolist()}; give for example [0, 0, 1]")
    return given / length


def nodal_pattern(system: StructuralSystem, nodes: Indices, share: Array) -> tuple[Array, Array]:
    """Force on free unknowns and wrench of the others (`PatternLoad`) along x, y, z, where each node gets its share."""
    forces = np.zeros((system.model.dof_count, 3))
    forces[system.model.translation_dofs[nodes], range(3)] += np.reshape(share, (-1, 1))
    return bound_forces(system, forces)


def bound_forces(system: StructuralSystem, forces: Array) -> tuple[Array, Array]:
    """Forces on all unknowns, shape (dof, n), as those on the free ones and the wrench of the held ones."""
    model = system.model
    if model.links:
        forces = model.constraints.matrix[:-1, :-1].T @ forces
    held, offset = np.zeros((6, forces.shape[1])), model.dof_offset
    bound = np.where(system.place[:-1, None] == system.size, forces, 0.0)
    loaded = np.flatnonzero(bound.any(axis=1))
    for node in np.unique(np.searchsorted(offset, loaded, side="right") - 1):
        own = bound[offset[node] : offset[node + 1]]
        held[:3] += own[:3]
        held[3:] += np.cross(model.nodes[node], own[:3].T).T
        held[3:] += own[3:].reshape(-1, *held[3:].shape).sum(axis=0)
    return forces[model.free_dofs], held


def shared_force(
    system: StructuralSystem,
    nodes: Indices,
    share: Array,
    direction: Sequence[float] | None,
    force: Signal | None,
    unit: str,
) -> PatternLoad:
    """Force of three numbers, or of one along a direction, whose nodes have their shares."""
    pattern, held = nodal_pattern(system, nodes, share)
    labels = tuple(f"force_{axis} [{unit}]" for axis in "xyz")
    if direction is not None:
        turn = unit_vector("direction", direction)[:, None]
        pattern, held, labels = pattern @ turn, held @ turn, (f"force [{unit}]",)
    return PatternLoad(force, "force", labels, -np.inf, pattern, held)
