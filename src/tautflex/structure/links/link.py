"""What makes a link: some displacements that follow others, linearly [theory.md 16]."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import DIRECTIONS, ElementGroup

Place = tuple[int, int]
"""A displacement: number of its node, and place of its direction in x, y, z, rx, ry, rz."""


class Joined(NamedTuple):
    """What links join: positions of all nodes [m], shape (node, 3), groups of elements, first unknowns of the nodes."""

    nodes: Array
    groups: tuple[ElementGroup, ...]
    dof_offset: Indices

    def turns(self, node: int) -> bool:
        """Whether a node has rotations."""
        return bool(self.dof_offset[node + 1] - self.dof_offset[node] == 6)


class Arm(NamedTuple):
    """A rigid arm: the node whose rotation theta swings it, and its vector d [m]."""

    node: int
    vector: tuple[float, float, float]


class Follows(NamedTuple):
    """One displacement as the sum of others times weights, and of the second order ``theta x (theta x d)/2`` of an arm.

    The second order is that of forces in the arm, which the arm's turn moves.
    """

    one: Place
    others: tuple[tuple[Place, float], ...]
    arm: Arm | None = None


class Link(ABC):
    """Base of links; a subclass is a frozen dataclass that says which displacements follow which others.

    Rotations of what leads are taken to second order: an arm that turns by 0.2 rad ends 0.1 % of its length astray.
    """

    @property
    @abstractmethod
    def joined(self) -> tuple[int, ...]:
        """Numbers of all nodes that it names."""

    @property
    def turning(self) -> tuple[int, ...]:
        """Nodes that have rotations because of it."""
        return ()

    @abstractmethod
    def follows(self, structure: Joined) -> Iterator[Follows]:
        """What follows what; MeshError if it does not fit the structure."""


def node_numbers(reference: int, nodes: Sequence[int]) -> tuple[int, ...]:
    """Numbers of a reference and of the nodes beside it, each once, or InputError."""
    found = checks.indices("nodes", nodes, np.iinfo(np.int64).max).tolist()
    every = checks.whole("reference", reference, 0), *found
    if not found or len(set(every)) < len(every):
        raise InputError(
            f"nodes: expected nodes beside the reference {reference}, each once, got {found}; correct them"
        )
    return every


def direction_places(directions: Sequence[str]) -> list[int]:
    """Places of directions in x, y, z, rx, ry, rz."""
    return [
        DIRECTIONS.index(checks.one_of("directions", one, DIRECTIONS))
        for one in checks.several("directions", directions, str, "'x'")
    ]
