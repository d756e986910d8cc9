"""Results on disk: xarray Datasets and runs to NetCDF-4 and back, exactly.

The seal and the examination are own, because HDF5 may hang on a damaged file and guards only parts of it by checksums.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import xarray as xr

from tautflex import checks
from tautflex.errors import InputError
from tautflex.files.final_state import GROUP, checkpoint_data, checkpoint_from
from tautflex.files.hdf5 import write_hdf5
from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.solvers.transient.status import Run, Statistics, Status
from tautflex.solvers.variables import dataset_of
from tautflex.writing import written

_FORMAT = "tautflex result"
_SCHEMA = 1
_JSON = "json:"  # marks an attribute that NetCDF cannot hold as it is (bool, None, list, mapping)
_MOST_UNWRITTEN = 10_000_000  # bytes of text and empty dimensions, which a file need not hold
_SEAL = b"tautflex sha256 "
_CHUNK = 2**20
_PACKAGES = ("tautflex", "numpy", "scipy", "numba", "qdldl", "xarray", "h5netcdf")


def save(dataset: xr.Dataset | Run, path: str | os.PathLike[str]) -> Path:
    """Write a Dataset, or a run with the state that it ended in, to a NetCDF-4 file, whole or not at all.

    Variables, coordinates, units and attributes come back from :func:`load` as they were. Attributes may
    also be bool, None, lists and mappings; they are written as JSON text. The file appears under its name
    only when it is complete, so that an interrupted run leaves the previous file.

    Parameters
    ----------
    dataset
        Any Dataset of numbers, truth values and text, or a `Run`, which :func:`load_run` reads.
    path
        File to write, usually ``*.nc``; missing folders are made.

    Returns
    -------
    pathlib.Path
        The file written.

    Raises
    ------
    InputError
        If ``dataset`` is no Dataset, or an attribute cannot be stored.
    NotWrittenError
        If the path cannot be written.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> file = tf.save(run.data, "copy.nc")
    >>> tf.load(file).identical(run.data)
    True
    """
    final = dataset.final if isinstance(dataset, Run) else None
    dataset = dataset_of("dataset", dataset, remedy="give run.data or modes.to_dataset()")
    target = checks.path("path", path)
    groups = {None: _encode(dataset)} | ({} if final is None else {GROUP: _encode(checkpoint_data(final))})
    with written(target) as place:
        write_hdf5(place, groups)
        _seal(place)
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
        If the file is missing, damaged, no result of tautflex, or written by a newer version of the format.

    Notes
    -----
    A file that `save` wrote ends with a checksum of everything before it, which other programs do not mind: a damaged
    file is recognised before HDF5, which could hang on it, sees its content. Files without that end (older ones, or
    ones that another program changed) are read if their metadata have checksums of HDF5's own and they point neither
    at other files nor at more numbers than they hold. HDF5 is not made for files built to do harm: open results from
    sources you trust.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.load("m2/run.nc").w.attrs["units"]
    'm'
    """
    return _load(path)


@contextmanager
def opened(path: str | os.PathLike[str], group: str | None = None) -> Iterator[xr.Dataset]:
    """Dataset as `load` gives it, whose numbers are read from the file each time that they are asked for.

    Long records take no memory that way. Raises as `load` does.
    """
    source = checks.path("path", path)
    if not source.is_file():
        raise InputError(f"path: expected a result file, got {str(source)!r}, which does not exist; check the name")
    wrong = f"path: expected a NetCDF-4 result of tautflex, got {str(source)!r}"
    with _damage_told(wrong):
        _examine(source)
        raw = xr.open_dataset(
            source, engine="h5netcdf", decode_times=False, decode_timedelta=False, mask_and_scale=False, cache=False,
            group=group,
        )  # fmt: skip
    with raw:
        marked = raw.attrs.get("format") == _FORMAT
        if not marked:
            raise InputError(f"{wrong}, which has no tautflex marker; give a file written by tautflex run")
        with _damage_told(wrong):
            schema = int(raw.attrs["schema"])
            result = _decode(raw) if schema <= _SCHEMA else raw
        if schema > _SCHEMA:
            raise InputError(f"{wrong} of schema {schema}; upgrade tautflex to read it")
        yield result


def load_run(path: str | os.PathLike[str]) -> Run:
    """Read a run that :func:`save` or ``tautflex run`` wrote: ``simulate(..., initial=load_run(path).final)``.

    Parameters
    ----------
    path
        NetCDF-4 file of tautflex.

    Returns
    -------
    Run
        Without the residual norms of a step that failed; ``final`` is None if the file holds no state to go on from.

    Raises
    ------
    InputError
        As :func:`load`, or if the file holds something else than a run.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> run.status.value
    'completed'
    """
    data = _load(path)
    try:
        said = Status(data.attrs["status"]), Statistics(**json.loads(data.attrs["statistics"]))
        balance, error = json.loads(data.attrs["energy_balance"]), float(data.attrs["time_error"])
        reached = float(data["time"][-1]) if data.sizes["time"] else float("nan")
    except (LookupError, TypeError, ValueError) as wrong:
        raise InputError(f"path: expected a run, got another result in {str(path)!r}; open it with load") from wrong
    final = _final(checks.path("path", path))
    return Run(data, *said, reached if final is None else final.time, (), error, balance, final)


def _final(path: Path) -> Checkpoint | None:
    """State to go on from; None if a file holds none."""
    with h5py.File(path, "r") as file:
        if GROUP not in file:
            return None
    return checkpoint_from(_load(path, GROUP))


def _load(path: str | os.PathLike[str], group: str | None = None) -> xr.Dataset:
    with opened(path, group) as data, _damage_told(f"path: expected a NetCDF-4 result of tautflex, got {str(path)!r}"):
        return data.load()


@contextmanager
def _damage_told(wrong: str) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # damage can show anywhere in h5py, h5netcdf and xarray, as any exception
        raise InputError(f"{wrong} ({_one_line(error)}); run the case again") from error


def _examine(path: Path) -> None:
    """Raise if a file is damaged or not built as `save` builds it, before anything is made of its content."""
    if _seal_matches(path) is False:
        raise ValueError("damaged, its checksum does not match")
    size = path.stat().st_size
    with h5py.File(path, "r") as file:
        stored = _examine_arrays(file)
        if stored > 2 * size + _MOST_UNWRITTEN:
            raise ValueError(f"{stored} bytes of numbers in a file of {size}")


def _examine_arrays(items: h5py.Group, group: str = GROUP) -> int:
    """Raise if a file or its one group has other things than arrays; bytes of numbers of all of them."""
    _require_checksums(items)
    stored = 0
    for name in items:
        if not isinstance(items.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{name!r} is a link")
        item = items[name]
        if name == group and isinstance(item, h5py.Group):
            stored += _examine_arrays(item, "")
            continue
        _require_checksums(item)
        if not isinstance(item, h5py.Dataset) or item.is_virtual or item.external:
            raise ValueError(f"{name!r} is no array of this file")
        stored += int(item.nbytes)
    return stored


def _seal(path: Path) -> None:
    """Append the checksum of a file to it; HDF5 ignores what follows its own end."""
    with path.open("r+b") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(0, os.SEEK_END)
        file.write(_SEAL + digest.encode("ascii"))


def is_whole(path: Path) -> bool:
    """Whether a file is there and ends with the checksum of everything before it, as `save` leaves it."""
    try:
        return _seal_matches(path) is True
    except OSError:
        return False


def _seal_matches(path: Path) -> bool | None:
    """Whether the checksum at the end of a file is that of its content; None if it ends without one."""
    length = len(_SEAL) + 64
    size = path.stat().st_size
    checksum = hashlib.sha256()
    with path.open("rb") as file:
        for start in range(0, max(0, size - length), _CHUNK):
            checksum.update(file.read(min(_CHUNK, size - length - start)))
        end = file.read()
    return end[len(_SEAL) :] == checksum.hexdigest().encode("ascii") if end.startswith(_SEAL) else None


def _require_checksums(item: h5py.Group | h5py.Dataset) -> None:
    """Raise unless HDF5 protects the metadata of an object by checksums, as it does in files of `save`."""
    if h5py.h5o.get_info(item.id).hdr.version < 2:
        raise ValueError("metadata without checksums")


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:300] or type(error).__name__


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that the numbers depend on ("" if not installed)."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = ""
    return found


def _encode(dataset: xr.Dataset) -> xr.Dataset:
    stored = dataset.copy()  # shallow: the attributes are replaced below, the numbers are shared
    stored.attrs = _encoded("dataset", dataset.attrs) | {"format": _FORMAT, "schema": _SCHEMA}
    stored.encoding = {}
    for name, variable in dataset.variables.items():
        stored[name].attrs, stored[name].encoding = _encoded(str(name), variable.attrs), {}
    return stored


def _decode(raw: xr.Dataset) -> xr.Dataset:
    # text comes back as objects
    texts = {n: (v.dims, v.values.astype(str)) for n, v in raw.variables.items() if v.dtype.kind in "OT"}
    result = raw.assign({name: text for name, text in texts.items() if name in raw.data_vars})
    result = result.assign_coords({name: text for name, text in texts.items() if name in raw.coords})
    result.attrs = {name: value for name, value in _decoded(raw.attrs).items() if name not in ("format", "schema")}
    result.encoding = {}
    for name, variable in raw.variables.items():
        result[name].attrs, result[name].encoding = _decoded(variable.attrs), {}
    return result


def _is_utf8(text: str) -> bool:
    """Whether no name of a file in another encoding is part of a text."""
    return text.encode(errors="ignore").decode() == text


def _encoded(owner: str, attributes: dict[Any, Any]) -> dict[str, Any]:
    """Attributes as NetCDF can hold them."""
    found: dict[str, Any] = {}
    for key, given in attributes.items():
        value = given.item() if isinstance(given, np.generic) else given
        array = isinstance(value, np.ndarray)
        as_it_is = (
            (array and value.ndim == 1 and value.size > 1 and value.dtype.kind in "if")
            or (isinstance(value, int | float) and not isinstance(value, bool))
            or (isinstance(value, str) and value and not value.startswith(_JSON) and _is_utf8(value))
        )
        try:
            found[str(key)] = value if as_it_is else _JSON + json.dumps(value.tolist() if array else value)
        except (TypeError, ValueError):
            raise InputError(
                f"attribute {key!r} of {owner}: expected a number, text, truth value, list or mapping, "
                f"got {type(value).__name__}; turn it into text first"
            ) from None
    return found


def _decoded(attributes: dict[Any, Any]) -> dict[str, Any]:
    found = {str(key): v.item() if isinstance(v, np.generic) else v for key, v in attributes.items()}
    marked = {key: value for key, value in found.items() if isinstance(value, str) and value.startswith(_JSON)}
    return found | {key: json.loads(value[len(_JSON) :]) for key, value in marked.items()}
