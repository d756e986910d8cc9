"""Figures of a study: lines over one axis, maps over two and over slices of more; the history of a design."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tautflex import checks
from tautflex.errors import InputError
from tautflex.plot.style import COLORS, DOUBLE_COLUMN, GREY, SEQUENTIAL, new_figure, saving, styled
from tautflex.solvers.variables import dataset_of
from tautflex.text import shown

_COLUMNS, _MOST = 3, 12  # panels beside each other, and altogether
_HEIGHT = 2.0  # [inch] of a row of panels
_LINE, _LETTER = 0.14, 0.065  # [inch] of height and of width that words take
_FEW = 26  # letters that have room above or beside a panel
_SLOPING: dict[str, Any] = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"}  # words under a panel


@styled
def plot_study(study: xr.Dataset, measures: Sequence[str] | None = None) -> Figure:
    """Draw measures of a study, a panel each: lines over one axis, maps over two.

    More axes give maps over the last two at values of the others, one measure after the other on a scale of its own.

    Parameters
    ----------
    study
        Dataset of :func:`tautflex.sweep`.
    measures
        Names of measures; by default those that differ from point to point. There are at most twelve panels: of many
        values of the first axes some are left out, evenly.

    Returns
    -------
    matplotlib.figure.Figure
        Points that failed are crosses.

    Raises
    ------
    InputError
        If there are no such measures, or no axes.
    """
    study = dataset_of("study", study, "status", remedy="sweep(study, directory) gives one")
    axes = [str(name) for name in study["status"].dims]
    if not axes:
        raise InputError("study: expected one axis or more, got none; keep one: study.sel({'damping.beta': [0.001]})")
    numbers = [str(name) for name, column in study.data_vars.items() if column.dtype.kind == "f"]
    if measures is None:
        most = _MOST if len(axes) <= 2 else _MOST // _COLUMNS
        measures = [name for name in numbers if _differs(study[name].values)][:most] or numbers[:most]
    for name in checks.several("measures", measures, str, "'surface.rms_max'"):
        if name not in numbers:
            near = difflib.get_close_matches(name, numbers, n=1) or numbers[:1] or ["none"]
            raise InputError(f"measures: expected measures of the study such as {near[0]!r}, got {shown(name)}")
    if not measures:
        raise InputError("measures: expected at least one, got none; every point failed, or the study keeps none")
    slices = _slices(study, axes[:-2], max(1, _MOST // len(measures)))
    beside, high = _room(study, measures, axes)
    columns = min(beside, len(measures) * len(slices))
    rows = math.ceil(len(measures) * len(slices) / columns)
    figure = new_figure(DOUBLE_COLUMN * columns / beside, high * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel, (name, one) in zip(panels, product(measures, slices), strict=False):
        if len(axes) == 1:
            _lines(panel, one, name, axes)
        else:
            _map(panel, one, name, axes[-2:], study[name].values)
    for panel in panels[len(measures) * len(slices) :]:
        panel.set_visible(False)
    return figure


save_study = saving(plot_study)


@styled
def plot_design(design: xr.Dataset) -> Figure:
    """Draw the objectives of a design over its trials, and the best one so far.

    Parameters
    ----------
    design
        Dataset of :func:`tautflex.design`.

    Returns
    -------
    matplotlib.figure.Figure
        Trials that break a constraint, or failed, are crosses.

    Raises
    ------
    InputError
        If it is no such Dataset.
    """
    design = dataset_of("design", design, "objective", "feasible", remedy="design(study, directory) gives one")
    trial, feasible = design["trial"].values, design["feasible"].values
    names = [str(name) for name in design["measure"].values]
    figure = new_figure(DOUBLE_COLUMN * 0.75, _HEIGHT * len(names))
    for number, (axes, name) in enumerate(
        zip(figure.subplots(len(names), 1, squeeze=False).ravel(), names, strict=True)
    ):
        values = design["objective"].isel(measure=number).values
        largest = design["direction"].values[number] == "maximize"
        good = np.where(feasible, values, -np.inf if largest else np.inf)
        good[np.isnan(good)] = -np.inf if largest else np.inf
        best = (np.maximum if largest else np.minimum).accumulate(good)
        axes.plot(trial, np.where(feasible, values, np.nan), "o", markersize=3, color=COLORS[0], label="trial")
        axes.plot(trial, np.where(feasible, np.nan, values), "x", markersize=4, color=GREY, label="breaks a constraint")
        axes.step(trial, np.where(np.isfinite(best), best, np.nan), where="post", color=COLORS[1], label="best so far")
        axes.set(xlabel="trial", ylabel=_label(design, name))
        if number == 0:
            axes.legend(loc="best")
    return figure


save_design = saving(plot_design)


def _room(study: xr.Dataset, measures: Sequence[str], axes: list[str]) -> tuple[int, float]:
    """Panels beside each other and height of a row [inch], with room for titles and for values that are words."""
    down, across = (max(map(len, _places(study, axis)[1] or [""])) for axis in (axes[-2:][0], axes[-1]))
    lines = max(_folded(_label(study, name)).count("\n") for name in measures) + len(axes[:-2])
    return _COLUMNS - (len(axes) > 1 and 3 * down > _FEW), _HEIGHT + _LINE * lines + 0.5 * _LETTER * across


def _slices(study: xr.Dataset, others: list[str], most: int) -> list[xr.Dataset]:
    """Studies at values of all axes but the last two; of more than ``most`` some are left out, evenly."""
    places = list(np.ndindex(*(study.sizes[name] for name in others)))
    chosen = places[:: math.ceil(len(places) / most)]
    return [study.isel(dict(zip(others, place, strict=True))) for place in chosen]


def _differs(values: np.ndarray) -> bool:
    finite = values[np.isfinite(values)]
    return bool(finite.size) and float(np.ptp(finite)) > 1e-12 * float(np.abs(finite).max())


def _label(study: xr.Dataset, name: str) -> str:
    unit = study[name].attrs.get("units", "") if name in study.variables else ""
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def _told(value: Any) -> str:
    return str(value) if isinstance(value, str) else f"{value:.4g}"


def _places(study: xr.Dataset, axis: str) -> tuple[np.ndarray, list[str] | None]:
    """Where the values of an axis stand, and their names where they are no numbers."""
    values = study[axis].values
    if values.dtype.kind == "f":
        return values, None
    return np.arange(float(len(values))), [str(value) for value in values]


def _folded(label: str) -> str:
    """A label in lines that have room beside a panel, broken behind blanks and within names."""
    lines = [""]
    for part in re.split(r"(?<=[._])(?=[a-z])|(?<= )", label):
        if lines[-1] and len(lines[-1] + part) > _FEW:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)


def _decades(places: np.ndarray) -> bool:
    """Whether values are so far apart that most of them would share one end of an even axis."""
    return len(places) > 2 and places[0] > 0.0 and places[-2] - places[0] < 0.25 * (places[-1] - places[0])


def _edges(places: np.ndarray, decades: bool) -> np.ndarray:
    """Where the cells of a map's axis begin and end: halfway between values."""
    even = np.log(places) if decades else places
    if len(even) == 1:
        even = even[0] + np.array([-1.0, 0.0, 1.0])
    middle = 0.5 * (even[1:] + even[:-1])
    if len(places) > 1:
        middle = np.array([1.5 * even[0] - 0.5 * even[1], *middle, 1.5 * even[-1] - 0.5 * even[-2]])
    return np.exp(middle) if decades else middle


def _ticks(places: np.ndarray, decades: bool, upright: bool) -> tuple[list[float], list[str]]:
    """Values of a map's axis, the first one and what has room after it, and what they are called."""
    at = (np.log(places) if decades else places).tolist()
    inch = (len(at) - 1) / len(at) / (at[-1] - at[0]) if len(at) > 1 else 1.0  # of a panel's, about one
    words = [_told(place) for place in places]
    chosen = [0]
    for k in range(1, len(at)):
        room = 1.2 * _LINE if upright else _LETTER * (0.5 * len(words[k] + words[chosen[-1]]) + 1.0)
        if (at[k] - at[chosen[-1]]) * inch >= room:
            chosen.append(k)
    return places[chosen].tolist(), [words[k] for k in chosen]


def _lines(panel: Axes, study: xr.Dataset, name: str, axes: list[str]) -> None:
    places, words = _places(study, axes[0])
    order = np.argsort(places, kind="stable")
    values, failed = study[name].values[order], (study["status"].values != "completed")[order]
    panel.plot(places[order], values, "." if words else ".-", markersize=4)
    if failed.any():  # a line without points would stand at zero, far outside the panel
        panel.plot(places[order][failed], np.zeros(failed.sum()), "x", color=GREY, clip_on=False,
                   transform=panel.get_xaxis_transform())  # fmt: skip
    panel.set(xlabel=_folded(_label(study, axes[0])), ylabel=_folded(_label(study, name)))
    if words is not None:
        panel.set_xticks(places, words, **_SLOPING)


def _map(panel: Axes, study: xr.Dataset, name: str, axes: list[str], whole: np.ndarray) -> None:
    """Draw a measure over two axes, on the scale of its values in the whole study."""
    (down, names_down), (across, names_across) = (_places(study, axis) for axis in axes)
    down_order, across_order = np.argsort(down, kind="stable"), np.argsort(across, kind="stable")
    down, across = down[down_order], across[across_order]
    values = study[name].transpose(*axes).values[np.ix_(down_order, across_order)]
    finite = whole[np.isfinite(whole)]
    low, high = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
    scales = [names is None and _decades(places) for places, names in ((across, names_across), (down, names_down))]
    shades = panel.pcolormesh(_edges(across, scales[0]), _edges(down, scales[1]), np.ma.masked_invalid(values),
                              cmap=SEQUENTIAL, vmin=low, vmax=high)  # fmt: skip
    failed = (study["status"].transpose(*axes).values != "completed")[np.ix_(down_order, across_order)]
    rows, columns = np.nonzero(failed)
    panel.plot(across[columns], down[rows], "x", color=GREY)
    panel.grid(visible=False)
    panel.set(xlabel=_folded(_label(study, axes[1])), ylabel=_folded(_label(study, axes[0])))
    fixed = [f"{_label(study, axis)} = {_told(study[axis].values[()])}" for axis in map(str, study.coords)
             if study[axis].ndim == 0]  # fmt: skip
    panel.set_title("\n".join(map(_folded, [_label(study, name), *fixed])), pad=12)  # above the bar's power of ten
    panel.set(**{f"{axis}scale": "log" for axis, decades in zip("xy", scales, strict=True) if decades})
    panel.minorticks_off()
    if names_across is not None:
        panel.set_xticks(across, names_across, **_SLOPING)
    else:
        panel.set_xticks(*_ticks(across, scales[0], upright=False))
    panel.set_yticks(*(_ticks(down, scales[1], upright=True) if names_down is None else (down, names_down)))
    if finite.size:
        assert panel.figure is not None
        panel.figure.colorbar(shades, ax=panel)
