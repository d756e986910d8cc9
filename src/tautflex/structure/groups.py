"""What a model is made of: groups of elements and supports."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.numeric import Array, Indices
from tautflex.structure.materials import Section
from tautflex.structure.shapes import Shape
from tautflex.text import brief

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
        beam is its part normal to the beam; shape (3,), of beams also (element, 3).
    """

    section: Section
    shape: Shape
    connectivity: Indices
    initial: Array
    orientation: Array
    __repr__ = brief

    def part(self, first: int, last: int) -> ElementGroup:
        """Elements in [first, last) as a group of their own."""
        turned = self.orientation if self.orientation.ndim == 1 else self.orientation[first:last]
        return replace(
            self, connectivity=self.connectivity[first:last], initial=self.initial[first:last], orientation=turned
        )


@dataclass(frozen=True)
class Support:
    """Nodes held in given directions of the floating frame.

    Parameters
    ----------
    nodes
        Node numbers.
    directions
        Any of ``"x", "y", "z", "rx", "ry", "rz"``; rotations are ignored at nodes that have none.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Support.pinned([0, 8]).directions
    ('x', 'y', 'z')
    """

    nodes: tuple[int, ...]
    directions: tuple[str, ...] = DIRECTIONS
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.indices("nodes", self.nodes, np.iinfo(np.int64).max)
        for direction in checks.several("directions", self.directions, str, "'x'"):
            checks.one_of("directions", direction, DIRECTIONS)

    @classmethod
    def clamped(cls, nodes: ArrayLike) -> Support:
        """Hold all six directions of ``nodes``."""
        return cls(_numbers(nodes))

    @classmethod
    def pinned(cls, nodes: ArrayLike) -> Support:
        """Hold the three translations of ``nodes``."""
        return cls(_numbers(nodes), DIRECTIONS[:3])


def _numbers(nodes: ArrayLike) -> tuple[int, ...]:
    return tuple(checks.indices("nodes", np.ravel(np.asarray(nodes)), np.iinfo(np.int64).max).tolist())
