r"""Two-node pretensioned cable.

1. Kinematics: gradients ``g = (s', v', w')``, the axial and the two lateral slopes [paper (4)-(5)].
2. Strain: ``e = s' + (v'^2 + w'^2)/2`` [paper (16), with (19) read as v and w]; Green-Lagrange adds ``s'^2/2``.
3. Stress: ``T0/A + E e`` [paper (20)-(21)].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.block import ElementBlock, InertiaPoints, symmetric_terms
from tautflex.elements.laws import RESIDUAL_STIFFNESS
from tautflex.structure.groups import ElementGroup
from tautflex.structure.materials import CableSection

Array = NDArray[np.float64]

LINEAR = np.array([[1.0, 0.0, 0.0]])
QUADRATIC = {
    "von-karman": symmetric_terms(1, 3, [(0, 1, 1, 0.5), (0, 2, 2, 0.5)]),
    "green-lagrange": symmetric_terms(1, 3, [(0, 0, 0, 0.5), (0, 1, 1, 0.5), (0, 2, 2, 0.5)]),
}


def line_axes(ends: Array, direction: Array) -> tuple[Array, Array]:
    """Local axes and lengths of two-node elements.

    Parameters
    ----------
    ends
        End positions [m], shape (element, 2, 3).
    direction
        Local z is its part normal to the element; where it is parallel, global y is used instead.

    Returns
    -------
    axes
        Local axes as rows, the first along the element, shape (element, 3, 3).
    length
        Lengths [m], shape (element,).
    """
    span = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(span, axis=1)
    along = span / length[:, None]
    third = direction - np.sum(along * direction, axis=1)[:, None] * along
    parallel = np.linalg.norm(third, axis=1) < 1e-6 * np.linalg.norm(direction)
    third[parallel] = np.array([0.0, 1.0, 0.0]) - along[parallel, 1:2] * along[parallel]
    third /= np.linalg.norm(third, axis=1)[:, None]
    return np.stack([along, np.cross(third, along), third], axis=1), length


def declare(nodes: Array, group: ElementGroup, dofs: NDArray[np.int64]) -> ElementBlock:
    """Cable elements as data; stresses in Pa, measure = volume [m^3]."""
    section = group.section
    if not isinstance(section, CableSection):
        raise TypeError("cable elements need a CableSection")
    ends = nodes[group.connectivity]
    axes, length = line_axes(ends, group.orientation)
    slope = axes / length[:, None, None]
    volume = section.area * length
    # Two-point Gauss rule: exact for products of two linear functions.
    ratio = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
    shape = np.stack([1.0 - ratio, ratio], axis=1)
    mass = section.material.density * volume
    return ElementBlock(
        kind="cable",
        dofs=dofs,
        gradient=np.concatenate([-slope, slope], axis=2),
        linear=LINEAR,
        quadratic=QUADRATIC[section.strain],
        elasticity=np.full((len(dofs), 1, 1), section.material.youngs_modulus),
        initial_stress=group.initial / section.area,
        measure=volume,
        inertia=InertiaPoints(
            mass=np.repeat(0.5 * mass[:, None], 2, axis=1),
            interpolation=np.einsum("pi,kl->pkil", shape, np.eye(3)).reshape(1, 2, 3, 6),
            position=np.einsum("pi,nik->npk", shape, ends),
        ),
        axes=axes,
        law="slack" if section.slack else "elastic",
        law_parameters=(section.material.youngs_modulus, 0.0, RESIDUAL_STIFFNESS),
    )
