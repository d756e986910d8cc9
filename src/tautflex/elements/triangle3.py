"""Three-node membrane triangle of constant strain: one row per element [paper (6)-(7), (26)-(36)]."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from tautflex.elements.axes import film_axes
from tautflex.elements.block import ElementBlock, translating_points
from tautflex.elements.element import Element, register_element
from tautflex.elements.membrane import membrane_block, membrane_section
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup
from tautflex.structure.shapes import TRIANGLE3, Shape


@register_element
class Triangle3(Element):
    """Linear interpolation in closed form."""

    kind: ClassVar[str] = "membrane"
    shape: ClassVar[Shape] = TRIANGLE3

    @staticmethod
    def declare(nodes: Array, group: ElementGroup, dofs: Indices) -> ElementBlock:
        """Elements of a group as data."""
        corners = nodes[group.connectivity]
        axes, stretch = film_axes(corners[:, 1:] - corners[:, :1], group.orientation)
        area, section = 0.5 * stretch, membrane_section(group)
        slopes = _slopes(np.einsum("nkx,ncx->nck", axes[:, :2], corners - corners[:, :1]))
        mass = section.material.density * (area * section.thickness) + section.nonstructural_mass * area
        # Three-point rule of degree 2: exact for products of two area coordinates.
        area_coordinates = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)
        inertia = translating_points(np.repeat(mass[:, None] / 3.0, 3, axis=1), area_coordinates, corners)
        return membrane_block(group, dofs, axes, slopes, area, inertia)


def _slopes(corners: Array) -> Array:
    """Slopes dN_i/dx_d of the area coordinates, shape (element, 3, 2), from plane corners (element, 3, 2)."""
    following, previous = np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1)
    edge = following - previous
    twice_area = edge[:, 2, 0] * edge[:, 0, 1] - edge[:, 2, 1] * edge[:, 0, 0]
    return np.stack([edge[:, :, 1], -edge[:, :, 0]], axis=2) / twice_area[:, None, None]
