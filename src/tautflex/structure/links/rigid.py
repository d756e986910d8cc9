"""Rigid links: nodes that move with another one as one body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from tautflex.numeric import cross_matrix
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Arm, Follows, Joined, Link, direction_places, node_numbers
from tautflex.text import brief


@dataclass(frozen=True)
class RigidLink(Link):
    """Nodes that follow a reference node as parts of a rigid body, ``u + R(theta) d - d`` and ``theta`` [theory.md 16].

    Parameters
    ----------
    reference
        Number of the node that leads.
    nodes
        Numbers of those that follow it.
    directions
        Their directions that do, any of ``"x", "y", "z", "rx", "ry", "rz"``.

    Raises
    ------
    InputError
        If a node stands twice, or a direction is unknown.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.RigidLink(10, [11, 12, 13]).nodes
    [11, 12, 13]
    """

    reference: int
    nodes: Sequence[int]
    directions: Sequence[str] = DIRECTIONS
    kind: ClassVar[str] = "rigid"
    __repr__ = brief

    def __post_init__(self) -> None:
        node_numbers(self.reference, self.nodes)
        direction_places(self.directions)

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of all nodes that it names."""
        return self.reference, *self.nodes

    @property
    def turning(self) -> tuple[int, ...]:
        """All nodes of a body turn."""
        return self.joined

    def follows(self, structure: Joined) -> Iterator[Follows]:
        """``u + theta x d`` with the arm d from the reference, and ``theta``."""
        places = direction_places(self.directions)
        for node in self.nodes:
            arm = structure.nodes[node] - structure.nodes[self.reference]
            lever = -cross_matrix(arm)
            for place in places:
                others = [((self.reference, place), 1.0)]
                if place < 3:
                    others += [((self.reference, 3 + axis), float(lever[place, axis])) for axis in range(3)]
                swung = Arm(self.reference, tuple(arm.tolist())) if place < 3 and arm.any() else None
                yield Follows((node, place), tuple((other, weight) for other, weight in others if weight != 0.0), swung)
