"""The paper's drawings of shapes: Figures 3 (modes), 4 (response) and 7 (dominant shape)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from tautflex.analysis import dominant_shape, mac_table, pod
from tautflex.errors import InputError
from tautflex.paper.cases.run_names import SECTION_3, run_name
from tautflex.plot.modes import draw_modes, mode_title
from tautflex.plot.panels import draw_deflections, draw_shapes
from tautflex.plot.style import styled
from tautflex.plot.surface import wireframe

Runs = Mapping[str, xr.Dataset]

SECTION_3_RUN = run_name("M2", "pi_5", 1.0, damping=SECTION_3)
INSTANTS = (0.0, 0.04, 0.15, 0.5, 0.6, 0.8, 1.0, 1.2, 1.4, 1.55, 1.85)
"""Instants of panels (b) to (l) [s]; panel (a) is the steady rotation before [paper, Figure 4]."""
MAGNIFICATION = 1000.0
"""Of displacements [paper, section 3]."""


@styled
def draw_mode_shapes(runs: Runs, modes: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the first four mode shapes of M2 [paper, Figure 3]."""
    data = modes["M2"]
    return draw_modes(data, [f"({letter})  {mode_title(data, k)}" for k, letter in enumerate("abcd")], 2)


@styled
def draw_response_shapes(runs: Runs, modes: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the deflected antenna at twelve instants, displacements times 1000 [paper, Figure 4].

    Panel (a), the steady rotation before the stop, is the state that the run starts from.
    """
    run = runs[SECTION_3_RUN]
    fields = np.stack([_field_at(run, instant) for instant in (0.0, *INSTANTS)])
    words = ["uniform rotation", *(f"$t$ = {instant:g} s" for instant in INSTANTS)]
    titles = [f"({letter})  {word}" for letter, word in zip("abcdefghijkl", words, strict=True)]
    return draw_deflections(wireframe(run), titles, fields, MAGNIFICATION, 4, level=False)


@styled
def draw_dominant_shape(runs: Runs, modes: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the combined shape of the proper orthogonal modes that reach 99 % [paper, Figure 7]."""
    run = runs[SECTION_3_RUN]
    shape = dominant_shape(pod(run))
    fields = run["displacement"].values
    largest = fields[np.square(fields).sum(axis=(1, 2)).argmax()]
    upwards = 1.0 if np.vdot(shape.values, largest) >= 0.0 else -1.0  # as the response goes; a shape has no sign
    best = mac_table(shape, modes["M2"], count=1)
    count = int(shape.attrs["modes"])
    title = f"{100 * shape.attrs['cumulative']:.1f} % in {count} POM{'s' * (count > 1)};  "
    title += f"MAC with mode {int(best['mode'][0])}: {100 * float(best['mac'][0]):.1f} %"
    values = upwards * shape.values / (np.abs(shape.values[:, 2]).max() or 1.0)
    return draw_shapes(wireframe(run), [title], values[None], 1)


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
