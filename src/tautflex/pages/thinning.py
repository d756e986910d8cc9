"""What a page of bearable size shows of a long run or a fine mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from tautflex.numeric import Indices
from tautflex.plot.surface import Wireframe, wireframe

# Nodes of the drawing at most.
MOST_NODES = 6000


class Drawing(NamedTuple):
    """Mesh to draw: ``mesh``, the ``nodes`` of the run that it has, and the ``triangles`` of the run behind its own."""

    mesh: Wireframe
    nodes: Indices
    triangles: Indices
    cables: Indices


def drawing_of(run: xr.Dataset, most: int = MOST_NODES) -> Drawing:
    """Mesh of a run, with the nodes of a cube of space drawn as one where there are more than ``most``."""
    mesh = wireframe(run)
    count = len(mesh.nodes)
    kept, place = np.arange(count), np.arange(count)
    cells = 2.0 * np.sqrt(most)
    while len(kept) > most:
        # Of a flat film a cube's side covers (span / cells)^2.
        cube = np.floor((mesh.nodes - mesh.nodes.min(axis=0)) / (mesh.span / cells)).astype(np.int64)
        _, kept, place = np.unique(cube, axis=0, return_index=True, return_inverse=True)
        place, cells = place.ravel(), 0.8 * cells

    def joined(corners: Indices) -> tuple[Indices, Indices]:
        new = place[corners]
        rows = np.sort(new, axis=1)
        whole = np.flatnonzero((np.diff(rows, axis=1) > 0).all(axis=1)) if corners.size else np.zeros(0, dtype=int)
        return new[whole], whole

    triangles, triangle_rows = joined(mesh.triangles)
    cables, cable_rows = joined(mesh.cables)
    edges = mesh.edges if len(kept) == count else np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    if len(kept) == count:
        edges = joined(edges)[0]
    members = cables, joined(mesh.beams)[0], joined(mesh.links)[0]
    drawn = Wireframe(mesh.nodes[kept], triangles, edges, *members, np.unique(place[mesh.held]))
    return Drawing(drawn, kept, triangle_rows, cable_rows)


def chosen_frames(stored: int, most: float) -> Indices:
    """Numbers of frames, evenly spaced among those stored, two at least."""
    return np.unique(np.linspace(0, stored - 1, int(min(stored, max(2.0, most)))).round().astype(np.int64))
