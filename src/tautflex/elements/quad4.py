"""Four-node membrane quadrilateral: bilinear interpolation, strains at 2 x 2 points [theory.md 14].

Corners may lie in no common plane; every point then has the axes of the warped surface there. Frequencies converge at
order two, as those of triangles do, with half to five sixths of their error on the same nodes.
"""

from __future__ import annotations

from typing import ClassVar

from tautflex.elements.block import ElementBlock
from tautflex.elements.element import Element, register_element
from tautflex.elements.membrane import isoparametric_membrane
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup
from tautflex.structure.shapes import QUAD4, Shape


@register_element
class Quad4(Element):
    """Bilinear membrane."""

    kind: ClassVar[str] = "membrane"
    shape: ClassVar[Shape] = QUAD4

    @staticmethod
    def declare(nodes: Array, group: ElementGroup, dofs: Indices) -> ElementBlock:
        """Elements of a group as data."""
        return isoparametric_membrane(nodes, group, dofs)
