"""The paper's drawings of shapes: Figures 3 (modes), 4 (response) and 7 (dominant shape)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from tautflex.analysis import dominant_shape, mac_table, pod
from tautflex.errors import InputError
from tautflex.paper.cases.run_names import SECTION_3, run_name
from tautflex.plot.modes import mode_title
from tautflex.plot.panels import PanelGrid
from tautflex.plot.style import length_unit, styled
from tautflex.plot.surface import draw_surface, wireframe

Runs = Mapping[str, xr.Dataset]

SECTION_3_RUN = run_name("M2", "pi_5", 1.0, damping=SECTION_3)
INSTANTS = (0.0, 0.04, 0.15, 0.5, 0.6, 0.8, 1.0, 1.2, 1.4, 1.55, 1.85)
"""Instants of panels (b) to (l) [s]; panel (a) is the steady rotation before [paper, Figure 4]."""
MAGNIFICATION = 1000.0
"""Of displacements [paper, section 3]."""
_RISE = 0.1  # largest deflection of a shape without a scale, as a part of the structure's length
_SHAPE_LABEL = "transverse displacement / largest displacement"


@styled
def draw_mode_shapes(runs: Runs, modes: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the first four mode shapes of M2 [paper, Figure 3]."""
    data = modes["M2"]
    count = min(4, data.sizes["mode"])
    mesh = wireframe(data)
    titles = [f"({'abcd'[k]})  {mode_title(data, k)}" for k in range(count)]
    grid = PanelGrid(mesh, _RISE * mesh.span, titles, 2, of=2)
    for k, axes in enumerate(grid.axes):
        shape = data["shape"].isel(mode=k).values
        shape = shape / (np.linalg.norm(shape, axis=1).max() or 1.0)
        draw_surface(axes, mesh, _RISE * mesh.span * shape, shape[:, 2], 1.0)
    grid.colorbar(1.0, _SHAPE_LABEL)
    return grid.figure


@styled
def draw_response_shapes(runs: Runs, modes: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the deflected antenna at twelve instants, displacements times 1000 [paper, Figure 4].

    Panel (a), the steady rotation before the stop, is the state that the run starts from.
    """
    run = runs[SECTION_3_RUN]
    mesh = wireframe(run)
    fields = np.stack([_field_at(run, instant) for instant in (0.0, *INSTANTS)])
    scale, unit = length_unit(fields[..., 2])
    largest = float(np.abs(fields[..., 2]).max())
    words = ["uniform rotation", *(f"$t$ = {instant:g} s" for instant in INSTANTS)]
    titles = [f"({letter})  {word}" for letter, word in zip("abcdefghijkl", words, strict=True)]
    heights = MAGNIFICATION * np.abs(fields[..., 2]).max(axis=1)
    grid = PanelGrid(mesh, list(heights), titles, 4, of=4)
    limit = scale * largest or 1.0
    for axes, field in zip(grid.axes, fields, strict=True):
        draw_surface(axes, mesh, MAGNIFICATION * field, scale * field[:, 2], limit)
    grid.colorbar(limit, f"transverse displacement $w$ [{unit}]  (drawn $\\times$ {MAGNIFICATION:g})")
    return grid.figure


@styled
def draw_dominant_shape(runs: Runs, modes: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the combined shape of the proper orthogonal modes that reach 99 % [paper, Figure 7]."""
    run = runs[SECTION_3_RUN]
    shape = dominant_shape(pod(run))
    fields = run["displacement"].values
    largest = fields[np.square(fields).sum(axis=(1, 2)).argmax()]
    upwards = 1.0 if np.vdot(shape.values, largest) >= 0.0 else -1.0  # as the response goes; a shape has no sign
    best = mac_table(shape, modes["M2"], count=1)
    mesh = wireframe(run)
    count = int(shape.attrs["modes"])
    title = f"{100 * shape.attrs['cumulative']:.1f} % in {count} POM{'s' * (count > 1)};  "
    title += f"MAC with mode {int(best['mode'][0])}: {100 * float(best['mac'][0]):.1f} %"
    grid = PanelGrid(mesh, _RISE * mesh.span, [title], 1, of=2)
    values = upwards * shape.values / (np.abs(shape.values[:, 2]).max() or 1.0)
    draw_surface(grid.axes[0], mesh, _RISE * mesh.span * values, values[:, 2], 1.0)
    grid.colorbar(1.0, _SHAPE_LABEL)
    return grid.figure


def _field_at(run: xr.Dataset, instant: float) -> np.ndarray:
    """Displacement (node, 3) [m] stored next to an instant, or InputError if none is near."""
    stored = run["field_time"].values if "field_time" in run else np.zeros(0)
    slack = 0.02  # [s], a hundredth of the vibration's period at the paper's 2 Hz would not be seen
    if stored.size == 0 or np.abs(stored - instant).min() > slack:
        raise InputError(
            f"{SECTION_3_RUN}: expected a stored field at t = {instant:g} s, got none within {slack:g} s; "
            "list the instants of Figure 4 under output.fields"
        )
    return np.asarray(run["displacement"].values[np.abs(stored - instant).argmin()], dtype=np.float64)
