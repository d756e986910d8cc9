"""Ties: nodes that move as another one does."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import qr

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Follows, Joined, Link, direction_places, node_numbers
from tautflex.text import brief

_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class Tie(Link):
    """Nodes that have the displacements of a reference node, in all directions or some: welds, hinges, sliders.

    Between nodes at different places it carries no moment balance: it holds the structure against turning. Rotations
    are tied where both nodes have them.

    Parameters
    ----------
    reference
        Number of the node that leads.
    nodes
        Numbers of those that follow it.
    directions
        What they have in common, any of ``"x", "y", "z", "rx", "ry", "rz"``: a hinge about z leaves out ``"rz"``.
    axes
        Directions x, y, z that are meant, rows of shape (3, 3) at right angles; None is the floating frame's.

    Raises
    ------
    InputError
        If a node stands twice, a direction is unknown, or the axes are not at right angles.
    """

    reference: int
    nodes: Sequence[int]
    directions: Sequence[str] = DIRECTIONS
    axes: ArrayLike | None = None
    kind: ClassVar[str] = "tie"
    __repr__ = brief

    def __post_init__(self) -> None:
        node_numbers(self.reference, self.nodes)
        direction_places(self.directions)
        rotation("axes", self.axes)

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of all nodes that it names."""
        return self.reference, *self.nodes

    def follows(self, structure: Joined) -> Iterator[Follows]:
        """Equal displacements along the chosen axes."""
        axes, chosen = rotation("axes", self.axes), direction_places(self.directions)
        for first in (0, 3):
            rows = axes[sorted({place - first for place in chosen if first <= place < first + 3})]
            if not len(rows):
                continue
            # What follows is what the rows see best; the rest of the node's directions stay its own.
            order = qr(rows, pivoting=True, mode="r")[1]
            led, free = order[: len(rows)], order[len(rows) :]
            share = np.linalg.solve(rows[:, led], rows[:, free])
            for node in self.nodes:
                if first and not (structure.turns(node) and structure.turns(self.reference)):
                    continue
                for place, weights in zip(led, share, strict=True):
                    others = [((self.reference, first + int(place)), 1.0)]
                    for other, weight in zip(free, weights, strict=True):
                        if abs(weight) > _ROUND_OFF:
                            others.append(((node, first + int(other)), -float(weight)))
                            others.append(((self.reference, first + int(other)), float(weight)))
                    yield Follows((node, first + int(place)), tuple(others))


def rotation(name: str, axes: ArrayLike | None) -> Array:
    """Axes as rows, shape (3, 3), those of the floating frame for None; InputError unless at right angles."""
    if axes is None:
        return np.eye(3)
    rows = checks.float_array(name, axes, (3, 3))
    if not np.allclose(rows @ rows.T, np.eye(3), atol=1e-6):
        raise InputError(f"{name}: expected three unit vectors at right angles, got {rows.tolist()}; correct them")
    return rows
