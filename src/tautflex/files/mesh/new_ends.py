"""Ends of beams beside their nodes, at the end of a rigid arm, or hinged to them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tautflex.elements.axes import line_axes
from tautflex.files.mesh.assembly import DEFAULT_ORIENTATION
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Link
from tautflex.structure.links.rigid import RigidLink
from tautflex.structure.links.tie import Tie


@dataclass
class NewEnds:
    """Nodes of a file with new ones behind them, and what links these."""

    points: list[Array]
    links: list[RawLink] = field(default_factory=list)

    def moved(self, where: str, row: int, arm: Array) -> int:
        """Row of a new node at the end of a rigid arm from another one."""
        return self._new(where, row, arm, RigidLink(row, [len(self.points)]))

    def hinged(self, where: str, ends: Sequence[int], end: int, free: Iterable[int], orientation: Array) -> int:
        """Row of a new node at an end of a beam, free of the old one in some of the beam's directions.

        Parameters
        ----------
        where
            Place for messages.
        ends
            Rows of the nodes of both ends.
        end
            Which is hinged, 0 or 1.
        free
            Directions 0 to 5 along the beam's local axes x, y, z.
        orientation
            Direction of its local z axis, nan where the file states none, shape (3,).
        """
        direction = np.where(np.isnan(orientation), DEFAULT_ORIENTATION, orientation)
        axes = line_axes(np.array([[self.points[row] for row in ends]]), direction)[0][0]
        released = set(free)
        kept = tuple(name for k, name in enumerate(DIRECTIONS) if k not in released)
        return self._new(where, ends[end], np.zeros(3), Tie(ends[end], [len(self.points)], kept, axes))

    def _new(self, where: str, row: int, arm: Array, link: Link) -> int:
        self.points.append(self.points[row] + arm)
        self.links.append(RawLink(where, link))
        return len(self.points) - 1
