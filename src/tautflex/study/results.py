"""Result of a study: one Dataset of all points, and a table of it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex.files import netcdf
from tautflex.files.transaction import publish
from tautflex.study import measures
from tautflex.study.axes import unit_of
from tautflex.study.points import Grid
from tautflex.study.sections import Study
from tautflex.study.store import Store
from tautflex.writing import written

Figures = Callable[[xr.Dataset, Path], list[Path]]
MISSING = "missing"
"""Status of a point that is not there yet."""


def study_dataset(
    study: Study, points: Grid, store: Store, keys: Sequence[str], unkept: dict[int, tuple[str, str]]
) -> xr.Dataset:
    """Dataset of all points of a study from their files.

    Parameters
    ----------
    study, points
        What was asked.
    store, keys
        Where the points are; a key "" has no file.
    unkept
        Number -> status and message of points that are not kept.

    Returns
    -------
    xarray.Dataset
        A dimension for each axis, or group of axes that change together, called as its first axis; measures, NaN where
        a point tells none, ``status`` and ``message``.
    """
    columns: dict[str, Any] = {name: np.full(len(points), np.nan) for name in study.measures.names}
    status, message = [MISSING] * len(points), [""] * len(points)
    for number, key in enumerate(keys):
        kept = store.read(key) if key else None
        if kept is None:
            status[number], message[number] = unkept.get(number, (MISSING, ""))
            continue
        status[number], message[number] = kept["status"], kept["message"]
        for name, value in kept["measures"].items():
            if name in columns or not study.measures.names:
                column = columns.setdefault(name, np.full(len(points), np.nan))
                column[number] = np.nan if value is None else value
    dims, coordinates = [], dict[str, Any]()
    for group, steps in zip(study.groups, points.steps, strict=True):
        dims.append(group[0])
        for name in group:
            values = _coordinate([step[name] for step in steps])
            coordinates[name] = (group[0], values, measures.words(name, unit_of(name)))
    found: dict[str, Any] = {}
    for name, column in columns.items():
        found[name] = (dims, column.reshape(points.shape), measures.words(name, measures.unit_of(name)))
    found["status"] = (dims, np.array(status, dtype=str).reshape(points.shape), {"long_name": "how the point ended"})
    found["message"] = (dims, np.array(message, dtype=str).reshape(points.shape), {"long_name": "why it failed"})
    about: dict[str, Any] = {"title": "study", "axes": list(study.axes), "versions": json.dumps(netcdf.versions())}
    return xr.Dataset(found, coordinates, about)


def _coordinate(values: Sequence[Any]) -> Any:
    """Values of an axis as an array: numbers, or texts of what is no number."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=float)
    return np.array([value if isinstance(value, str) else json.dumps(value, default=str) for value in values])


def write_table(data: xr.Dataset, path: Path) -> Path:
    """Write a study as a table of comma-separated values: one row per point, its axes first, headings with units."""
    titles = {str(name): f"{name} [{values.attrs['units']}]" for name, values in data.variables.items()
              if values.attrs.get("units", "1") != "1"}  # fmt: skip
    if not data.sizes:
        data = data.expand_dims("point")
    table = data.to_dataframe().reset_index()
    table = table[[*data.coords, *(name for name in table if name not in data.coords)]].rename(columns=titles)
    with written(path) as place:
        table.to_csv(place, index=False)
    return path


def write_together(
    directory: Path, files: Mapping[str, Callable[[Path], object]], figures: Callable[[Path], list[Path]] | None
) -> dict[str, Path]:
    """Write files by functions of their paths, and figures by one of their folder, all or none; where they stand."""

    def write(place: Path, final: Path) -> list[Path]:
        for name, one in files.items():
            one(place / name)
        drawn = [] if figures is None else figures(place)
        return [final / name for name in (*files, *(path.name for path in drawn))]

    paths = publish(directory, write)
    stems = [path.stem for path in paths]
    return {path.name if stems.count(path.stem) > 1 else path.stem: path for path in paths}


def counts(data: xr.Dataset) -> dict[str, int]:
    """Number of points, of those done and of those failed."""
    status = data["status"].values.ravel()
    done, missing = int((status == "completed").sum()), int((status == MISSING).sum())
    return {"points": math.prod(data["status"].shape), "done": done, "failed": status.size - done - missing}
