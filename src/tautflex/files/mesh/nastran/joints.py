"""Ends of beams that are not at their grid points, or not fixed to them: offsets and pin flags."""

from __future__ import annotations

import numpy as np

from tautflex.elements.axes import line_axes
from tautflex.files.mesh.systems import equal_along
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Link
from tautflex.structure.links.rigid import RigidLink

DEFAULT_ORIENTATION = (0.0, 0.0, 1.0)  # that of Model.from_mesh


class Joints:
    """Nodes and links that offsets and pin flags add to a mesh.

    Parameters
    ----------
    points
        Positions of the grid points, shape (point, 3).
    """

    def __init__(self, points: Array) -> None:
        self._points = list(points)
        self.links: list[Link] = []

    @property
    def points(self) -> Array:
        """Positions of the grid points and of the nodes that were added behind them, shape (point, 3)."""
        return np.array(self._points).reshape(-1, 3)

    def offset(self, node: int, shift: Array) -> int:
        """Node that is rigidly joined to another one, at a distance."""
        self._points.append(self._points[node] + shift)
        self.links.append(RigidLink(node, (len(self._points) - 1,)))
        return len(self._points) - 1

    def released(self, node: int, released: set[int], ends: Indices, orientation: Array) -> int:
        """Node at the same place that is joined to another one but for some of its local directions 0 to 5.

        ``ends`` are the two nodes of the beam, whose axes the directions are, with local z along ``orientation``; nan
        is the default.
        """
        self._points.append(self._points[node])
        new = len(self._points) - 1
        direction = np.where(np.isnan(orientation), DEFAULT_ORIENTATION, orientation)
        (axes,), _ = line_axes(np.array([[self._points[end] for end in ends]]), direction)
        for first in (0, 3):
            kept = axes[[k for k in range(3) if first + k not in released]]
            names = DIRECTIONS[first : first + 3]
            if len(kept) == 3:
                self.links.append(RigidLink(node, (new,), names))
            elif len(kept):
                self.links += equal_along(kept, new, node, names)
        return new
