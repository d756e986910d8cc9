"""Finished runs on disk: found again by what they depend on, and only if they are whole."""

from __future__ import annotations

import contextlib
import hashlib
from functools import cache
from pathlib import Path

import xarray as xr

import tautflex
from tautflex._version import __version__
from tautflex.files import netcdf
from tautflex.paper.cases.catalogue import RunSpec

SCHEMA = 1
"""Raise it when the content of a stored run changes."""
# Rooms that only look at finished runs; everything else may have had a hand in one.
_ONLOOKERS = ("batch", "cli", "plot")


def run_key(spec: RunSpec) -> str:
    """Return the hash of everything a run's result depends on: case, version, sources of the numerics."""
    parts = (str(SCHEMA), __version__, _sources(), spec.case.to_toml())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]


def stored(spec: RunSpec, directory: Path) -> Path | None:
    """Return the file of a finished run, None if there is none or it is damaged."""
    path = _path(spec, directory)
    return path if netcdf.is_whole(path) else None


def keep(spec: RunSpec, dataset: xr.Dataset, directory: Path) -> Path:
    """Write a run; its file is there when it is whole, and only then does the run count as finished.

    Raises
    ------
    InputError
        If the directory cannot be written.
    """
    return netcdf.save(dataset, _path(spec, directory))


def sweep_leftovers(directory: Path) -> None:
    """Remove what a killed process left half written."""
    for path in directory.glob(".*.part"):
        with contextlib.suppress(OSError):
            path.unlink()


def _path(spec: RunSpec, directory: Path) -> Path:
    return directory / f"{run_key(spec)}.nc"


def source_files() -> list[Path]:
    """Every file of the package that a run can depend on, sub-folders and data included, sorted."""
    root = Path(tautflex.__file__).parent
    files = [path for path in root.rglob("*") if path.suffix in (".py", ".toml")]
    return sorted(path for path in files if path.relative_to(root).parts[0] not in _ONLOOKERS)


@cache
def _sources() -> str:
    """Hash of these files: results of other equations are never taken for those of these."""
    root = Path(tautflex.__file__).parent
    digest = hashlib.sha256()
    for path in source_files():
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()
