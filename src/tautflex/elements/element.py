"""What makes an element known: the kind of its section, its shape, and a declaration that turns a group into data."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, TypeVar

from tautflex.elements.block import ElementBlock
from tautflex.elements.linked import led
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup
from tautflex.structure.kinds import KINDS
from tautflex.structure.model import Model
from tautflex.structure.shapes import Shape, register_shape


class Element(ABC):
    """Base of elements: a subclass says what it is made of and declares its data; nothing is ever instantiated.

    Attributes
    ----------
    kind
        Kind of the section: ``"membrane"``, ``"cable"`` or ``"beam"``.
    shape
        Nodes, interpolation and rules; its name is the name of the element.
    """

    kind: ClassVar[str]
    shape: ClassVar[Shape]

    @staticmethod
    @abstractmethod
    def declare(nodes: Array, group: ElementGroup, dofs: Indices) -> ElementBlock:
        """All elements of a group as data.

        Parameters
        ----------
        nodes
            Positions of all nodes [m], shape (node, 3).
        group
            Section, connectivity, prestress and orientation.
        dofs
            Unknowns of each element, shape (element, dof).
        """


ELEMENTS: dict[tuple[str, str], type[Element]] = {}
"""Elements by kind of section and name of shape."""

E = TypeVar("E", bound=type[Element])


def register_element(element: E) -> E:
    """Make an element known, with its shape; also a class decorator.

    Raises
    ------
    InputError
        If it is no `Element`, or another one has its section and shape.
    """
    if not (isinstance(element, type) and issubclass(element, Element)):
        raise InputError(f"element: expected a subclass of tautflex.Element, got {element!r}")
    register_shape(element.shape)
    key = element.kind, element.shape.name
    known = ELEMENTS.get(key, element)
    if (known.__module__, known.__qualname__) != (element.__module__, element.__qualname__):
        raise InputError(f"element: expected a new {key[0]} shape, {known.__qualname__} has {key[1]!r}; rename it")
    ELEMENTS[key] = element
    if element.kind not in KINDS:
        KINDS.append(element.kind)
    return element


def element_blocks(model: Model) -> tuple[ElementBlock, ...]:
    """Turn every element group of a model into data, in the order of ``model.element_groups``.

    Raises
    ------
    InputError
        If there is no element for a group's section and shape.
    """
    blocks = tuple(
        _element(group).declare(model.nodes, group, model.element_dofs(group)) for group in model.element_groups
    )
    return tuple(led(block, model.constraints) for block in blocks) if model.links else blocks


def _element(group: ElementGroup) -> type[Element]:
    key = group.section.kind, group.shape.name
    if key not in ELEMENTS:
        known = ", ".join(shape for kind, shape in ELEMENTS if kind == key[0])
        raise InputError(f"element: expected a {key[0]} of shape {known}, got {key[1]!r}; register_element makes more")
    return ELEMENTS[key]
