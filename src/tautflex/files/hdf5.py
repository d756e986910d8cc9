"""Datasets into an HDF5 file through a file of Python: HDF5 itself crashes where a disk is full."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import h5netcdf
import xarray as xr

from tautflex.solvers.transient.restart.keeper import let_go

_PART = 2**20  # bytes of an array that are written at once


def write_hdf5(path: Path, groups: Mapping[str | None, xr.Dataset]) -> None:
    """Write datasets into the groups of one new file; None is the root.

    Raises
    ------
    OSError
        If there is no room.
    """
    with path.open("w+b", buffering=0) as file:
        watched = _Watched(file)
        try:
            with h5netcdf.File(watched, "w") as written:
                for group, data in groups.items():
                    plain = {name: {"_FillValue": None} for name in data.variables}
                    data.dump_to_store(
                        xr.backends.H5NetCDFStore(written, group=group), encoding=plain, writer=_InParts()
                    )
        finally:
            watched.raise_error()


class _InParts:
    """Writer for xarray that copies no array as a whole, and keeps no part of one that is mapped from a file."""

    def add(self, source: Any, target: Any, region: None = None) -> None:
        """Write an array."""
        if source.nbytes <= _PART:
            target[...] = source
            return
        rows = max(1, _PART * len(source) // source.nbytes)
        for first in range(0, len(source), rows):
            target[first : first + rows] = source[first : first + rows]
            let_go(source)


class _Watched:
    """File toward HDF5 that takes everything: after an error of the system it goes on in memory, until HDF5 is done."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._error: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def write(self, content: Any) -> int:
        """Write all."""
        place, rest = self._file.tell(), memoryview(content).cast("B")
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self._error = error
            self._file.seek(0)
            self._file = io.BytesIO(self._file.read())
            self._file.seek(place)
            self._file.write(content)
        return len(content)

    def raise_error(self) -> None:
        """Raise the error that was kept."""
        if self._error is not None:
            raise self._error
