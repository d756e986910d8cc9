"""Six-node membrane triangle: quadratic interpolation, strains at three points [theory.md 14].

Nodes are the three corners, then those of the sides 1-2, 2-3 and 3-1; sides may be curved. On a straight-sided element
strains are linear for small displacements, and the three points integrate their squares exactly. Mass has a rule of
degree four, which is exact for products of two quadratic functions. Frequencies converge at order four.
"""

from __future__ import annotations

from typing import ClassVar

from tautflex.elements.element import Element, register_element
from tautflex.elements.membrane import isoparametric_membrane
from tautflex.structure.shapes import TRIANGLE6, Shape


@register_element
class Triangle6(Element):
    """Quadratic membrane."""

    kind: ClassVar[str] = "membrane"
    shape: ClassVar[Shape] = TRIANGLE6
    declare = staticmethod(isoparametric_membrane)
