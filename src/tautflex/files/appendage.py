"""Files with the rigid-elastic coupling of an appendage: JSON and NPZ with everything, CSV with one mode per row."""

from __future__ import annotations

import csv
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex import checks
from tautflex.errors import InputError
from tautflex.solvers.variables import dataset_of
from tautflex.writing import written

KINDS = (".json", ".npz", ".csv")


def save_appendage(data: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write what `appendage_data` gives.

    Parameters
    ----------
    data
        Dataset of participation and masses.
    path
        Its suffix chooses the form. ``.json``: one object, matrices as lists of rows, units beside them, numbers that
        are not finite as null. ``.npz``: one array per variable for NumPy. ``.csv``: one mode per row with frequency,
        damping ratio, participation and effective mass; the 6 x 6 matrices follow as commented rows.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        If the suffix is unknown, or ``data`` holds no participation.
    NotWrittenError
        If the file cannot be written; what stood there is whole.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> tf.save_appendage(tf.appendage_data(tf.solve_modes(state, n=4)), "antenna.csv").name
    'antenna.csv'
    """
    target = appendage_path(path)
    data = dataset_of("data", data, "participation", "rigid_mass", remedy="appendage_data(modes, point) gives it")
    with written(target) as place:
        if target.suffix == ".json":
            place.write_text(json.dumps(_as_object(data), indent=1, allow_nan=False) + "\n", encoding="utf-8")
        elif target.suffix == ".npz":
            arrays: dict[str, Any] = {str(name): variable.values for name, variable in data.variables.items()}
            with place.open("wb") as file:
                np.savez(file, **arrays)
        else:
            with place.open("w", newline="", encoding="utf-8") as stream:
                csv.writer(stream).writerows(_as_rows(data))
    return target


def appendage_path(path: str | os.PathLike[str]) -> Path:
    """Path whose suffix is known, or InputError."""
    target = checks.path("path", path)
    if target.suffix not in KINDS:
        raise InputError(f"{target}: expected a name that ends with {', '.join(KINDS)}, got {target.suffix!r}")
    return target


def _as_object(data: xr.Dataset) -> dict[str, Any]:
    found: dict[str, Any] = {str(name): value for name, value in data.attrs.items()}
    found["directions"] = data["direction"].values.tolist()
    found["units"] = {str(name): variable.attrs["units"] for name, variable in data.data_vars.items()}
    for name, variable in data.data_vars.items():
        found[str(name)] = _finite(variable.values.tolist())
    return found


def _finite(value: Any) -> Any:
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return value if math.isfinite(value) else None


def _as_rows(data: xr.Dataset) -> list[list[Any]]:
    names = data["direction"].values.tolist()
    rows: list[list[Any]] = [
        ["mode", "frequency", "damping_ratio", *(f"P_{n}" for n in names), *(f"effective_{n}" for n in names)]
    ]
    for number in range(data.sizes["mode"]):
        one = data.isel(mode=number)
        numbers = [one["frequency"], one["damping_ratio"], *one["participation"], *one["effective_mass"]]
        rows.append([number + 1, *(float(value) for value in numbers)])
    rows.append(["# point", *map(float, data["point"].values)])
    for matrix in ("rigid_mass", "free_mass", "residual_mass"):
        rows += [[f"# {matrix} {name}", *map(float, row)] for name, row in zip(names, data[matrix].values, strict=True)]
    return rows
