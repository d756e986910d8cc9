"""Springs as elements: gradients are relative displacements and rotations, and strains the same."""

from __future__ import annotations

import numpy as np

from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.elements.linked import led
from tautflex.numeric import cross_matrix
from tautflex.structure.materials import Material
from tautflex.structure.model import Model

KIND = "spring"
"""Kind that springs have where kinds of element differ."""
_NO_MATERIAL = Material(1.0, 1.0, 0.0)


def spring_block(model: Model) -> ElementBlock:
    """All springs of a model as data; stresses are forces [N] and moments [N m], measures are 1."""
    count = len(model.springs)
    gradient, dofs = np.zeros((count, 6, 12)), np.full((count, 12), model.dof_count)
    stiffness, frames = np.zeros((count, 6)), np.zeros((count, 3, 3))
    for row, spring in enumerate(model.springs):
        axes = spring.axes_at(model.nodes)
        ends = model.nodes[list(spring.nodes)]
        frames[row], stiffness[row] = axes, spring.stiffnesses
        for end, (node, sign) in enumerate(zip(spring.nodes, (-1.0, 1.0) if len(ends) == 2 else (1.0,), strict=True)):
            part, own = gradient[row, :, 6 * end : 6 * end + 6], np.arange(*model.dof_offset[node : node + 2])
            dofs[row, 6 * end : 6 * end + len(own)] = own
            part[:3, :3] = part[3:, 3:] = sign * axes
            if spring.place is not None:
                arm = ends[0] + spring.place * (ends[1] - ends[0]) - ends[end]
                part[:3, 3:] = -sign * axes @ cross_matrix(arm)
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
