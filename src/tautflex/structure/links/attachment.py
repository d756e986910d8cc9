"""Nodes that are fixed to the film between its nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, MeshError
from tautflex.numeric import Array
from tautflex.structure.groups import ElementGroup
from tautflex.structure.links.link import Follows, Joined, Link
from tautflex.structure.locate import locate
from tautflex.text import brief


@dataclass(frozen=True)
class Attachment(Link):
    """Nodes that move with the film at their place: ends of cables anywhere on an edge, meshes that do not match.

    Their displacements are interpolated as the film element does that lies there; rotations stay their own.

    Parameters
    ----------
    nodes
        Numbers of the nodes, which must lie on the film and belong to none of its elements.

    Raises
    ------
    InputError
        If there is no node, or one stands twice.
    """

    nodes: Sequence[int]
    kind: ClassVar[str] = "attachment"
    __repr__ = brief

    def __post_init__(self) -> None:
        found = checks.indices("nodes", self.nodes, np.iinfo(np.int64).max).tolist()
        if not found or len(set(found)) < len(found):
            raise InputError(f"nodes: expected at least one node, each once, got {found}; correct them")

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of all nodes that it names; those of the film are found by place."""
        return tuple(self.nodes)

    def follows(self, structure: Joined) -> Iterator[Follows]:
        """Interpolation in the element under each node."""
        films = [group for group in structure.groups if group.shape.dimension == 2]
        for node in self.nodes:
            if any(np.any(group.connectivity == node) for group in films):
                raise MeshError(f"expected node {node} beside the film's own, got one of its nodes; leave it out")
            corners, weights = _under(structure, films, node)
            for axis in range(3):
                others = [((int(c), axis), float(w)) for c, w in zip(corners, weights, strict=True) if w != 0.0]
                yield Follows((node, axis), tuple(others))


def _under(structure: Joined, films: list[ElementGroup], node: int) -> tuple[Array, Array]:
    """Nodes of the film's element that lies where a node is, and their weights there."""
    for group in films:
        # Elements are looked for along the normal of their best plane.
        own = structure.nodes[np.unique(group.connectivity)]
        axes = np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2]
        axes[2] *= np.linalg.det(axes)
        found = locate(group.shape, structure.nodes @ axes.T, group.connectivity, axes @ structure.nodes[node])
        if found is not None:
            return group.connectivity[found[0]], found[1]
    place = ", ".join(f"{x:g}" for x in structure.nodes[node])
    raise MeshError(f"expected node {node} on the film, got one at ({place}) m beside it; move it")
