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
    pattern, held = np.zeros((system.size + 1, 3)), np.zeros((6, 3))
    for node, part in zip(nodes, share, strict=True):
        place = system.place[system.model.translation_dofs[node]]
        pattern[place, range(3)] += part
        forces = part * np.diag(place == system.size)
        held += np.concatenate([forces, np.cross(system.model.nodes[node], forces).T])
    return pattern[:-1], held


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
