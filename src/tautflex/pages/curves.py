"""Curves of a page: what a run recorded over time, and the spectrum and scalogram of its liveliest probe."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from tautflex.analysis import scalogram, spectrum
from tautflex.analysis.record import counted_from
from tautflex.analysis.turning import recorded_attitude
from tautflex.errors import InputError
from tautflex.motion.rotations import rotation_vectors
from tautflex.numeric import Array
from tautflex.pages.encode import packed, quantised
from tautflex.plot.style import thinned

# Lines of a panel at most: more are not told apart.
_MOST_LINES = 8
_MOST_POINTS, _SCALOGRAM_COLUMNS = 1600, 320


def curves_of(run: xr.Dataset, tension: tuple[Array, Array] | None) -> list[dict[str, Any]]:
    """Panels over time; ``tension`` has instants [s] and the tensions of the cables [N], shape (instant, cable)."""
    time, panels = run["time"].values, list[dict[str, Any]]()
    if run.sizes.get("probe", 0):
        w = run["w"].transpose("probe", "time").values
        largest = np.argsort(-np.abs(w).max(axis=1, initial=0.0))[:_MOST_LINES]
        lines = [(str(run["probe"].values[k]), time, 1e3 * w[k]) for k in sorted(largest)]
        panels.append(_panel("w", "Displacement of the probes", "w [mm]", lines))
    if run["surface_rms"].notnull().any():
        lines = [("rms", time, 1e3 * run["surface_rms"].values)]
        panels.append(_panel("surface", "Film off its best plane", "rms [mm]", lines))
    if np.any(run["angular_velocity"].values) or "attitude" in run:
        some = time[:: max(1, len(time) // 2000)]
        turns = np.degrees(rotation_vectors(recorded_attitude(run, some)))
        panels.append(_panel("attitude", "Attitude (rotation vector)", "angle [deg]", _along(some, turns)))
        rates = np.degrees(run["angular_velocity"].transpose("time", "component").values)
        panels.append(_panel("rate", "Angular velocity", "rate [deg/s]", _along(time, rates)))
    if "attitude_error" in run:
        error = [("to what it follows", run["sample_time"].values, np.degrees(run["attitude_error"].values))]
        panels.append(_panel("error", "Attitude error", "angle [deg]", error))
    panels += _commands(run)
    if tension is not None and tension[1].size:
        at, pull = tension
        lines = [(name, at, reduce(pull, axis=1)) for name, reduce in (("largest", np.max), ("mean", np.mean))]
        lines.append(("smallest", at, pull.min(axis=1)))
        panels.append(_panel("tension", "Tension of the cables", "force [N]", lines))
    stored = [run[f"{name}_energy"] for name in ("kinetic", "strain")]
    energies = [(each.attrs["long_name"].replace(" energy", ""), time, 1e3 * each.values) for each in stored]
    panels.append(_panel("energy", "Energy", "energy [mJ]", energies))
    resultant = run["min_principal_resultant"].values
    known = np.isfinite(resultant)
    if known.sum() > 1:  # a reduced run looks at its field at a few instants; between them nothing is known
        few = "" if known.all() else f", at {known.sum()} of {known.size} instants"
        lines = [(f"smallest principal{few}", time[known], resultant[known])]
        panels.append(_panel("resultant", "Resultants of the film", "resultant [N/m]", lines))
    return [panel for panel in panels if panel["lines"]]


def _along(time: Array, vectors: Array) -> list[tuple[str, Array, Array]]:
    """Components that are not zero beside the largest, x if all are."""
    size = np.abs(vectors).max(axis=0, initial=0.0)
    moves = [k for k in range(3) if size[k] > max(1e-9, 1e-4 * size.max())] or [0]
    return [(f"about {'xyz'[k]}", time, vectors[:, k]) for k in moves]


def _commands(run: xr.Dataset) -> Iterator[dict[str, Any]]:
    """One panel of commands for every unit."""
    if "command" not in run:
        return
    units, time = list(run["command"].attrs.get("channel_units", [])), run["sample_time"].values
    names, values = [str(name) for name in run["input"].values], run["command"].transpose("sample_time", "input").values
    for unit in dict.fromkeys(units):
        own = [k for k, other in enumerate(units) if other == unit][:_MOST_LINES]
        yield _panel(f"command {unit}", "Command", f"command [{unit}]", [(names[k], time, values[:, k]) for k in own])


def _panel(key: str, title: str, label: str, lines: list[tuple[str, Array, Array]]) -> dict[str, Any]:
    found = []
    for name, x, y in lines:
        some, values = thinned(np.asarray(x, dtype=float), np.asarray(y, dtype=float), _MOST_POINTS, 0)
        if some.size > 1:
            found.append({"name": name, "x": packed(some), "y": packed(values)})
    return {"key": key, "title": title, "label": label, "lines": found}


def frequencies_of(run: xr.Dataset, highest: float) -> dict[str, Any] | None:
    """Spectrum after the maneuver, to ``highest`` [Hz] or where most energy is, and scalogram of the liveliest probe.

    Of the whole record where there is no maneuver or it outlasts the record; None of a record too short, or zero.
    """
    if not run.sizes.get("probe", 0):
        return None
    w = run["w"].transpose("probe", "time")
    name = str(run["probe"].values[int(np.abs(w.values).max(axis=1).argmax())])
    record = run["w"].sel(probe=name)
    if not record.any():
        return None
    try:
        counted = counted_from(run)
        after = None if counted == math.inf else counted
        when = {None: "", math.inf: "during the maneuver"}.get(counted, "after the maneuver")
        found, picture = spectrum(record, after=after), scalogram(_decimated(record))
    except InputError:
        return None
    f, height = found["frequency"].values, 1e3 * found["amplitude"].values
    most = f[min(len(f) - 1, int(np.searchsorted(np.cumsum(height**2), 0.99 * np.sum(height**2))))]
    some = (f > 0.0) & (f <= max(1.2 * most, 1.5 * highest, f[min(len(f) - 1, 8)]))
    x, y = thinned(f[some], height[some], _MOST_POINTS, 0)
    columns = np.unique(np.linspace(0, picture.sizes["time"] - 1, _SCALOGRAM_COLUMNS).round().astype(int))
    picture = picture.isel(time=columns)
    magnitude = 1e3 * picture["magnitude"].transpose("frequency", "time").values
    return {
        "probe": name,
        "of": f"Spectrum {when}".strip(),
        "spectrum": {"x": packed(x), "y": packed(y)},
        "scalogram": {
            "frequency": packed(picture["frequency"].values),
            "time": packed(picture["time"].values),
            "magnitude": quantised(magnitude[..., None]),
            "ridge": packed(picture["ridge"].values),
            "cone": packed(np.minimum(picture["cone_of_influence"].values, 1e30)),
        },
    }


def _decimated(record: xr.DataArray) -> xr.DataArray:
    """A long record at fewer instants, as many as its fastest motion needs eight times over."""
    size, step = record.sizes["time"], float(record["time"][1] - record["time"][0]) if record.sizes["time"] > 1 else 0.0
    if size <= 4000:
        return record
    values = np.abs(np.fft.rfft(record.values - record.values.mean())) ** 2
    fastest = int(np.searchsorted(np.cumsum(values), 0.9999 * values.sum())) / (size * step)
    stride = int(max(1, min(size // 2000, 1.0 / (16.0 * max(fastest, 1e-12) * step))))
    return record.isel(time=slice(None, None, stride))
