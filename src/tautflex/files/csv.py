"""Histories of a run as a table of comma-separated values."""

from __future__ import annotations

import csv
import itertools
import os
from collections.abc import Hashable, Iterator
from pathlib import Path

import xarray as xr

from tautflex import checks
from tautflex.files.results import results_of_a_run
from tautflex.solvers.variables import dataset_of
from tautflex.writing import written

_ROWS = 2**12  # that are written at once


@results_of_a_run()
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
    NotWrittenError
        If the file cannot be written; what stood there is whole.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.write_csv(run.data, "run.csv").name
    'run.csv'
    """
    dataset = dataset_of("dataset", dataset, "time", remedy="give run.data or load('run.nc')")
    columns = [("time", dataset["time"]), *_histories(dataset)]
    target = checks.path("path", path)
    with written(target) as place, place.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(
            [f"{title} [{values.attrs['units']}]" if "units" in values.attrs else title for title, values in columns]
        )
        for first in range(0, dataset.sizes["time"], _ROWS):
            part = (values.isel(time=slice(first, first + _ROWS)).values.tolist() for _, values in columns)
            table.writerows(zip(*part, strict=True))
    return target


def _histories(dataset: xr.Dataset) -> Iterator[tuple[str, xr.DataArray]]:
    """Columns: the variables over time, taken apart along probes, components and other labels."""
    for name, values in dataset.data_vars.items():
        others = [dim for dim in values.dims if dim != "time"]
        if (
            "time" not in values.dims
            or any(dim not in dataset.coords for dim in others)
            or values.dtype.kind not in "biuf"
        ):
            continue
        for labels in itertools.product(*(dataset[dim].values.tolist() for dim in others)):
            chosen: dict[Hashable, object] = dict(zip(others, labels, strict=True))
            yield " ".join([str(name), *map(str, labels)]), values.sel(chosen)
