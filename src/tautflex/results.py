"""Results on disk: xarray Datasets to NetCDF-4 and back, exactly."""

from __future__ import annotations

import contextlib
import json
import os
import platform
import uuid
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex.errors import InputError

_FORMAT = "tautflex result"
_SCHEMA = 1
_JSON = "json:"  # marks an attribute that NetCDF cannot hold as it is (bool, None, list, mapping)
_PACKAGES = ("tautflex", "numpy", "scipy", "numba", "qdldl", "xarray", "h5netcdf")


def save(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a Dataset to a NetCDF-4 file, whole or not at all.

    Variables, coordinates, units and attributes come back from :func:`load` as they were. Attributes may
    also be bool, None, lists and mappings; they are written as JSON text. The file appears under its name
    only when it is complete, so that an interrupted run leaves the previous file.

    Parameters
    ----------
    dataset
        Any Dataset of numbers, truth values and text.
    path
        File to write, usually ``*.nc``; missing folders are made.

    Returns
    -------
    pathlib.Path
        The file written.

    Raises
    ------
    InputError
        If ``dataset`` is no Dataset, an attribute cannot be stored, or the path cannot be written.
    """
    if not isinstance(dataset, xr.Dataset):
        raise InputError(f"dataset: expected an xarray Dataset, got {type(dataset).__name__}; try run.data")
    target = Path(path)
    stored = _encode(dataset)
    temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        encoding = {variable: {"_FillValue": None} for variable in stored.variables}
        stored.to_netcdf(temporary, engine="h5netcdf", format="NETCDF4", encoding=encoding)
        temporary.replace(target)
    except OSError as error:
        raise InputError(
            f"path: expected a file that can be written, got {str(target)!r} ({error}); choose another folder"
        ) from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
    return target


def load(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a Dataset that :func:`save` wrote; the file is closed on return.

    Parameters
    ----------
    path
        NetCDF-4 file of tautflex.

    Raises
    ------
    InputError
        If the file is missing, unreadable, no result of tautflex, or written by a newer version of the
        format.
    """
    source = Path(path)
    if not source.is_file():
        raise InputError(f"path: expected a result file, got {str(source)!r}, which does not exist; check the name")
    wrong = f"path: expected a NetCDF-4 result of tautflex, got {str(source)!r}"
    try:
        raw = xr.load_dataset(
            source, engine="h5netcdf", decode_times=False, decode_timedelta=False, mask_and_scale=False
        )
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise InputError(f"{wrong} ({error}); run the case again") from error
    if raw.attrs.get("format") != _FORMAT:
        raise InputError(f"{wrong}, which has no tautflex marker; give a file written by tautflex run")
    if int(raw.attrs["schema"]) > _SCHEMA:
        raise InputError(f"{wrong} of schema {raw.attrs['schema']}; upgrade tautflex to read it")
    return _decode(raw)


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that the numbers depend on ("" if not installed)."""
    found = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = ""
    return found


def _encode(dataset: xr.Dataset) -> xr.Dataset:
    stored = dataset.copy()  # shallow: the attributes are replaced below, the numbers are shared
    stored.attrs = _encoded_attributes("dataset", dataset.attrs) | {"format": _FORMAT, "schema": _SCHEMA}
    for name, variable in dataset.variables.items():
        stored[name].attrs = _encoded_attributes(str(name), variable.attrs)
        stored[name].encoding = {}
    stored.encoding = {}
    return stored


def _decode(raw: xr.Dataset) -> xr.Dataset:
    result = raw.copy()
    result.attrs = _decoded_attributes(raw.attrs, drop=("format", "schema"))
    for name in raw.variables:
        variable = raw[name]
        if variable.dtype.kind in "OT":  # text comes back as objects
            result = result.assign({name: variable.astype(str)} if name in raw.data_vars else {})
            if name in raw.coords:
                result = result.assign_coords({name: (variable.dims, variable.values.astype(str))})
        result[name].attrs = _decoded_attributes(variable.attrs)
        result[name].encoding = {}
    result.encoding = {}
    return result


def _encoded_attributes(owner: str, attributes: dict[Any, Any]) -> dict[str, Any]:
    return {str(key): _encoded(owner, str(key), value) for key, value in attributes.items()}


def _encoded(owner: str, key: str, value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size > 1 and value.dtype.kind in "if":
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value
    if isinstance(value, str) and value and not value.startswith(_JSON):
        return value
    try:
        return _JSON + json.dumps(value.tolist() if isinstance(value, np.ndarray) else value)
    except (TypeError, ValueError):
        raise InputError(
            f"attribute {key!r} of {owner}: expected a number, text, truth value, list or mapping, "
            f"got {type(value).__name__}; turn it into text first"
        ) from None


def _decoded_attributes(attributes: dict[Any, Any], drop: tuple[str, ...] = ()) -> dict[str, Any]:
    return {str(key): _decoded(value) for key, value in attributes.items() if key not in drop}


def _decoded(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, str) and value.startswith(_JSON):
        return json.loads(value[len(_JSON) :])
    return value
