"""Springs and dampers as data: gradients are relative displacements and rotations, and strains the same."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.elements.linked import led
from tautflex.numeric import Array, Indices, cross_matrix
from tautflex.structure.materials import Material
from tautflex.structure.model import Model
from tautflex.structure.springs import Joint

KIND = "spring"
"""Kind that springs have where kinds of element differ."""
_NO_MATERIAL = Material(1.0, 1.0, 0.0)


def _differences(model: Model, joints: Sequence[Joint]) -> tuple[Indices, Array, Array]:
    """Unknowns (joint, 12), differences along and about the axes (joint, 6, 12), and the axes (joint, 3, 3)."""
    count = len(joints)
    gradient, dofs = np.zeros((count, 6, 12)), np.full((count, 12), model.dof_count)
    frames = np.zeros((count, 3, 3))
    for row, joint in enumerate(joints):
        axes = joint.axes_at(model.nodes)
        ends = model.nodes[list(joint.nodes)]
        frames[row] = axes
        for end, (node, sign) in enumerate(zip(joint.nodes, (-1.0, 1.0) if len(ends) == 2 else (1.0,), strict=True)):
            part, own = gradient[row, :, 6 * end : 6 * end + 6], np.arange(*model.dof_offset[node : node + 2])
            dofs[row, 6 * end : 6 * end + len(own)] = own
            part[:3, :3] = part[3:, 3:] = sign * axes
            if joint.place is not None:
                arm = ends[0] + joint.place * (ends[1] - ends[0]) - ends[end]
                part[:3, 3:] = -sign * axes @ cross_matrix(arm)
    return dofs, gradient, frames


def spring_block(model: Model) -> ElementBlock:
    """All springs of a model as data; stresses are forces [N] and moments [N m], measures are 1."""
    dofs, gradient, frames = _differences(model, model.springs)
    count, stiffness = len(model.springs), np.array([spring.stiffnesses for spring in model.springs])
    none = InertiaPoints(np.zeros((count, 0)), np.zeros((1, 0, 3, 12)), np.zeros((count, 0, 3)))
    block = ElementBlock(
        kind=KIND,
        dofs=dofs,
        gradient=gradient,
        linear=np.eye(6),
        quadratic=np.zeros((6, 6, 6)),
        elasticity=stiffness[:, :, None] * np.eye(6),
        initial_stress=np.zeros((count, 6)),
        measure=np.ones(count),
        size=np.ones(count),
        inertia=none,
        axes=frames,
        material=_NO_MATERIAL,
    )
    return led(block, model.constraints)


def damper_rates(model: Model) -> tuple[Array, Array]:
    """Dampers as ``sum_k c_k v_k v_k'``: v on all unknowns, shape (rank, dof), and c [N s/m, N m s/rad], (rank,)."""
    dofs, gradient, _ = _differences(model, model.dampers)
    values = np.reshape([damper.values for damper in model.dampers], (-1, 6))
    row, axis = np.nonzero(values)
    vectors = np.zeros((len(row), model.dof_count + 1))
    np.add.at(vectors, (np.arange(len(row))[:, None], dofs[row]), gradient[row, axis])
    return vectors[:, :-1], values[row, axis]
