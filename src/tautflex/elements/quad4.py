"""Four-node membrane quadrilateral: bilinear interpolation, strains at 2 x 2 points [theory.md 14].

Corners may lie in no common plane; every point then has the axes of the warped surface there. Frequencies converge at
order two, as those of triangles do, with half to five sixths of their error on the same nodes.
"""

from __future__ import annotations

from typing import ClassVar

from tautflex.elements.element import Element, register_element
from tautflex.elements.membrane import isoparametric_membrane
from tautflex.structure.shapes import QUAD4, Shape


@register_element
class Quad4(Element):
    """Bilinear membrane."""

    kind: ClassVar[str] = "membrane"
    shape: ClassVar[Shape] = QUAD4
    declare = staticmethod(isoparametric_membrane)
