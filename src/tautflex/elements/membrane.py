r"""What all membrane elements share: strains, plane stress, local axes and laws.

1. Kinematics: in the film's axes (1, 2, normal 3) of a point the gradients are
   ``g = (u,1  u,2  v,1  v,2  w,1  w,2)`` [paper (6)-(7)].
2. Strain, von Karman: ``e11 = u,1 + w,1^2/2``, ``e22 = v,2 + w,2^2/2``, ``g12 = u,2 + v,1 + w,1 w,2``
   [paper (26)]; Green-Lagrange adds the same products of u and v, which makes it objective.
3. Stress: plane stress (`Material.plane_stress`), initial stress added [paper (30)-(31)].
"""

from __future__ import annotations

import numpy as np

from tautflex.elements.axes import film_axes
from tautflex.elements.block import ElementBlock, InertiaPoints, symmetric_terms, translating_points
from tautflex.elements.laws import law_of
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup
from tautflex.structure.materials import MembraneSection

LINEAR = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0, 0, 1.0, 0, 0], [0, 1.0, 1.0, 0, 0, 0]])


def _quadratic(components: tuple[int, ...]) -> Array:
    terms = []
    for c in components:
        terms += [(0, 2 * c, 2 * c, 0.5), (1, 2 * c + 1, 2 * c + 1, 0.5), (2, 2 * c, 2 * c + 1, 1.0)]
    return symmetric_terms(3, 6, terms)


QUADRATIC = {"von-karman": _quadratic((2,)), "green-lagrange": _quadratic((0, 1, 2))}


def membrane_section(group: ElementGroup) -> MembraneSection:
    """Section of a group of film elements."""
    assert isinstance(group.section, MembraneSection)
    return group.section


def membrane_block(
    group: ElementGroup,
    dofs: Indices,
    axes: Array,
    slopes: Array,
    area: Array,
    inertia: InertiaPoints,
    owner: Indices | None = None,
) -> ElementBlock:
    """Film elements as data; stresses in Pa, measure = volume [m^3].

    ``axes`` are film axes as rows, shape (row, 3, 3), ``slopes`` those of the interpolation functions along axes 1 and
    2 [1/m], shape (row, node, 2), ``area`` what each row stands for [m^2], shape (row,), and ``owner`` the element of
    each row, None where every element is one row.
    """
    section, count = membrane_section(group), len(area)
    # gradient[2 c + d, 3 i + k] = dN_i/dx_d * (local axis c)_k
    gradient = np.einsum("nid,nck->ncdik", slopes, axes).reshape(count, 6, dofs.shape[1])
    return ElementBlock(
        kind="membrane",
        dofs=dofs,
        gradient=np.ascontiguousarray(gradient),
        linear=LINEAR,
        quadratic=QUADRATIC[section.strain],
        elasticity=np.broadcast_to(section.material.plane_stress, (count, 3, 3)),
        initial_stress=group.initial.copy() if owner is None else group.initial[owner],
        measure=area * section.thickness,
        size=np.full(count, section.thickness),
        inertia=inertia,
        axes=axes,
        material=section.material,
        law=law_of(section),
        owner=owner,
    )


def isoparametric_membrane(nodes: Array, group: ElementGroup, dofs: Indices) -> ElementBlock:
    """Film elements of any surface shape, flat, warped or curved, from its interpolation and rules.

    Every integration point has film axes of its own, in the plane that touches the surface there. Displacement
    gradients along them are those on the surface, so that strains are exact for the interpolated geometry.
    """
    shape, positions = group.shape, nodes[group.connectivity]
    points, weights = shape.strain_rule
    count = len(points) * len(positions)
    tangents = shape.tangents(positions, points).reshape(count, 2, 3)
    axes, stretch = film_axes(tangents, group.orientation)
    # Slopes along local coordinates -> along film axes: the tangents' components there are the Jacobian.
    jacobian = np.einsum("nck,ndk->ndc", axes[:, :2], tangents)
    local = np.tile(shape.slopes(points), (len(positions), 1, 1))
    slopes = np.einsum("nid,ncd->nic", local, np.linalg.inv(jacobian))
    owner = np.repeat(np.arange(len(positions)), len(points))
    area = stretch * np.tile(weights, len(positions))
    points, weights = shape.product_rule
    mass = membrane_section(group).mass_per_measure * shape.stretch(positions, points) * weights
    inertia = translating_points(mass, shape.functions(points), positions)
    return membrane_block(group, dofs, axes, slopes, area, inertia, owner)
