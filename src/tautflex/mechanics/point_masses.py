"""Rigid bodies at nodes as mass points that move with them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tautflex.elements.block import InertiaPoints, turning_terms
from tautflex.elements.linked import led_inertia
from tautflex.numeric import Array, Indices, cross_matrix
from tautflex.structure.masses import PointMass
from tautflex.structure.model import Model

KIND = "mass"
"""Kind that point masses have where kinds of element differ."""


@dataclass(frozen=True)
class BodyBlock:
    """All bodies of a model: unknowns that move them, six of their node or more, and their mass points, seven each.

    Unknowns that do not exist, rotations of many nodes, are the one after the last.
    """

    dofs: Indices
    inertia: InertiaPoints


def body_block(model: Model) -> BodyBlock:
    """Bodies of a model as data."""
    first = model.dof_offset[[body.node for body in model.masses]]
    count = np.diff(model.dof_offset)[[body.node for body in model.masses]]
    steps = np.arange(6)
    dofs = np.where(steps < count[:, None], first[:, None] + steps, model.dof_count)
    mass, place = (np.array(parts) for parts in zip(*(_points(body) for body in model.masses), strict=True))
    interpolation = np.zeros((*mass.shape, 3, 6))
    interpolation[..., :3] = np.eye(3)
    interpolation[..., 3:] = [[-cross_matrix(arm) for arm in arms] for arms in place]
    position = model.nodes[[body.node for body in model.masses]][:, None] + place
    points = InertiaPoints(mass, interpolation, position)
    if any(body.turns for body in model.masses):
        second = np.einsum("np,npa,npb->nab", mass, position, place)[:, None]
        points = replace(points, turning=turning_terms(second, np.eye(3, 6, 3)[None, None]))
    return BodyBlock(*led_inertia(dofs, points, model.constraints))


def _points(body: PointMass) -> tuple[Array, Array]:
    """Masses [kg], shape (7,), and places from the node [m], shape (7, 3), of the same mass, centre and inertia.

    The second moments ``P = 1/2 tr(J) 1 - J`` [kg m^2], negative ones of thin bodies too, stand on pairs of points at
    distance s along their principal axes, with ``P_k / (2 s^2)`` each; the rest of the mass is in the centre.
    """
    moments, axes = np.linalg.eigh(0.5 * np.trace(body.tensor) * np.eye(3) - body.tensor)
    total = float(moments.sum())
    distance = np.sqrt(total / body.mass) if body.mass > 0.0 and total > 0.0 else 1.0
    pairs = np.repeat(moments / (2.0 * distance**2), 2)
    signs = np.array([1.0, -1.0] * 3)[:, None]
    mass = np.concatenate([[body.mass - pairs.sum()], pairs])
    return mass, body.arm + np.concatenate([np.zeros((1, 3)), distance * signs * np.repeat(axes.T, 2, axis=0)])
