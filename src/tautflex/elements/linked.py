"""Elements at linked nodes: their unknowns are those that lead these [theory.md 16]."""

from __future__ import annotations

from dataclasses import replace

from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.numeric import Array, Indices
from tautflex.structure.constraints import Constraints


def led(block: ElementBlock, constraints: Constraints) -> ElementBlock:
    """Same elements in terms of what leads their nodes; themselves where nothing does."""
    if not constraints.follows[block.dofs].any():
        return block
    dofs, weights = constraints.by_element(block.dofs)
    gradient = block.gradient @ block.rows_of(weights)
    return replace(block, dofs=dofs, gradient=gradient, inertia=led_points(block.inertia, weights))


def led_points(points: InertiaPoints, weights: Array) -> InertiaPoints:
    """Mass points from the unknowns that lead, given their weights (element, dof, own)."""
    turning = None if points.turning is None else weights[:, None, None].swapaxes(3, 4) @ points.turning
    return replace(
        points,
        interpolation=points.interpolation @ weights[:, None],
        turning=None if turning is None else turning @ weights[:, None, None],
    )


def led_dofs(dofs: Indices, constraints: Constraints) -> tuple[Indices, Array | None]:
    """Unknowns that lead those of elements, shape (element, own), and weights (element, dof, own), None if all do."""
    return constraints.by_element(dofs) if constraints.follows[dofs].any() else (dofs, None)
