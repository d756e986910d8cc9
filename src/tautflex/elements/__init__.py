"""Elements as data: each file declares one and registers it; nothing else names them."""

from tautflex.elements import beam, cable, quad4, triangle3, triangle6
from tautflex.elements.block import ElementBlock, InertiaPoints
from tautflex.elements.element import Element, element_blocks, register_element
from tautflex.elements.laws import LAWS, Law, LawFunction, TensionOnly, register_law

__all__ = ["LAWS", "Element", "ElementBlock", "InertiaPoints", "Law", "LawFunction", "TensionOnly"]
__all__ += ["beam", "cable", "element_blocks", "quad4", "register_element", "register_law", "triangle3", "triangle6"]
