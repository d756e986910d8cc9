"""Four-node membrane quadrilateral: bilinear interpolation, strains at 2 x 2 points [theory.md 14].

Corners may lie in no common plane; every point then has the axes of the warped surface there. Frequencies converge at
order two, as the triangle's do, with about half its error on the same nodes.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.block import ElementBlock
from tautflex.elements.element import Element, register_element
from tautflex.elements.membrane import isoparametric_membrane
from tautflex.structure.groups import ElementGroup
from tautflex.structure.shapes import QUAD4, Shape


@register_element
class Quad4(Element):
    """Bilinear membrane."""

    kind: ClassVar[str] = "membrane"
    shape: ClassVar[Shape] = QUAD4

    @staticmethod
    def declare(nodes: NDArray[np.float64], group: ElementGroup, dofs: NDArray[np.int64]) -> ElementBlock:
        """Elements of a group as data."""
        return isoparametric_membrane(nodes, group, dofs)
