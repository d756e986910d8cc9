"""Three-dimensional drawing of a deflected membrane with its cables and frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.colors import Normalize
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import (  # type: ignore[import-untyped]
    Line3DCollection,
    Poly3DCollection,
)

from tautflex.numeric import Array, Indices
from tautflex.plot.style import DIVERGING, GREY, SUPPORT
from tautflex.solvers.variables import dataset_of
from tautflex.structure.shapes import TRIANGLE3

VIEW = (30.0, -66.0)  # elevation and azimuth [degrees]
_PIECES = 4000  # triangles are drawn in pieces, so that the colours run as the interpolation does
_BEHIND, _SURFACE, _BEFORE = 1, 2, 3


@dataclass(frozen=True)
class Wireframe:
    """What is drawn: ``nodes`` (node, 3) [m], numbers of triangles, lines between them, members, links, supports."""

    nodes: Array
    triangles: Indices
    edges: Indices
    cables: Indices
    beams: Indices
    links: Indices
    held: Indices

    @property
    def span(self) -> float:
        """Longest side of the bounding box [m]."""
        return float(np.ptp(self.nodes, axis=0).max())


def wireframe(data: xr.Dataset) -> Wireframe:
    """Return the mesh that a Dataset of modes or of a run carries, or raise InputError."""
    data = dataset_of("data", data, "node_position", remedy="pass modes.to_dataset() or run.data")

    def numbers(name: str, columns: int) -> Indices:
        values = data[name].values if name in data else np.zeros((0, columns))
        return np.asarray(values, dtype=np.int64).reshape(-1, columns)

    nodes = np.asarray(data["node_position"].values, dtype=np.float64)
    triangles, edges = numbers("triangle", 3), numbers("membrane_edge", 2)
    if not len(edges):  # the elements are the triangles
        edges = np.unique(np.sort(TRIANGLE3.sides(triangles), axis=1), axis=0)
    cables, beams, links = (numbers(name, 2) for name in ("cable", "beam", "link"))
    return Wireframe(nodes, triangles, edges, cables, beams, links, numbers("held", 1).ravel())


def draw_surface(axes: Axes3D, mesh: Wireframe, displacement: Array, color: Array, limit: float) -> None:
    """Draw a deflected structure.

    Parameters
    ----------
    axes
        Axes of projection ``"3d"``.
    mesh
        Undeflected structure.
    displacement
        Displacement to draw (node, 3) [m], already magnified.
    color
        Value (node,) that colours the membrane.
    limit
        Value of the ends of the colour scale.
    """
    points = mesh.nodes + displacement
    view = _view_direction()
    centre = mesh.nodes.mean(axis=0)
    if mesh.triangles.size:
        _draw_film(axes, mesh, points, color, Normalize(-limit, limit))
    for members, width, shade in ((mesh.cables, 0.5, GREY), (mesh.links, 0.8, GREY), (mesh.beams, 1.4, "black")):
        if members.size:
            near = (mesh.nodes[members].mean(axis=1) - centre) @ view > 0.0
            _lines(axes, points[members[~near]], _BEHIND, color=shade, linewidth=width)
            _lines(axes, points[members[near]], _BEFORE, color=shade, linewidth=width)
    if mesh.held.size:  # a film held all around would be hidden by marks that a few corners need
        look: dict[str, Any] = {"marker": "^", "linestyle": "none", "color": SUPPORT, "clip_on": False}
        size = 3.5 if mesh.held.size <= 24 else 1.5
        axes.plot(*points[mesh.held].T, markersize=size, markeredgewidth=0.0, zorder=_BEFORE, **look)


def _draw_film(axes: Axes3D, mesh: Wireframe, points: Array, color: Array, shades: Normalize) -> None:
    """Draw the membrane and its mesh as one collection, so that nearer parts hide farther ones."""
    parts = int(np.clip(np.sqrt(_PIECES / len(mesh.triangles)), 1, 6))
    corners, values = _refined(points[mesh.triangles], color[mesh.triangles], parts)
    faces = colormaps[DIVERGING](shades(values))
    steps = np.linspace(0.0, 1.0, parts + 1)[:, None]
    along = points[mesh.edges[:, :1]] * (1.0 - steps) + points[mesh.edges[:, 1:]] * steps
    along += 0.004 * mesh.span * _view_direction()  # in front of the faces it borders
    lines = np.stack([along[:, :-1], along[:, 1:], along[:, 1:]], axis=2).reshape(-1, 3, 3)
    ink = np.tile([0.0, 0.0, 0.0, 0.35], (len(lines), 1))
    film = Poly3DCollection(list(np.concatenate([corners, lines])), linewidths=0.25, zorder=_SURFACE)
    film.set(rasterized=True, clip_on=False)
    film.set_facecolor(np.concatenate([faces, 0.0 * ink]))
    film.set_edgecolor(np.concatenate([faces, ink]))
    axes.add_collection3d(film)


def _lines(axes: Axes3D, segments: Array, order: float, **look: Any) -> None:
    if segments.size:
        lines = Line3DCollection(list(segments), zorder=order, capstyle="round", **look)
        lines.set_clip_on(False)
        axes.add_collection3d(lines)


def _view_direction() -> Array:
    up, around = np.radians(VIEW[0]), np.radians(VIEW[1])
    return np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])


def _refined(corners: Array, values: Array, parts: int) -> tuple[Array, Array]:
    """Cut every triangle into equal small ones; return their corners (s, 3, 3) and mean values (s,)."""
    upright = [[(i, j), (i + 1, j), (i, j + 1)] for i in range(parts) for j in range(parts - i)]
    turned = [[(i + 1, j), (i + 1, j + 1), (i, j + 1)] for i in range(parts - 1) for j in range(parts - 1 - i)]
    steps = np.array(upright + turned, dtype=np.float64) / parts
    weights = np.concatenate([1.0 - steps.sum(axis=2, keepdims=True), steps], axis=2)
    points = np.einsum("sck,tkd->tscd", weights, corners).reshape(-1, 3, 3)
    return points, np.einsum("sck,tk->ts", weights, values).reshape(-1) / 3.0
