"""Finished runs on disk: found again by what they depend on, and only if they are whole."""

from __future__ import annotations

import contextlib
import hashlib
import json
import uuid
from functools import cache
from pathlib import Path

import xarray as xr

import tautflex
from tautflex._version import __version__
from tautflex.errors import InputError
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
    data, record = _paths(spec, directory)
    try:
        wanted = json.loads(record.read_text(encoding="utf-8"))["sha256"]
        return data if hashlib.sha256(data.read_bytes()).hexdigest() == wanted else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def keep(spec: RunSpec, dataset: xr.Dataset, directory: Path) -> Path:
    """Write a run and, after it, the record that makes it count as finished.

    Raises
    ------
    InputError
        If the directory cannot be written.
    """
    data, record = _paths(spec, directory)
    netcdf.save(dataset, data)
    checksum = hashlib.sha256(data.read_bytes()).hexdigest()
    text = json.dumps({"name": spec.name, "sha256": checksum, "version": __version__}, indent=2)
    temporary = record.with_name(f".{record.name}.{uuid.uuid4().hex}.part")
    try:
        temporary.write_text(text + "\n", encoding="utf-8")
        temporary.replace(record)
    except OSError as error:
        text = f"directory: expected a place that can be written, got {str(directory)!r} ({error})"
        raise InputError(f"{text}; choose another one") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
    return data


def sweep_leftovers(directory: Path) -> None:
    """Remove what a killed process left half written."""
    for path in directory.glob(".*.part"):
        with contextlib.suppress(OSError):
            path.unlink()


def _paths(spec: RunSpec, directory: Path) -> tuple[Path, Path]:
    key = run_key(spec)
    return directory / f"{key}.nc", directory / f"{key}.json"


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
