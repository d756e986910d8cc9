"""Figure of frequency against time, as in the paper's Figure 6."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import NullFormatter
from numpy.typing import ArrayLike

from tautflex.analysis import maneuver_end, scalogram
from tautflex.checks import finite
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.plot.history import probe_records
from tautflex.plot.style import DOUBLE_COLUMN, SEQUENTIAL, length_unit, new_axes, saving, styled
from tautflex.solvers.transient.status import Run

_FADED = 0.05  # the ridge is drawn where it is above this part of its largest value
_COLUMNS = 600  # a page cannot show more


@styled
def plot_scalogram(
    run: xr.Dataset | Run,
    probe: str | None = None,
    component: str = "w",
    frequencies: ArrayLike | None = None,
    bandwidth: float = 3.0,
    floor: float | None = None,
) -> Figure:
    """Draw the complex-Morlet scalogram of a probe with its ridge and its cone of influence.

    Parameters
    ----------
    run
        A run, or its Dataset.
    probe, component
        Record to analyse; None is the probe that moves most.
    frequencies, bandwidth
        As for :func:`tautflex.scalogram`.
    floor
        Colour decibels of the largest value down to this negative number instead of the value itself, so that
        a vibration that dies away stays visible.

    Returns
    -------
    matplotlib.figure.Figure
        Hatched below the cone of influence, where the ends of the record matter; the ridge is drawn where
        it is above 5 % of its largest value, or above ``floor``.

    Raises
    ------
    InputError
        If there is no such probe or component, the record is not uniform, or ``floor`` is not negative.
    """
    records = probe_records(run, None if probe is None else [probe], component)
    record = records.isel(probe=int(np.abs(records.transpose("probe", ...).values).max(axis=1).argmax()))
    probe = str(record["probe"].item())
    data = scalogram(record, frequencies, bandwidth)
    image_values, limits, label = _levels(data["magnitude"], floor, f"amplitude of ${component}$ at {probe}")
    stride = -(-data.sizes["time"] // _COLUMNS)
    shown = data.isel(time=slice(None, None, stride))
    time, frequency = shown["time"].values, shown["frequency"].values
    figure, axes = new_axes(DOUBLE_COLUMN * 0.75, 3.0, "time $t$ [s]", "frequency $f$ [Hz]")
    axes.grid(False)
    look: dict[str, Any] = {"cmap": SEQUENTIAL, "vmin": limits[0], "vmax": limits[1], "shading": "gouraud"}
    image = axes.pcolormesh(time, frequency, image_values[:, ::stride], rasterized=True, **look)
    faded = _FADED if floor is None else 10.0 ** (floor / 20.0)
    visible = shown["ridge_magnitude"].values > faded * float(data["ridge_magnitude"].max())
    free = shown["ridge"].values >= shown["cone_of_influence"].values
    ridge = np.where(visible, shown["ridge"].values, np.nan)
    outline = [withStroke(linewidth=2.2, foreground="black")]
    axes.plot(time, ridge, ":", color="white", linewidth=1.2, path_effects=outline)
    ridge[~free] = np.nan
    axes.plot(time, ridge, color="white", linewidth=1.2, path_effects=outline, label="ridge" if visible.any() else None)
    cone = np.minimum(shown["cone_of_influence"].values, frequency[-1])
    axes.fill_between(
        time, frequency[0], cone, facecolor="none", edgecolor="white", linewidth=0.0, hatch="////", alpha=0.35
    )
    end = maneuver_end(run)
    if end is not None:
        axes.axvline(end, color="white", linewidth=0.8, linestyle=(0, (4, 2)), label="maneuver ends")
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    ticks = [tick for tick in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100) if frequency[0] <= tick <= frequency[-1]]
    axes.set_yticks(ticks)
    axes.set_ylim(frequency[0], frequency[-1])
    axes.set_xlim(time[0], time[-1])
    figure.colorbar(image, ax=axes, pad=0.02).set_label(label)
    if end is not None or visible.any():
        axes.legend(loc="upper right", facecolor="#333333", labelcolor="white", framealpha=0.7)
    return figure


save_scalogram = saving(plot_scalogram)


def _levels(magnitude: xr.DataArray, floor: float | None, label: str) -> tuple[Array, tuple[float, float], str]:
    """Values to colour, their limits and their label, in a length or in decibels."""
    if floor is None:
        scale, unit = length_unit(magnitude.values)
        values = scale * magnitude.values
        return values, (0.0, float(values.max()) or 1.0), f"{label} [{unit}]"
    if not finite("floor", floor) < 0.0:
        raise InputError(f"floor: expected a negative number of decibels, got {floor!r}; -40 shows a hundredth")
    largest = float(magnitude.max()) or 1.0
    decibels = 20.0 * np.log10(np.maximum(magnitude.values / largest, 10.0 ** (floor / 20.0)))
    return decibels, (floor, 0.0), f"{label} [dB of largest]"
