"""Figure of a closed loop: attitude, rate, commands, tensions, surface and energy over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tautflex.analysis import maneuver_end
from tautflex.motion.rotations import rotation_vectors
from tautflex.numeric import Array
from tautflex.plot.style import COLORS, DOUBLE_COLUMN, GREY, length_unit, new_figure, saving, styled
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import LOOP, dataset_of

_ROW = 1.15  # height of a panel [inch]
# Part of the largest component below which another one is not drawn.
_SMALL = 1e-3


class _Panel(NamedTuple):
    """Curves (time, n) over one axis, what they were to follow, and a level to mark on a logarithmic scale."""

    label: str
    time: Array
    curves: Array
    names: Sequence[str] = ()
    wanted: Array | None = None
    asked: Array | None = None
    held: bool = False
    logarithmic: bool = False
    level: float | None = None


@styled
def plot_loop(run: xr.Dataset | Run) -> Figure:
    """Draw what went through a closed loop, one panel each over the same time.

    Attitude and rate of a free hub with what it was to follow (dashed) and the angle between the two; commands and
    measured tensions by unit; the film's rms about its best plane; the work of every actuator.

    Parameters
    ----------
    run
        A run of `close_loop`, or its Dataset.

    Returns
    -------
    matplotlib.figure.Figure
        The maneuver that is followed is shaded.

    Raises
    ------
    InputError
        If the run is of no closed loop.
    """
    remedy = "close_loop(plant, law, ...) gives one"
    data = dataset_of("run", run, "command", "measurement", "source_work", remedy=remedy, table=LOOP)
    panels = list(_panels(data))
    figure = new_figure(DOUBLE_COLUMN, _ROW * len(panels) + 0.3)
    rows = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    end, first, last = maneuver_end(data), float(data["time"][0]), float(data["time"][-1])
    for axes, panel in zip(rows, panels, strict=True):
        _draw(axes, panel)
        if end is not None and first < end < last:
            axes.axvspan(max(first, 0.0), end, color="#eeeeee", zorder=0)
    rows[-1].set_xlabel("time $t$ [s]")
    rows[-1].set_xlim(first, last if last > first else first + 1.0)
    figure.align_ylabels(rows)
    return figure


save_loop = saving(plot_loop)


def _panels(data: xr.Dataset) -> Iterator[_Panel]:
    time, sampled = data["time"].values, data["sample_time"].values
    if "attitude_error" in data:
        turned = rotation_vectors(data["attitude"].values)
        yield _against("attitude [rad]", time, turned, data, "attitude")
        yield _against("rate [rad/s]", time, data["angular_velocity"].values, data, "rate")
        level = data.attrs.get("attitude_tolerance")
        error = data["attitude_error"].values[:, None]
        yield _Panel("error [rad]", sampled, error, logarithmic=True, level=level)
    commands, units = data["command"], data["command"].attrs["channel_units"]
    for unit in dict.fromkeys(units):
        mine = [k for k, one in enumerate(units) if one == unit]
        names = [str(data["input"].values[k]) for k in mine]
        yield _Panel(f"command [{unit}]", sampled, commands.values[:, mine], names, held=True)
    measured = [k for k, unit in enumerate(data["measurement"].attrs["channel_units"]) if unit == "N"]
    if measured:
        names = [str(data["output"].values[k]) for k in measured]
        yield _Panel("tension [N]", sampled, data["measurement"].values[:, measured], names)
    rms = data["surface_rms"].values
    if np.isfinite(rms).any():
        scale, unit = length_unit(rms)
        level = data.attrs.get("surface_tolerance")
        level = None if level is None else scale * level
        yield _Panel(f"film rms [{unit}]", time, scale * rms[:, None], logarithmic=True, level=level)
    if data.sizes["source"]:
        names = [str(name) for name in data["source"].values]
        yield _Panel("work [J]", sampled, data["source_work"].values, names)


def _against(label: str, time: Array, curves: Array, data: xr.Dataset, asked: str) -> _Panel:
    """Components of a vector that move, and what they were to follow."""
    wanted = np.full((data.sizes["sample_time"], 3), np.nan)
    wanted[:, ["xyz".index(axis) for axis in data["axis"].values]] = data["reference"].sel(asked=asked).values
    sizes = np.maximum(np.abs(curves).max(axis=0), np.nan_to_num(np.abs(wanted)).max(axis=0))
    kept = np.flatnonzero(sizes >= _SMALL * sizes.max())
    return _Panel(label, time, curves[:, kept], ["xyz"[k] for k in kept], wanted[:, kept], data["sample_time"].values)


def _draw(axes: Axes, panel: _Panel) -> None:
    axes.set_ylabel(panel.label)
    for k, (curve, color) in enumerate(zip(panel.curves.T, cycle(COLORS), strict=False)):
        name = panel.names[k] if k < len(panel.names) else None
        axes.plot(panel.time, curve, color=color, label=name, drawstyle="steps-post" if panel.held else "default")
        if panel.asked is not None and panel.wanted is not None and np.isfinite(panel.wanted[:, k]).any():
            label = "to follow" if k + 1 == panel.curves.shape[1] else None
            axes.plot(panel.asked, panel.wanted[:, k], "--", color=GREY, label=label)
    largest = float(np.nanmax(np.abs(panel.curves), initial=0.0))
    if panel.level is not None:
        axes.axhline(panel.level, color=GREY, linewidth=0.8, linestyle=":", label=f"settled below {panel.level:.3g}")
    if panel.logarithmic and largest > 0.0:
        axes.set_yscale("log")
        low = float(np.nanmin(np.where(panel.curves > 0.0, panel.curves, np.nan)))
        axes.set_ylim(max(0.5 * low, 1e-5 * largest), 30.0 * max(largest, panel.level or 0.0))
    elif panel.names:
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.35 * (high - low))  # keeps the legend's line free of curves
    if panel.names or panel.level is not None:
        axes.legend(loc="upper right", ncols=4)
