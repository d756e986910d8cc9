"""The paper's trends: response frequency (Figure 12) and amplitude (Figure 13) against the maneuver."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

from tautflex.analysis import amplitude, dominant_frequency, maneuver_end
from tautflex.paper.cases.normal_modes import dominant_mode, frequency_of
from tautflex.paper.cases.run_names import (
    DURATIONS,
    MODELS,
    RATE_SYMBOLS,
    RATES,
    run_name,
)
from tautflex.paper.tables import published
from tautflex.plot.style import COLORS, GREY, SINGLE_COLUMN, new_figure, styled

Runs = Mapping[str, xr.Dataset]
Modes = Mapping[str, xr.Dataset]

POINT = "A"
_SHORT = DURATIONS[0]
RATE_TREND: dict[str, dict[float, str]] = {  # the paper has pi/50 for M1 only [paper, Table 9]
    model: {RATES[rate]: run_name(model, rate, _SHORT) for rate in RATES if rate != "pi_50" or model == "M1"}
    for model in MODELS
}
DURATION_TREND = {model: {duration: run_name(model, "pi_5", duration) for duration in DURATIONS} for model in MODELS}
_MARKERS = {"M1": "o", "M2": "s", "M3": "^"}
_SIZE, _OPEN_SIZE = 4.5, 7.5  # of markers [points]: ours fit inside the paper's
_OPEN: dict[str, Any] = {"markersize": _OPEN_SIZE, "markerfacecolor": "none", "markeredgewidth": 1.2}
_OURS: Literal[":"] = ":"
_PAPER = (0, (1, 5))  # lines of natural frequencies


class Trend(NamedTuple):
    """One curve: where its points stand, ours at every one, the paper's where it prints them."""

    x: Sequence[float]
    ours: Sequence[float]
    printed: Mapping[float, float]


Cases = Mapping[float, str]
Measure = Callable[[xr.Dataset, float], float]


@styled
def draw_12a(runs: Runs, modes: Modes) -> Figure:
    """Draw response frequency against initial angular velocity [paper, Figure 12a]."""
    return _finished_frequency(_against_rate(runs, "response_frequency"), modes)


@styled
def draw_12b(runs: Runs, modes: Modes) -> Figure:
    """Draw response frequency against the duration of the stop [paper, Figure 12b]."""
    return _finished_frequency(_against_duration(runs, "response_frequency"), modes)


@styled
def draw_13a(runs: Runs, modes: Modes) -> Figure:
    """Draw amplitude against initial angular velocity [paper, Figure 13a]."""
    return _finished_amplitude(_against_rate(runs, "amplitude"))


@styled
def draw_13b(runs: Runs, modes: Modes) -> Figure:
    """Draw amplitude against the duration of the stop [paper, Figure 13b]."""
    return _finished_amplitude(_against_duration(runs, "amplitude"))


def response_frequency(run: xr.Dataset, padded: float) -> float:
    """Return the dominant frequency [Hz] of point A after the stop, on the bins of a padded record [s]."""
    return dominant_frequency(run["w"].sel(probe=POINT), length=padded, after=maneuver_end(run)).frequency


def response_amplitude(run: xr.Dataset, padded: float) -> float:
    """Return the largest displacement of point A [mm]; it does not depend on the padding."""
    return 1e3 * amplitude(run["w"].sel(probe=POINT))


_QUANTITIES: dict[str, tuple[str, Measure]] = {
    "response_frequency": ("response frequency [Hz]", response_frequency),
    "amplitude": ("amplitude of $w_A$ [mm]", response_amplitude),
}


def _trends(
    runs: Runs, cases: Mapping[str, Cases], quantity: str, along: str, fixed: tuple[str, float]
) -> dict[str, Trend]:
    """Curve of every model along ``"rate"`` or ``"duration"``, the other one of the two being fixed."""
    measure = _QUANTITIES[quantity][1]
    printed = {model: _printed(model, quantity, along, fixed) for model in cases}
    default = float(published.about(6)["padded_duration"])
    trends = {}
    for model, names in cases.items():
        values = [measure(runs[name], printed[model].get(x, (0.0, default))[1]) for x, name in names.items()]
        trends[model] = Trend(list(names), values, {x: value for x, (value, _) in printed[model].items()})
    return trends


def _printed(model: str, quantity: str, along: str, fixed: tuple[str, float]) -> dict[float, tuple[float, float]]:
    """Value and padded duration [s] of the runs of a model in Tables 6 to 9, by place along the axis."""
    key, value = fixed
    return {
        entry[along]: (entry[quantity], float(published.about(number)["padded_duration"]))
        for number in published.RESPONSE_TABLES
        for entry in published.table(number)
        if entry["model"] == model and math.isclose(entry[key], value)
    }


def _drawn(title: str, quantity: str, trends: Mapping[str, Trend]) -> Axes:
    axes = new_figure(SINGLE_COLUMN, 2.9).add_subplot()
    axes.set_title(title, fontsize=8, loc="left")
    axes.set_ylabel(_QUANTITIES[quantity][0])
    for k, (model, trend) in enumerate(trends.items()):
        look: dict[str, Any] = {"color": COLORS[k], "marker": _MARKERS[model]}
        axes.plot(trend.x, trend.ours, "-", markersize=_SIZE, **look)
        axes.plot(list(trend.printed), list(trend.printed.values()), linestyle="none", zorder=4, **look, **_OPEN)
    return axes


def _against_rate(runs: Runs, quantity: str) -> Axes:
    """Angular velocities are decades apart: logarithmic, with the paper's values as ticks."""
    trends = _trends(runs, RATE_TREND, quantity, "rate", ("duration", _SHORT))
    axes = _drawn("(a)  $T$ = 0.1 s", quantity, trends)
    axes.set_xscale("log")
    axes.set_xlim(0.025, 2.0)
    names = {value: RATE_SYMBOLS[name] for name, value in RATES.items()}
    axes.xaxis.set_major_locator(FixedLocator(list(names)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: names.get(value, "")))
    axes.set_xlabel(r"initial angular velocity $\omega_0$ [rad/s]")
    return axes


def _against_duration(runs: Runs, quantity: str) -> Axes:
    trends = _trends(runs, DURATION_TREND, quantity, "duration", ("rate", RATES["pi_5"]))
    axes = _drawn(rf"(b)  $\omega_0$ = {RATE_SYMBOLS['pi_5']} rad/s", quantity, trends)
    axes.xaxis.set_major_locator(FixedLocator(list(DURATIONS)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlim(0.0, 2.1)
    axes.set_xlabel("duration of the stop $T$ [s]")
    return axes


def _finished_frequency(axes: Axes, modes: Modes) -> Figure:
    printed = {entry["model"]: entry["dominant_frequency"] for entry in published.table(4)}
    for k, model in enumerate(MODELS):
        axes.axhline(
            frequency_of(modes[model], dominant_mode(modes[model])), color=COLORS[k], linestyle=_OURS, linewidth=1.2
        )
        axes.axhline(printed[model], color=COLORS[k], linestyle=_PAPER, linewidth=0.9)
    axes.set_ylim(bottom=0.0)
    return _with_legend(axes, natural=True)


def _finished_amplitude(axes: Axes) -> Figure:
    axes.set_yscale("log")
    axes.margins(y=0.1)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    return _with_legend(axes, natural=False)


def _with_legend(axes: Axes, natural: bool) -> Figure:
    """Explain colours and symbols under the drawing."""
    figure = axes.figure
    assert isinstance(figure, Figure)
    entries = [
        Line2D([], [], color=COLORS[k], marker=_MARKERS[model], markersize=_SIZE, label=model)
        for k, model in enumerate(MODELS)
    ]
    entries.append(Line2D([], [], color=GREY, marker="o", linestyle="none", label="paper, Tables 6–9", **_OPEN))  # noqa: RUF001
    if natural:
        entries.append(Line2D([], [], color=GREY, linestyle=_OURS, linewidth=1.2, label="mode (1,2), ours"))
        entries.append(Line2D([], [], color=GREY, linestyle=_PAPER, linewidth=0.9, label="mode (1,2), paper"))
    figure.legend(handles=entries, loc="outside lower center", ncols=2 if natural else 4, columnspacing=1.0)
    return figure
