"""The paper's time histories of point A: Figures 5 and 8 to 11, and its time-frequency graph, Figure 6."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from tautflex.analysis import maneuver_end
from tautflex.paper.cases.normal_modes import dominant_mode, frequency_of
from tautflex.paper.cases.run_names import maneuver_words, run_name
from tautflex.paper.figures.drawings import SECTION_3_RUN
from tautflex.paper.tables.paper_tables import POINT
from tautflex.plot.style import COLORS, GREY, SINGLE_COLUMN, length_unit, new_axes, new_figure, styled
from tautflex.plot.timefrequency import plot_scalogram

Runs = Mapping[str, xr.Dataset]
Modes = Mapping[str, xr.Dataset]
Draw = Callable[[Runs, Modes], Figure]
Drawing = tuple[tuple[str, ...], Draw]
"""Names of the runs that a figure needs, and the function of runs by name and modes by model that draws it."""

_HEIGHT = 2.2  # [inch], without a legend
_DASHES = (0, (4, 2))
_FLOOR = -40.0  # [dB]
_FREQUENCIES = np.geomspace(0.8, 4.0, 120)  # [Hz], an octave about the 2 Hz of the mode that the stop excites
_DETAILS = 4.0  # [s]


def history(labels: Mapping[str, str], title: str, details: bool = False) -> Drawing:
    """Return the runs and the drawing of w of point A of some runs.

    With ``details`` the beginning, cut off at what suits all but the first run.
    """
    return tuple(labels), partial(_histories, labels, title, details)


def damped_history(letter: str, rate: str, damping: str = "") -> Drawing:
    """Return one run of M2 stopped in 1 s, at the weak damping of section 4 or another one [paper, Figure 5]."""
    words = rf"$\alpha$ = $\beta$ = {damping.removeprefix('damping') or '0.001'}"
    name = run_name("M2", rate, 1.0, damping=damping)
    return history({name: ""}, f"({letter})  {maneuver_words(rate, 1.0)}, {words}")


@styled
def draw_ridge(runs: Runs, modes: Modes) -> Figure:
    """Draw frequency against time of M2 at pi/5, with the ridge of the scalogram [paper, Figure 6].

    The deceleration holds the film off its plane; the vibration is the motion about the mean during the stop,
    and about the mean after it. Dotted: natural frequency of the mode (1,2).
    """
    run = runs[SECTION_3_RUN]
    vibration = run.assign(w=about_equilibrium(run["w"], maneuver_end(run)))
    figure = plot_scalogram(vibration, POINT, frequencies=_FREQUENCIES, floor=_FLOOR)
    figure.set_size_inches(SINGLE_COLUMN, 2.7)
    axes = figure.axes[0]
    axes.axhline(frequency_of(modes["M2"], dominant_mode(modes["M2"])), color="white", linewidth=0.9, linestyle=":")
    axes.set_yticks([1.0, 2.0, 3.0, 4.0])
    return figure


def about_equilibrium(record: xr.DataArray, end: float | None) -> xr.DataArray:
    """Return a record less its mean before and its mean after an instant [s], or less its mean."""
    during = record["time"] < (0.0 if end is None else end)
    middle = record.where(~during).mean("time")
    if bool(during.any()):
        middle = record.where(during).mean("time") * during + middle * ~during
    return (record - middle).transpose(*record.dims).assign_attrs(record.attrs)


@styled
def _histories(labels: Mapping[str, str], title: str, details: bool, runs: Runs, modes: Modes) -> Figure:
    records = {run: runs[run]["w"].sel(probe=POINT) for run in labels}
    if len(records) > 1 and not details:
        return _stacked(labels, title, runs, records)
    scale, unit = length_unit(np.concatenate([record.values for record in records.values()]))
    tops = [float(np.abs(record).max()) for record in records.values()]
    largest = 1.2 * max(tops[1:]) if details else math.inf
    figure, axes = new_axes(SINGLE_COLUMN, _HEIGHT, "time $t$ [s]", f"displacement $w_A$ [{unit}]")
    for k, (run, record) in enumerate(records.items()):
        alpha, zorder = (0.45, 1.5) if tops[k] > largest else (1.0, 2.0)
        look: dict[str, Any] = {"color": COLORS[k], "linewidth": 0.9, "alpha": alpha, "zorder": zorder}
        axes.plot(record["time"], scale * record, label=labels[run], **look)
    _mark_ends(axes, [maneuver_end(runs[run]) for run in labels])
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=1)
    last = max(float(record["time"][-1]) for record in records.values())
    axes.set_xlim(0.0, min(_DETAILS, last) if details else last)
    if details:
        axes.set_ylim(-scale * largest, scale * largest)
    axes.set_title(title, fontsize=8, loc="left")
    if len(labels) > 1:
        _legend(figure, axes)
    return figure


def _stacked(labels: Mapping[str, str], title: str, runs: Runs, records: Mapping[str, xr.DataArray]) -> Figure:
    """Draw runs one below the other, each to a scale of its own, over one time: on one another they hide each other."""
    figure = new_figure(SINGLE_COLUMN, 0.5 + 0.85 * len(records))
    panels = figure.subplots(len(records), sharex=True)
    scale, unit = length_unit(np.concatenate([record.values for record in records.values()]))
    for k, (axes, (run, record)) in enumerate(zip(panels, records.items(), strict=True)):
        axes.plot(record["time"], scale * record, color=COLORS[k], linewidth=0.9)
        axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=1)
        if k == 0:  # words stand above a stop so short that the largest peak is beside them
            axes.margins(y=0.25)
        _mark_ends(axes, [maneuver_end(runs[run])], words=k == 0)
        axes.yaxis.set_major_locator(MaxNLocator(4))
        place: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
        axes.annotate(labels[run], (1.0, 1.0), (-4.0, -4.0), ha="right", va="top", fontsize=8, **place)
    panels[0].set_title(title, fontsize=8, loc="left")
    panels[-1].set(xlabel="time $t$ [s]", xlim=(0.0, max(float(record["time"][-1]) for record in records.values())))
    figure.supylabel(f"displacement $w_A$ [{unit}]", fontsize=9)
    return figure


def _mark_ends(axes: Axes, ends: Sequence[float | None], words: bool = True) -> None:
    """Dash the end of each run's stop, in grey where all share it."""
    shared = len(set(ends)) == 1
    for k, end in enumerate(ends[:1] if shared else ends):
        if end is None:
            continue
        color = GREY if shared else COLORS[k]
        axes.axvline(end, color=color, linewidth=0.7, linestyle=_DASHES, zorder=1)
        if len(ends) == 1 and words:
            frames: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "textcoords": "offset points"}
            axes.annotate("end of stop", (end, 1.0), (3.0, -3.0), fontsize=8, color=GREY, va="top", **frames)


def _legend(figure: Figure, axes: Axes) -> None:
    """Explain the lines under the drawing, in as many rows as the words need."""
    handles, words = axes.get_legend_handles_labels()
    handles.append(Line2D([], [], color=GREY, linewidth=0.7, linestyle=_DASHES))
    words.append("end of stop")
    columns = len(words) if sum(len(word) for word in words) < 80 else 2
    figure.set_size_inches(SINGLE_COLUMN, _HEIGHT + 0.2 * -(-len(words) // columns))
    spaces = {"handlelength": 1.2, "handletextpad": 0.5, "columnspacing": 1.0}
    figure.legend(handles, words, loc="outside lower center", ncols=columns, **spaces)
