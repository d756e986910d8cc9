"""A grid of three-dimensional drawings, each filling its cell, over one colour bar."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D, proj3d  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from tautflex.numeric import Array
from tautflex.plot.style import DIVERGING, DOUBLE_COLUMN, GREY, SINGLE_COLUMN, length_unit, new_figure
from tautflex.plot.surface import VIEW, Wireframe, draw_surface

_TITLE = 0.22  # [inch] above each drawing
_BAR = 0.5  # [inch] below all drawings
_GAP = 0.2  # [inch] between drawings
_RISE = 0.1  # largest deflection of a shape without a scale, as a part of the structure's length


def draw_shapes(mesh: Wireframe, titles: Sequence[str], shapes: Array, columns: int) -> Figure:
    """Draw shapes (n, node, 3) without a scale, the largest entry of each being 1."""
    grid = _PanelGrid(mesh, [_RISE * mesh.span] * len(titles), titles, columns)
    for axes, shape in zip(grid.axes, shapes, strict=True):
        draw_surface(axes, mesh, _RISE * mesh.span * shape, shape[:, 2], 1.0)
    return grid.with_bar(1.0, "transverse displacement / largest displacement")


def draw_deflections(
    mesh: Wireframe, titles: Sequence[str], fields: Array, factor: float, columns: int, level: bool = True
) -> Figure:
    """Draw displacements (n, node, 3) [m] times a factor, all to one scale of colours.

    Rows of drawings are equally high if ``level``, else as high as what they show.
    """
    rises = np.abs(fields[..., 2]).max(axis=1)
    scale, unit = length_unit(fields[..., 2])
    limit = scale * float(rises.max()) or 1.0
    grid = _PanelGrid(mesh, factor * (np.full_like(rises, rises.max()) if level else rises), titles, columns)
    for axes, field in zip(grid.axes, fields, strict=True):
        draw_surface(axes, mesh, factor * field, scale * field[:, 2], limit)
    return grid.with_bar(limit, f"transverse displacement $w$ [{unit}]  (drawn $\\times$ {factor:g})")


class _PanelGrid:
    """Figure with one cell per title; ``axes[k]`` is drawn to fill cell k.

    Constrained layout keeps three-dimensional axes square and mostly empty, so the cells are laid out here:
    as wide as the page allows and as high as the drawing, seen from its view point, needs.

    Parameters
    ----------
    mesh
        Structure that every cell shows.
    heights
        Largest deflection drawn in each cell, up or down [m].
    titles
        One per cell.
    columns
        Cells side by side, two or more filling the width of the page.
    """

    def __init__(self, mesh: Wireframe, heights: ArrayLike, titles: Sequence[str], columns: int) -> None:
        heights = np.asarray(heights, dtype=np.float64)
        of, columns = max(columns, 2), min(columns, len(titles))
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        room = np.maximum(0.5 * (high - low), 1e-3 * mesh.span)
        room[2] = 0.5 * (high[2] - low[2]) + max(float(heights.max()), 0.02 * mesh.span)
        self._middle, self._room, self._span = 0.5 * (low + high), room, mesh.span
        cell = DOUBLE_COLUMN / of
        part = (cell - _GAP) / cell
        rows = [
            self._fit(mesh, float(heights[first : first + columns].max()), part)
            for first in range(0, len(titles), columns)
        ]
        tall = [ratio * cell + _TITLE + _GAP for _, _, ratio in rows]
        width, total = max(cell * columns, SINGLE_COLUMN), sum(tall) + _BAR
        self.figure = new_figure(width, total, constrained=False)
        self.axes: list[Axes3D] = []
        left = 0.5 * (width - cell * columns)
        for k, title in enumerate(titles):
            row, column = divmod(k, columns)
            zoom, shift, ratio = rows[row]
            x, y = left + cell * (column + 0.5), total - sum(tall[:row])  # middle and top of the cell [inch]
            self.figure.text(x / width, (y - 0.04) / total, title, ha="center", va="top")
            centre = (x - cell * shift[0], y - _TITLE - 0.5 * ratio * cell - cell * shift[1])
            corner = ((centre[0] - 0.5 * cell) / width, (centre[1] - 0.5 * cell) / total)
            axes = self.figure.add_axes((*corner, cell / width, cell / total), projection="3d")
            self._frame(axes, zoom)
            self.axes.append(axes)
        self._directions(self.axes[0])

    def with_bar(self, limit: float, label: str) -> Figure:
        """Add the bar of a scale from -limit to limit under the drawings; return the figure."""
        width, total = self.figure.get_size_inches()
        long = min(3.2, 0.8 * width)
        place = (0.5 - 0.5 * long / width, (_BAR - 0.12) / total, long / width, 0.09 / total)
        shades = ScalarMappable(Normalize(-limit, limit), DIVERGING)
        bar = self.figure.colorbar(shades, cax=self.figure.add_axes(place), orientation="horizontal")
        bar.locator = MaxNLocator(6, steps=[1, 2, 5, 10])
        bar.set_label(label, labelpad=2)
        bar.ax.tick_params(direction="out", pad=1.5)
        return self.figure

    def _fit(self, mesh: Wireframe, height: float, part: float) -> tuple[float, Array, float]:
        """Zoom that makes the drawing ``part`` of the cell wide, its centre off the axes' and its height.

        Both in units of the width of the cell.
        """
        rise = np.array([[0.0, 0.0, -height], [0.0, 0.0, height]])
        figure = Figure(figsize=(1, 1))
        axes: Axes3D = figure.add_axes((0, 0, 1, 1), projection="3d")
        self._frame(axes, 1.0)
        reached = np.concatenate([mesh.nodes, *(mesh.nodes[mesh.triangles].reshape(-1, 3) + z for z in rise)])
        x, y, _ = proj3d.proj_transform(*reached.T, axes.get_proj())
        seen = (axes.transData + axes.transAxes.inverted()).transform(np.column_stack([x, y]))
        low, high = seen.min(axis=0), seen.max(axis=0)
        zoom = part / float(high[0] - low[0])
        return zoom, zoom * (0.5 * (low + high) - 0.5), zoom * float(high[1] - low[1])

    def _frame(self, axes: Axes3D, zoom: float) -> None:
        """Set limits, equal scales and view."""
        low, high = self._middle - self._room, self._middle + self._room
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect(tuple(2 * self._room), zoom=zoom)
        axes.view_init(*VIEW)
        axes.set_proj_type("ortho")
        axes.set_axis_off()
        axes.patch.set_visible(False)  # neighbours overlap, with nothing drawn where they do
        axes.computed_zorder = False

    def _directions(self, axes: Axes3D) -> None:
        """Draw the directions x and y below the near left corner, so that a bare drawing can be read."""
        size = 0.12 * self._span
        start = self._middle - self._room * [1, 1, 0] + self._span * np.array([0.17, -0.27, 0.0])
        for axis, name in enumerate("xy"):
            step = size * np.eye(3)[axis]
            arrow = axes.quiver(*start, *step, color=GREY, linewidth=0.8, arrow_length_ratio=0.3)
            arrow.set_clip_on(False)
            axes.text(*(start + 1.35 * step), name, size=8, style="italic", ha="center", va="center", color=GREY)
