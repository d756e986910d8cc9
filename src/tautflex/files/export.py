"""Results for other programs: fields as VTU series with PVD for ParaView, histories as CSV."""

from __future__ import annotations

import csv
import itertools
import os
from collections.abc import Hashable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.errors import InputError
from tautflex.files.vtk_xml import join_cells, write_collection, write_grid

# Kinds of cells in the order in which they are written, with the number that the cell field "kind" gives them.
KINDS = ("triangle", "cable", "beam")
_SERIES = ("field_time", "mode")


def write_vtu(dataset: xr.Dataset, directory: str | os.PathLike[str], name: str = "run") -> list[Path]:
    """Write the stored fields of a run, or mode shapes, for ParaView.

    Points stand in the reference position; ParaView's filter "Warp By Vector" moves them by ``displacement``.
    Every variable over the nodes becomes point data, every one over the film's triangles, cables or beams cell data
    (NaN, or -1 for integers, on cells of the other kinds); ``kind`` tells film 0, cables 1 and beams 2 apart. Mode
    shapes are a series over the mode's number.

    Parameters
    ----------
    dataset
        ``run.data`` with stored fields, or ``modes.to_dataset()``.
    directory
        Where ``<name>.pvd`` and the folder ``<name>_vtu`` go; created if missing.
    name
        Stem of the files.

    Returns
    -------
    list of pathlib.Path
        The PVD file, then the VTU files in time.

    Raises
    ------
    InputError
        If the dataset holds no fields or no mesh.
    OSError
        If the files cannot be written.
    """
    series = _require_fields(dataset)
    steps = dataset[series].values
    points = np.asarray(dataset["node_position"].values, dtype=float)
    parts = [np.asarray(dataset[kind].values, dtype=np.int64) for kind in KINDS]
    cells = join_cells(*parts)
    numbers = np.repeat(np.arange(len(KINDS), dtype=np.int32), [len(part) for part in parts])
    element_dims = {str(dataset[kind].dims[0]): place for place, kind in enumerate(KINDS)}
    folder = Path(directory) / f"{name}_vtu"
    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"{name}_{step:0{max(4, len(str(len(steps))))}d}.vtu" for step in range(len(steps))]
    for step, file in enumerate(files):
        instant = dataset.isel({series: step})
        of_cells = dict(_cell_fields(instant, element_dims, [len(part) for part in parts]))
        write_grid(file, points, cells, dict(_point_fields(instant)), {"kind": numbers} | of_cells)
    collection = Path(directory) / f"{name}.pvd"
    write_collection(collection, [f"{folder.name}/{file.name}" for file in files], [float(step) for step in steps])
    return [collection, *files]


def write_csv(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write everything a run stores over time as a table: one row per step, one column per quantity and probe.

    Headings are like ``w A [m]`` or ``angular_velocity x [rad s-1]``; numbers are written so that they read back
    exactly. Fields over nodes or elements are left out.

    Parameters
    ----------
    dataset
        ``run.data``.
    path
        File to write, usually ``*.csv``; missing folders are made.

    Returns
    -------
    pathlib.Path
        The file written.

    Raises
    ------
    InputError
        If the dataset has no time.
    OSError
        If the file cannot be written.
    """
    if "time" not in dataset.coords:
        raise InputError("dataset: expected the results of a run, got none over time; give run.data or run.nc")
    columns = [("time", dataset["time"]), *_histories(dataset)]
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(
            [f"{title} [{values.attrs['units']}]" if "units" in values.attrs else title for title, values in columns]
        )
        table.writerows(zip(*(values.values.tolist() for _, values in columns), strict=True))
    return target


def _require_fields(dataset: xr.Dataset) -> str:
    """Dimension of the series, or InputError."""
    missing = [name for name in ("node_position", *KINDS) if name not in dataset]
    if missing:
        raise InputError(f"dataset: expected the mesh of a run, got none ({missing[0]} is missing); give run.data")
    series = next((dim for dim in _SERIES if dim in dataset.dims), None)
    if series is None or not dataset.sizes[series]:
        raise InputError(
            'dataset: expected stored fields, got none; run again with output.fields = "all" or a list of instants'
        )
    return series


def _point_fields(instant: xr.Dataset) -> Iterator[tuple[str, NDArray[np.generic]]]:
    for name, values in instant.data_vars.items():
        if name != "node_position" and values.dims[:1] == ("node",) and values.ndim <= 2 and _numeric(values):
            yield str(name), values.values


def _cell_fields(
    instant: xr.Dataset, element_dims: dict[str, int], counts: list[int]
) -> Iterator[tuple[str, NDArray[np.generic]]]:
    start = np.concatenate([[0], np.cumsum(counts)])
    for name, values in instant.data_vars.items():
        place = element_dims.get(str(values.dims[0])) if values.dims else None
        if place is None or name in KINDS or values.ndim > 2 or not _numeric(values):
            continue
        own = values.values
        whole = own.dtype.kind in "iu"
        filled = np.full((start[-1], *own.shape[1:]), -1 if whole else np.nan, dtype=np.int64 if whole else float)
        filled[start[place] : start[place + 1]] = own
        yield str(name), filled


def _numeric(values: xr.DataArray) -> bool:
    return values.dtype.kind in "biuf"


def _histories(dataset: xr.Dataset) -> Iterator[tuple[str, xr.DataArray]]:
    """Columns: the variables over time, taken apart along probes, components and other labels."""
    for name, values in dataset.data_vars.items():
        others = [dim for dim in values.dims if dim != "time"]
        if "time" not in values.dims or any(dim not in dataset.coords for dim in others) or not _numeric(values):
            continue
        for labels in itertools.product(*(dataset[dim].values.tolist() for dim in others)):
            chosen: dict[Hashable, object] = dict(zip(others, labels, strict=True))
            yield " ".join([str(name), *map(str, labels)]), values.sel(chosen)
