"""The paper's time histories of point A: Figures 5 and 8 to 11, and its time-frequency graph, Figure 6."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from tautflex.analysis import maneuver_end
from tautflex.paper.cases.normal_modes import dominant_mode, frequency_of
from tautflex.paper.cases.run_names import (
    DURATIONS,
    MODELS,
    RATE_SYMBOLS,
    SECTION_3,
    maneuver_words,
    run_name,
)
from tautflex.plot.style import COLORS, GREY, SINGLE_COLUMN, length_unit, new_figure, styled
from tautflex.plot.timefrequency import plot_scalogram

Runs = Mapping[str, xr.Dataset]
Modes = Mapping[str, xr.Dataset]

POINT = "A"
FIGURE_5 = {
    "5a": run_name("M2", "pi_5", 1.0, damping=SECTION_3),
    "5b": run_name("M2", "pi_5", 1.0),
    "5c": run_name("M2", "pi_2", 1.0),
}
FIGURE_8 = {run_name(model, "pi_100", 0.1): model for model in MODELS}
FIGURE_9 = {run_name("M3", "pi_5", duration): f"$T$ = {duration:g} s" for duration in DURATIONS}
FIGURE_10 = {run_name("M1", rate, 0.1): rf"$\omega_0$ = {RATE_SYMBOLS[rate]}" for rate in ("pi_2", "pi_5", "pi_100")}
FIGURE_11 = {
    run_name("M1", rate, duration): maneuver_words(rate, duration) for rate, duration in (("pi_5", 1.0), ("pi_50", 0.1))
}
_HEIGHT = 2.2  # [inch], without a legend
_DASHES = (0, (4, 2))
_FLOOR = -40.0  # [dB]
_FREQUENCIES = np.geomspace(0.8, 4.0, 120)  # [Hz], an octave about the 2 Hz of the mode that the stop excites


@styled
def draw_5a(runs: Runs, modes: Modes) -> Figure:
    """Draw M2 at pi/5 with the strong damping of section 3 [paper, Figure 5a]."""
    return _histories(runs, {FIGURE_5["5a"]: ""}, f"(a)  {maneuver_words('pi_5', 1.0)}, {_damping('0.01')}")


@styled
def draw_5b(runs: Runs, modes: Modes) -> Figure:
    """Draw M2 at pi/5 with weak damping [paper, Figure 5b]."""
    return _histories(runs, {FIGURE_5["5b"]: ""}, f"(b)  {maneuver_words('pi_5', 1.0)}, {_damping('0.001')}")


@styled
def draw_5c(runs: Runs, modes: Modes) -> Figure:
    """Draw M2 at pi/2 with weak damping [paper, Figure 5c]."""
    return _histories(runs, {FIGURE_5["5c"]: ""}, f"(c)  {maneuver_words('pi_2', 1.0)}, {_damping('0.001')}")


@styled
def draw_6(runs: Runs, modes: Modes) -> Figure:
    """Draw frequency against time of M2 at pi/5, with the ridge of the scalogram [paper, Figure 6].

    The deceleration holds the film off its plane; the vibration is the motion about the mean during the stop,
    and about the mean after it. Dotted: natural frequency of the mode (1,2).
    """
    run = runs[FIGURE_5["5a"]]
    vibration = run.assign(w=about_equilibrium(run["w"], maneuver_end(run)))
    figure = plot_scalogram(vibration, POINT, frequencies=_FREQUENCIES, floor=_FLOOR)
    figure.set_size_inches(SINGLE_COLUMN, 2.7)
    axes = figure.axes[0]
    axes.axhline(frequency_of(modes["M2"], dominant_mode(modes["M2"])), color="white", linewidth=0.9, linestyle=":")
    axes.set_yticks([1.0, 2.0, 3.0, 4.0])
    return figure


@styled
def draw_8(runs: Runs, modes: Modes) -> Figure:
    """Draw M1 to M3 after the same stop [paper, Figure 8]."""
    return _histories(runs, FIGURE_8, maneuver_words("pi_100", 0.1))


@styled
def draw_9a(runs: Runs, modes: Modes) -> Figure:
    """Draw M3 after stops of different duration [paper, Figure 9a]."""
    return _histories(runs, FIGURE_9, rf"(a)  M3, $\omega_0$ = {RATE_SYMBOLS['pi_5']} rad/s")


@styled
def draw_9b(runs: Runs, modes: Modes) -> Figure:
    """Draw the beginning of Figure 9a to the scale of the two slower stops [paper, Figure 9b]."""
    slow = [run for run, label in FIGURE_9.items() if run != run_name("M3", "pi_5", DURATIONS[0])]
    largest = max(float(np.abs(runs[run]["w"].sel(probe=POINT)).max()) for run in slow)
    title = rf"(b)  details, M3, $\omega_0$ = {RATE_SYMBOLS['pi_5']} rad/s"
    return _histories(runs, FIGURE_9, title, span=4.0, largest=1.2 * largest)


@styled
def draw_10(runs: Runs, modes: Modes) -> Figure:
    """Draw M1 after equally long stops from different rates [paper, Figure 10]."""
    return _histories(runs, FIGURE_10, r"M1, $T$ = 0.1 s, $\omega_0$ [rad/s]")


@styled
def draw_11(runs: Runs, modes: Modes) -> Figure:
    """Draw M1 after two stops of equal deceleration [paper, Figure 11]."""
    return _histories(runs, FIGURE_11, "M1, equal deceleration")


def about_equilibrium(record: xr.DataArray, end: float | None) -> xr.DataArray:
    """Return a record less its mean before and its mean after an instant [s], or less its mean."""
    during = record["time"] < (0.0 if end is None else end)
    middle = record.where(~during).mean("time")
    if bool(during.any()):
        middle = record.where(during).mean("time") * during + middle * ~during
    return (record - middle).transpose(*record.dims).assign_attrs(record.attrs)


def _damping(value: str) -> str:
    return rf"$\alpha$ = $\beta$ = {value}"


def _histories(
    runs: Runs,
    labels: Mapping[str, str],
    title: str,
    span: float | None = None,
    largest: float | None = None,
) -> Figure:
    """Draw w of point A of some runs, up to a time [s] and, if ``largest`` [m] is given, cut off beyond it."""
    records = {run: runs[run]["w"].sel(probe=POINT) for run in labels}
    scale, unit = length_unit(np.concatenate([record.values for record in records.values()]))
    figure = new_figure(SINGLE_COLUMN, _HEIGHT)
    axes = figure.add_subplot()
    for k, (run, record) in enumerate(records.items()):
        cut = largest is not None and float(np.abs(record).max()) > largest
        axes.plot(
            record["time"],
            scale * record,
            color=COLORS[k],
            linewidth=0.9,
            label=labels[run],
            alpha=0.45 if cut else 1.0,
            zorder=1.5 if cut else 2.0,
        )
    _mark_ends(axes, [maneuver_end(runs[run]) for run in labels])
    axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=1)
    last = max(float(record["time"][-1]) for record in records.values())
    axes.set_xlim(0.0, last if span is None else min(span, last))
    if largest is not None:
        axes.set_ylim(-scale * largest, scale * largest)
    axes.set_xlabel("time $t$ [s]")
    axes.set_ylabel(f"displacement $w_A$ [{unit}]")
    axes.set_title(title, fontsize=8, loc="left")
    if len(labels) > 1:
        _legend(figure, axes)
    return figure


def _mark_ends(axes: Axes, ends: Sequence[float | None]) -> None:
    """Dash the end of each run's stop, in grey where all share it."""
    shared = len(set(ends)) == 1
    for k, end in enumerate(ends[:1] if shared else ends):
        if end is None:
            continue
        color = GREY if shared else COLORS[k]
        axes.axvline(end, color=color, linewidth=0.7, linestyle=_DASHES, zorder=1)
        if len(ends) == 1:
            axes.annotate(
                "end of stop",
                (end, 1.0),
                (3.0, -3.0),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                fontsize=8,
                color=GREY,
                va="top",
            )


def _legend(figure: Figure, axes: Axes) -> None:
    """Explain the lines under the drawing, in as many rows as the words need."""
    handles, words = axes.get_legend_handles_labels()
    handles.append(Line2D([], [], color=GREY, linewidth=0.7, linestyle=_DASHES))
    words.append("end of stop")
    columns = len(words) if sum(len(word) for word in words) < 80 else 2
    figure.set_size_inches(SINGLE_COLUMN, _HEIGHT + 0.2 * -(-len(words) // columns))
    figure.legend(
        handles,
        words,
        loc="outside lower center",
        ncols=columns,
        handlelength=1.2,
        handletextpad=0.5,
        columnspacing=1.0,
    )
