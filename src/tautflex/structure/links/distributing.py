"""Distributing couplings: they spread what acts on one node over others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError, MeshError
from tautflex.numeric import cross_matrix
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Follows, Joined, Link, direction_places, node_numbers
from tautflex.text import brief

_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class DistributingLink(Link):
    """Node that moves as other nodes do on average, without stiffening them: a payload on a soft panel.

    The rigid motion that fits the weighted displacements of the nodes best moves it: ``mean u + theta x d`` with
    ``theta = (sum w (r.r 1 - r r'))^-1 sum w r x u`` and r, d from their weighted centre. Forces on it spread likewise.

    Parameters
    ----------
    reference
        Number of the node that follows.
    nodes
        Numbers of those that lead it.
    weights
        Weight of each, > 0, one number or one for each.
    directions
        Directions of the reference that follow, any of ``"x", "y", "z", "rx", "ry", "rz"``; rotations are left out
        where it has none.

    Raises
    ------
    InputError
        If a node stands twice, a direction is unknown, or a weight is not positive.
    """

    reference: int
    nodes: Sequence[int]
    weights: ArrayLike = 1.0
    directions: Sequence[str] = DIRECTIONS
    kind: ClassVar[str] = "distributing"
    __repr__ = brief

    def __post_init__(self) -> None:
        node_numbers(self.reference, self.nodes)
        direction_places(self.directions)
        if np.any(checks.spread("weights", self.weights, len(self.nodes)) <= 0.0):
            raise InputError(f"weights: expected weights > 0, got {self.weights!r}; leave out nodes that do not lead")

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of all nodes that it names."""
        return self.reference, *self.nodes

    def follows(self, structure: Joined) -> Iterator[Follows]:
        """Rigid motion of best fit."""
        weights = checks.spread("weights", self.weights, len(self.nodes))
        weights = weights / weights.sum()
        places = structure.nodes[list(self.nodes)]
        arms = places - weights @ places
        second = np.einsum("n,nij->ij", weights, [arm @ arm * np.eye(3) - np.outer(arm, arm) for arm in arms])
        size = float(np.trace(second))
        moments, axes = np.linalg.eigh(second)
        known = moments > _ROUND_OFF * size
        inverse = (axes[:, known] / moments[known]) @ axes[:, known].T
        turns = [weight * inverse @ cross_matrix(arm) for weight, arm in zip(weights, arms, strict=True)]
        lever = -cross_matrix(structure.nodes[self.reference] - weights @ places)
        chosen = [place for place in direction_places(self.directions) if place < 3 or structure.turns(self.reference)]
        for place in chosen:
            turned = lever[place] if place < 3 else np.eye(3)[place - 3]
            if np.abs(turned @ axes[:, ~known]).max(initial=0.0) > _ROUND_OFF * max(1.0, float(np.abs(turned).max())):
                raise MeshError(
                    f"expected nodes that lead {DIRECTIONS[place]} of node {self.reference}, got nodes "
                    f"{list(self.nodes)} in a line, about which they do not turn it; add a node beside the line, or "
                    "leave the direction out"
                )
            others = [
                ((int(node), axis), float(value))
                for node, weight, turn in zip(self.nodes, weights, turns, strict=True)
                for axis, value in enumerate(turned @ turn + (weight * np.eye(3)[place] if place < 3 else 0.0))
                if abs(value) > 1e-15
            ]
            yield Follows((self.reference, place), tuple(others))
