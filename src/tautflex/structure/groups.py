"""What a model is made of: groups of elements and supports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tautflex.numeric import Array, Indices
from tautflex.structure.materials import Section
from tautflex.structure.shapes import Shape

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class ElementGroup:
    """Elements of one section and one shape.

    Parameters
    ----------
    section
        Membrane, cable or beam section.
    shape
        Where the nodes sit and what is interpolated between them.
    connectivity
        Node numbers, shape (element, node).
    initial
        Prestress of each element: membrane stress (sx, sy, txy) in local axes [Pa], shape (element, 3); cable
        tension [N], shape (element, 1); beam axial force [N], shape (element, 1).
    orientation
        Direction that fixes the local axes: local x of a membrane is its projection on the film; local z of a
        beam is its part normal to the beam.
    """

    section: Section
    shape: Shape
    connectivity: Indices
    initial: Array
    orientation: Array


@dataclass(frozen=True)
class Support:
    """Nodes held in given directions of the floating frame.

    Parameters
    ----------
    nodes
        Node numbers.
    directions
        Any of ``"x", "y", "z", "rx", "ry", "rz"``; rotations are ignored at nodes that have none.
    """

    nodes: tuple[int, ...]
    directions: tuple[str, ...] = DIRECTIONS

    @classmethod
    def clamped(cls, nodes: ArrayLike) -> Support:
        """Hold all six directions of ``nodes``."""
        return cls(tuple(int(i) for i in np.atleast_1d(np.asarray(nodes))))

    @classmethod
    def pinned(cls, nodes: ArrayLike) -> Support:
        """Hold the three translations of ``nodes``."""
        return cls(tuple(int(i) for i in np.atleast_1d(np.asarray(nodes))), DIRECTIONS[:3])
