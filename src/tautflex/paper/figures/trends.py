"""The paper's trends: response frequency (Figure 12) and amplitude (Figure 13) against the maneuver."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator

from tautflex.paper.cases.normal_modes import dominant_mode, frequency_of
from tautflex.paper.cases.run_names import DURATIONS, MODELS, RATE_SYMBOLS, RATES, run_name
from tautflex.paper.figures.histories import Drawing
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import response
from tautflex.plot.style import COLORS, GREY, SINGLE_COLUMN, new_axes, styled

_SHORT = DURATIONS[0]
RATE_TREND: dict[str, dict[float, str]] = {  # the paper has pi/50 for M1 only [paper, Table 9]
    model: {RATES[rate]: run_name(model, rate, _SHORT) for rate in RATES if rate != "pi_50" or model == "M1"}
    for model in MODELS
}
DURATION_TREND = {model: {duration: run_name(model, "pi_5", duration) for duration in DURATIONS} for model in MODELS}
_MARKERS = {"M1": "o", "M2": "s", "M3": "^"}
_SIZE, _OPEN_SIZE = 4.5, 7.5  # of markers [points]: ours fit inside the paper's
_APART = 1.1  # factor between the places of models on a logarithmic axis
_OPEN: dict[str, Any] = {"markersize": _OPEN_SIZE, "markerfacecolor": "none", "markeredgewidth": 1.2}
_OURS: dict[str, Any] = {"linestyle": ":", "linewidth": 1.2}  # lines of natural frequencies
_PAPER: dict[str, Any] = {"linestyle": (0, (1, 5)), "linewidth": 0.9}


def trend(quantity: str, along: str) -> Drawing:
    """Return the runs and the drawing of ``"frequency"`` or ``"amplitude"`` along ``"rate"`` or ``"duration"``."""
    cases = RATE_TREND if along == "rate" else DURATION_TREND
    return tuple(name for names in cases.values() for name in names.values()), partial(_draw, quantity, along, cases)


@styled
def _draw(
    quantity: str,
    along: str,
    cases: Mapping[str, Mapping[float, str]],
    runs: Mapping[str, xr.Dataset],
    modes: Mapping[str, xr.Dataset],
) -> Figure:
    number, key, label = _QUANTITIES[quantity]
    figure, axes = new_axes(SINGLE_COLUMN, 2.9, "", label)
    legend = []
    for k, (model, names) in enumerate(cases.items()):
        printed = _printed(model, along)
        ours = [response(runs[name], printed.get(x, _DEFAULT)["padded_duration"])[number] for x, name in names.items()]
        look: dict[str, Any] = {"color": COLORS[k], "marker": _MARKERS[model]}
        # Models stand side by side, so that no marker hides another.
        place = partial(np.multiply, _APART ** (k - 1)) if along == "rate" else partial(np.add, 0.04 * (k - 1))
        axes.plot(place(list(names)), ours, "-", markersize=_SIZE, **look)
        values = [row[key] for row in printed.values()]
        axes.plot(place(list(printed)), values, linestyle="none", zorder=4, **look, **_OPEN)
        legend.append(Line2D([], [], markersize=_SIZE, label=model, **look))
    legend.append(Line2D([], [], color=GREY, marker="o", linestyle="none", label="paper, Tables 6–9", **_OPEN))  # noqa: RUF001
    if quantity == "frequency":
        _draw_dominant_modes(axes, modes)
        for whose, look in (("ours", _OURS), ("paper", _PAPER)):
            legend.append(Line2D([], [], color=GREY, label=f"mode (1,2), {whose}", **look))
        axes.set_ylim(bottom=0.0)
    else:
        axes.set_yscale("log")
        axes.margins(y=0.1)
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter("{x:g}")
    if along == "rate":  # angular velocities are decades apart
        title, words = "(a)  $T$ = 0.1 s", r"initial angular velocity $\omega_0$ [rad/s]"
        axes.set_xscale("log")
        axes.set_xticks(list(RATES.values()), list(RATE_SYMBOLS.values()))
        axes.xaxis.set_minor_locator(NullLocator())
    else:
        title, words = rf"(b)  $\omega_0$ = {RATE_SYMBOLS['pi_5']} rad/s", "duration of the stop $T$ [s]"
        axes.set_xticks(DURATIONS, [f"{duration:g}" for duration in DURATIONS])
    axes.set(xlabel=words, xlim=(0.025, 2.0) if along == "rate" else (0.0, 2.1))
    axes.set_title(title, fontsize=8, loc="left")
    figure.legend(handles=legend, loc="outside lower center", ncols=2 if len(legend) > 4 else 4, columnspacing=1.0)
    return figure


_QUANTITIES = {  # place in what `response` returns, key of the printed tables, label
    "frequency": (0, "response_frequency", "response frequency [Hz]"),
    "amplitude": (2, "amplitude", "amplitude of $w_A$ [mm]"),
}
_DEFAULT = published.table(6)[0]  # its padded duration is that of runs which no table prints


def _printed(model: str, along: str) -> dict[float, dict[str, Any]]:
    """Rows of Tables 6 to 9 on the curve of a model, by place along the axis."""
    key, value = ("duration", _SHORT) if along == "rate" else ("rate", RATES["pi_5"])
    rows = [row for number in published.RESPONSE_TABLES for row in published.table(number)]
    return {row[along]: row for row in rows if row["model"] == model and math.isclose(row[key], value)}


def _draw_dominant_modes(axes: Axes, modes: Mapping[str, xr.Dataset]) -> None:
    printed = {row["model"]: row["dominant_frequency"] for row in published.table(4)}
    for k, model in enumerate(MODELS):
        axes.axhline(frequency_of(modes[model], dominant_mode(modes[model])), color=COLORS[k], **_OURS)
        axes.axhline(printed[model], color=COLORS[k], **_PAPER)
