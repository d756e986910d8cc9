r"""Three-node membrane triangle of constant strain.

1. Kinematics: in the element's axes (film axes 1, 2, normal 3) the gradients are
   ``g = (u,1  u,2  v,1  v,2  w,1  w,2)``, constant over the triangle [paper (6)-(7)].
2. Strain, von Karman: ``e11 = u,1 + w,1^2/2``, ``e22 = v,2 + w,2^2/2``, ``g12 = u,2 + v,1 + w,1 w,2``
   [paper (26)]; Green-Lagrange adds the same products of u and v, which makes it objective.
3. Stress: plane stress, initial stress added [paper (30)-(31)].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.axes import film_axes
from tautflex.elements.block import ElementBlock, InertiaPoints, symmetric_terms
from tautflex.elements.laws import law_of
from tautflex.structure.groups import ElementGroup
from tautflex.structure.materials import MembraneSection

Array = NDArray[np.float64]

LINEAR = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0, 0, 1.0, 0, 0], [0, 1.0, 1.0, 0, 0, 0]])


def _quadratic(components: tuple[int, ...]) -> Array:
    terms = []
    for c in components:
        terms += [(0, 2 * c, 2 * c, 0.5), (1, 2 * c + 1, 2 * c + 1, 0.5), (2, 2 * c, 2 * c + 1, 1.0)]
    return symmetric_terms(3, 6, terms)


QUADRATIC = {"von-karman": _quadratic((2,)), "green-lagrange": _quadratic((0, 1, 2))}


def plane_stress(section: MembraneSection) -> Array:
    """Plane-stress elastic matrix [Pa], shape (3, 3) [paper (30)]."""
    nu = section.material.poisson_ratio
    factor = section.material.youngs_modulus / (1.0 - nu**2)
    return factor * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])


def declare(nodes: Array, group: ElementGroup, dofs: NDArray[np.int64]) -> ElementBlock:
    """Membrane elements as data; stresses in Pa, measure = volume [m^3]."""
    section = group.section
    if not isinstance(section, MembraneSection):
        raise TypeError("membrane elements need a MembraneSection")
    corners = nodes[group.connectivity]
    axes, area = film_axes(corners, group.orientation)
    slopes = _shape_slopes(np.einsum("nkx,ncx->nck", axes[:, :2], corners - corners[:, :1]))
    count = len(dofs)
    # gradient[2 c + d, 3 i + k] = dN_i/dx_d * (local axis c)_k
    gradient = np.einsum("nid,nck->ncdik", slopes, axes).reshape(count, 6, 9)
    volume = area * section.thickness
    return ElementBlock(
        kind="membrane",
        dofs=dofs,
        gradient=np.ascontiguousarray(gradient),
        linear=LINEAR,
        quadratic=QUADRATIC[section.strain],
        elasticity=np.broadcast_to(plane_stress(section), (count, 3, 3)),
        initial_stress=group.initial.copy(),
        measure=volume,
        size=np.full(count, section.thickness),
        inertia=_inertia(corners, section.material.density * volume),
        axes=axes,
        material=section.material,
        law=law_of(section),
    )


def _shape_slopes(corners: Array) -> Array:
    """Slopes dN_i/dx_d of the area coordinates, shape (element, 3, 2), from plane corners (element, 3, 2)."""
    following, previous = np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1)
    edge = following - previous
    twice_area = edge[:, 2, 0] * edge[:, 0, 1] - edge[:, 2, 1] * edge[:, 0, 0]
    return np.stack([edge[:, :, 1], -edge[:, :, 0]], axis=2) / twice_area[:, None, None]


def _inertia(corners: Array, mass: Array) -> InertiaPoints:
    """Three-point rule of degree 2: exact for products of two area coordinates."""
    area_coordinates = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)
    interpolation = np.einsum("pi,kl->pkil", area_coordinates, np.eye(3)).reshape(1, 3, 3, 9)
    return InertiaPoints(
        mass=np.repeat(mass[:, None] / 3.0, 3, axis=1),
        interpolation=interpolation,
        position=np.einsum("pi,nik->npk", area_coordinates, corners),
    )
