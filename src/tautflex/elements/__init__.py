"""Elements as data: each file declares one and registers it; nothing else names them."""

from tautflex.elements.beam import Beam
from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.elements.cable import Cable
from tautflex.elements.element import ELEMENTS, Element, element_blocks, register_element
from tautflex.elements.laws import LAWS, Law, LawFunction, TensionOnly, register_law
from tautflex.elements.quad4 import Quad4
from tautflex.elements.triangle3 import Triangle3
from tautflex.elements.triangle6 import Triangle6

__all__ = [
    "ELEMENTS",
    "LAWS",
    "Beam",
    "Cable",
    "Element",
    "ElementBlock",
    "InertiaPoints",
    "Law",
    "LawFunction",
    "Quad4",
    "TensionOnly",
    "Triangle3",
    "Triangle6",
    "element_blocks",
    "register_element",
    "register_law",
]
