"""Figure of mode shapes, as in the paper's Figure 3."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from tautflex.errors import InputError
from tautflex.plot.panels import PanelGrid
from tautflex.plot.style import save_figure, styled
from tautflex.plot.surface import draw_surface, wireframe

_RISE = 0.1  # largest deflection drawn, as a part of the structure's length


@styled
def plot_modes(modes: xr.Dataset, count: int = 6, columns: int = 3) -> Figure:
    """Draw the first modes as deflected surfaces, coloured by transverse displacement.

    Parameters
    ----------
    modes
        Dataset with ``frequency(mode)`` [Hz], ``shape(mode, node, component)``, the mesh, and, where known,
        ``label_m``, ``label_n`` and ``symmetry``: what ``Modes.to_dataset()`` gives.
    count
        Number of modes, fewer if there are fewer.
    columns
        Drawings side by side.

    Returns
    -------
    matplotlib.figure.Figure
        Every mode is drawn to the same largest translation.

    Raises
    ------
    InputError
        If ``modes`` has no shapes or no mesh, or ``count`` or ``columns`` is below 1.
    """
    if "shape" not in modes or modes.sizes.get("mode", 0) == 0:
        raise InputError(
            f"modes: expected 'shape' (mode, node, component), got {sorted(map(str, modes.data_vars))}; "
            "pass solve_modes(state).to_dataset()"
        )
    if count < 1 or columns < 1:
        raise InputError(f"count, columns: expected whole numbers of at least 1, got {count!r}, {columns!r}")
    mesh = wireframe(modes)
    count = min(count, modes.sizes["mode"])
    titles = [mode_title(modes, k) for k in range(count)]
    grid = PanelGrid(mesh, _RISE * mesh.span, titles, min(columns, count), of=max(columns, 2))
    for k, axes in enumerate(grid.axes):
        shape = modes["shape"].isel(mode=k).values
        shape = shape / (np.linalg.norm(shape, axis=1).max() or 1.0)
        draw_surface(axes, mesh, _RISE * mesh.span * shape, shape[:, 2], 1.0)
    grid.colorbar(1.0, "transverse displacement / largest displacement")
    return grid.figure


def save_modes(
    modes: xr.Dataset, stem: str | os.PathLike[str], count: int = 6, formats: Sequence[str] = ("png", "pdf")
) -> list[Path]:
    """Write the figure of :func:`plot_modes` as ``stem.png`` and ``stem.pdf``; return the files written."""
    return save_figure(plot_modes(modes, count), stem, formats)


def mode_title(modes: xr.Dataset, index: int) -> str:
    """Return e.g. "mode 4   1.99 Hz   (1,2) SA" for a position in a Dataset of modes."""
    one = modes.isel(mode=index)
    number = int(one["mode"]) if "mode" in modes.coords else index + 1
    title = f"mode {number}"
    if "frequency" in modes:
        title += f"   {float(one['frequency']):#.3g}".rstrip(".") + " Hz"
    if "label_m" in modes and int(one["label_m"]) > 0:
        title += f"   ({int(one['label_m'])},{int(one['label_n'])})"
    symmetry = str(one["symmetry"].item()) if "symmetry" in modes else "--"
    return title if symmetry.strip("-") == "" else f"{title} {symmetry}"
