"""Ends of beams that are not where their grid points are, or not fixed to them: offsets and pin flags."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tautflex.elements.axes import line_axes
from tautflex.errors import MeshError
from tautflex.files.mesh.assembly import DEFAULT_ORIENTATION
from tautflex.files.mesh.nastran.supports import components
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import vector
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Link
from tautflex.structure.links.rigid import RigidLink
from tautflex.structure.links.tie import Tie

ENDS = tuple(range(9, 17))
"""Fields of CBAR and CBEAM about the ends: pin flags, then both offsets."""
Turned = Callable[[int, Array, str], Array]


def offset(card: Card, end: int, number: int, turned: Turned) -> Array:
    """Vector from the grid point of an end (0 or 1) to the end, in basic coordinates."""
    given = vector([card.get(11 + 3 * end + k) for k in range(3)], card.where)
    if not given.any():
        return given
    if card.get(8)[1 + end : 2 + end].upper() == "O":
        raise MeshError(f"{card.where}: expected offsets in the system of the grid point (G), got O; write them there")
    return turned(number, given, card.where)


@dataclass
class MovedEnds:
    """Nodes of a deck with those of moved and pinned ends behind them."""

    points: list[Array]
    links: list[RawLink] = field(default_factory=list)

    def place(self, card: Card, ends: Indices, numbers: list[int], orientation: Array, turned: Turned) -> Indices:
        """Rows of the ends of a beam whose grid points have these rows and numbers."""
        rows = ends.tolist()
        for end in (0, 1):
            arm = offset(card, end, numbers[end], turned)
            if arm.any():
                rows[end] = self._new(card, rows[end], arm, lambda row, new: RigidLink(row, [new]))
        direction = np.where(np.isnan(orientation), DEFAULT_ORIENTATION, orientation)
        for end in (0, 1):
            flags = card.get(9 + end)
            if flags not in ("", "0"):
                pins = components(flags, card.where)
                axes = line_axes(np.array([[self.points[row] for row in rows]]), direction)[0][0]
                kept = tuple(name for k, name in enumerate(DIRECTIONS) if k not in pins)

                def pinned(row: int, new: int, kept: tuple[str, ...] = kept, axes: Array = axes) -> Tie:
                    return Tie(row, [new], kept, axes)

                rows[end] = self._new(card, rows[end], np.zeros(3), pinned)
        return np.array(rows, dtype=np.int64)

    def _new(self, card: Card, row: int, arm: Array, link: Callable[[int, int], Link]) -> int:
        """Row of a new node at an arm from another one that leads it."""
        self.points.append(self.points[row] + arm)
        self.links.append(RawLink(card.where, link(row, len(self.points) - 1)))
        return len(self.points) - 1
