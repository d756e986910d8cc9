"""How far a mesh of linear triangles is from converged: the same state with quadratic ones on the same corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.modal.natural import Modes, solve_modes
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.groups import Support
from tautflex.structure.shapes import TRIANGLE3, TRIANGLE6


def mesh_errors(modes: Modes, chosen: list[int]) -> Array:
    """Relative errors of the frequencies of chosen modes (places from 0), NaN where the film has other elements.

    Frequencies of quadratic triangles converge at order four, those of linear ones at order two [theory.md 14]; what
    the two differ by under the same stresses is the error of the latter.
    """
    finer = with_quadratic_triangles(modes.state)
    if finer is None:
        return np.full(len(chosen), np.nan)
    fine = solve_modes(finer, min(len(modes.frequencies) + 4, finer.system.size - 1))
    corners = fine.shapes[:, : len(modes.state.model.nodes)].reshape(len(fine.frequencies), -1)
    shapes = modes.shapes[chosen].reshape(len(chosen), -1)
    alike = np.abs(shapes @ corners.T) / np.linalg.norm(corners, axis=1)
    return modes.frequencies[chosen] / fine.frequencies[alike.argmax(axis=1)] - 1.0


def with_quadratic_triangles(state: PrestressedState) -> PrestressedState | None:
    """The same stresses on nodes in the middle of all sides too; None unless all film elements are linear triangles.

    None with links as well: what those in the middle of linked sides follow, no one says.
    """
    model = state.model
    if not model.surfaces or model.links or any(group.shape != TRIANGLE3 for group in model.surfaces):
        return None
    sides = np.concatenate([group.shape.sides(group.connectivity) for group in model.surfaces])
    ends, number = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    middle = (len(model.nodes) + number.reshape(-1, 3)).astype(np.int64)
    groups, first = [], 0
    for group in model.groups:
        if group.shape == TRIANGLE3:
            own = middle[first : first + len(group.connectivity)]
            first += len(own)
            group = replace(group, shape=TRIANGLE6, connectivity=np.hstack([group.connectivity, own]))
        groups.append(group)
    supports = []
    for support in model.supports:
        held = len(model.nodes) + np.flatnonzero(np.isin(ends, support.nodes).all(axis=1))
        supports.append(Support((*support.nodes, *held.tolist()), support.directions))
    nodes = np.concatenate([model.nodes, model.nodes[ends].mean(axis=1)])
    finer = replace(model, nodes=nodes, groups=tuple(groups), supports=tuple(supports), prestress_mode="uniform")
    system = StructuralSystem.from_model(finer)
    stress = [block.rows_of(given) for block, given in zip(system.blocks, state.system.initial_stress, strict=True)]
    system = system.with_initial_stress(stress)
    return PrestressedState(system, system.force(np.zeros(system.size))[0], 0.0, 0.0, 0)
