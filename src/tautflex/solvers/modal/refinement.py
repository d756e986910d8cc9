"""How far a mesh of linear triangles is from converged: the same state with quadratic ones on the same corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.solvers.modal.natural import Modes, solve_modes
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.groups import DIRECTIONS, Support
from tautflex.structure.links.equation import LinkEquation
from tautflex.structure.links.link import Link
from tautflex.structure.links.tie import Tie
from tautflex.structure.model import Model
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


def _middles(model: Model, ends: Indices) -> Iterator[Link]:
    """Links of the nodes in the middle of sides (side, 2) that are linked at both ends.

    Sides of films on each other are tied there as at their ends; others, such as those on beams or in rigid bodies,
    stay straight.
    """
    if not model.links:
        return
    follows, count = model.constraints.dependent, len(model.nodes)
    owner = np.repeat(np.arange(count), np.diff(model.dof_offset))
    leads = model.constraints.matrix[follows].tocoo()
    linked, held, turns = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool), np.diff(model.dof_offset) == 6
    linked[owner[follows]] = linked[owner[leads.col[leads.data == 1.0]]] = held[owner[model.fixed_dofs]] = True
    places: dict[tuple[float, ...], int] = {}
    size = np.ptp(model.nodes, axis=0).max()
    found = np.flatnonzero(linked[ends].all(axis=1))
    for side in found[np.argsort(~held[ends[found]].all(axis=1), kind="stable")].tolist():  # what is held leads
        middle, (a, b) = count + side, ends[side].tolist()
        place = tuple(np.round(model.nodes[[a, b]].mean(axis=0) / size, 6).tolist())
        other = places.setdefault(place, middle)
        if other != middle:
            yield Tie(other, [middle])
        elif turns[[a, b]].any():
            for one in DIRECTIONS[:3]:
                yield LinkEquation([(middle, one, 1.0), (a, one, -0.5), (b, one, -0.5)])


def with_quadratic_triangles(state: PrestressedState) -> PrestressedState | None:
    """The same stresses on nodes in the middle of all sides too; None unless all film elements are linear triangles."""
    model = state.model
    if not model.surfaces or any(group.shape != TRIANGLE3 for group in model.surfaces):
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
    finer = replace(
        model,
        nodes=np.concatenate([model.nodes, model.nodes[ends].mean(axis=1)]),
        groups=tuple(groups),
        supports=tuple(supports),
        links=(*model.links, *_middles(model, ends)),
        prestress_mode="uniform",
    )
    system = StructuralSystem.from_model(finer)
    stress = [block.rows_of(given) for block, given in zip(system.blocks, state.system.initial_stress, strict=True)]
    system = system.with_initial_stress(stress)
    return PrestressedState(system, system.force(np.zeros(system.size))[0], 0.0, 0.0, 0)
