"""Elements at linked nodes: their unknowns are those that lead these [theory.md 16].

Rotations theta of what leads swing rigid arms d by ``theta x d + theta x (theta x d)/2``. The first order is in the
gradients. Of the second, ``theta'B theta/2`` for each unknown, strains take ``L G`` times it, so that forces in the
arms turn with them: a force f that the arm carries stiffens theta by ``(f d' + d f')/2 - (f.d) 1``. Inertial forces
of moving frames take it as that of turning sections.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.numeric import Array, Indices
from tautflex.structure.constraints import Constraints


def led(block: ElementBlock, constraints: Constraints) -> ElementBlock:
    """Same elements in terms of what leads their nodes; themselves where nothing does."""
    if not constraints.follows[block.dofs].any():
        return block
    dofs, weights, turns, bends = _led(block.dofs, constraints)
    own, points = block.rows_of(weights), led_points(block.inertia, weights, turns, bends)
    linear = replace(block, dofs=dofs, gradient=block.gradient @ own, inertia=points)
    if block.turns or not bends.shape[2]:  # gradients of a turning line are those of its local frame alone
        return linear
    slopes = np.einsum("sg,ngd->nsd", block.linear, block.gradient)
    return _bent(linear, slopes, block.rows_of(turns), block.rows_of(bends))


def _bent(block: ElementBlock, slopes: Array, turns: Array, bends: Array) -> ElementBlock:
    """Block with the second order of its arms: gradients theta and A theta of each strain ``theta'A theta/2`` more."""
    (count, strains, _), most = slopes.shape, turns.shape[1]
    forms = np.einsum("nsd,ndrij,nrjk->nsrik", slopes, bends, turns)
    size = 3 * most
    more = np.concatenate([turns[:, None], forms], axis=1).reshape(count, (1 + strains) * size, -1)
    first = block.gradient.shape[1]
    total = first + more.shape[1]
    quadratic = np.zeros((strains, total, total))
    quadratic[:, :first, :first] = block.quadratic
    for strain in range(strains):
        theta, formed = first + np.arange(size), first + (1 + strain) * size + np.arange(size)
        quadratic[strain, theta, formed] = quadratic[strain, formed, theta] = 0.5
    return replace(
        block,
        gradient=np.concatenate([block.gradient, more], axis=1),
        linear=np.pad(block.linear, ((0, 0), (0, total - first))),
        quadratic=quadratic,
    )


def led_points(points: InertiaPoints, weights: Array, turns: Array, bends: Array) -> InertiaPoints:
    """Mass points from the unknowns that lead.

    Weights (element, dof, own) are those of unknowns, ``turns`` (element, r, 3, own) those of rotations that swing
    arms, ``bends`` (element, dof, r, 3, 3) second orders of unknowns.
    """
    interpolation, turning = points.interpolation, points.turning
    if turning is not None:
        turning = weights[:, None, None].swapaxes(3, 4) @ turning @ weights[:, None, None]
    if bends.shape[2]:
        shape = (*points.mass.shape, *interpolation.shape[2:])
        weighed = np.einsum("np,npad,npb->nabd", points.mass, np.broadcast_to(interpolation, shape), points.position)
        forms = np.einsum("nabd,ndrij->nabrij", 0.5 * (weighed + weighed.swapaxes(1, 2)), bends)
        swung = np.einsum("nrio,nabrij,nrjp->nabop", turns, forms, turns, optimize=True)
        turning = swung if turning is None else turning + swung
    return replace(points, interpolation=interpolation @ weights[:, None], turning=turning)


def led_inertia(dofs: Indices, points: InertiaPoints, constraints: Constraints) -> tuple[Indices, InertiaPoints]:
    """Unknowns that lead those of elements or bodies, shape (element, own), and mass points that these move."""
    if not constraints.follows[dofs].any():
        return dofs, points
    own, *led_by = _led(dofs, constraints)
    return own, led_points(points, *led_by)


def led_dofs(dofs: Indices, constraints: Constraints) -> tuple[Indices, Array | None]:
    """Unknowns that lead those of elements, shape (element, own), and weights (element, dof, own), None if all do."""
    return constraints.by_element(dofs) if constraints.follows[dofs].any() else (dofs, None)


def _led(dofs: Indices, constraints: Constraints) -> tuple[Indices, Array, Array, Array]:
    """Unknowns that lead those of elements, and what `led_points` takes of them."""
    (count, width), (swung, bends) = dofs.shape, constraints.bends(dofs)
    own, weights = constraints.by_element(np.concatenate([dofs, swung.reshape(count, -1)], axis=1))
    return own, weights[:, :width], weights[:, width:].reshape(*swung.shape, own.shape[1]), bends
