"""Finished points on disk: small files, found again by what they depend on, and only if they are whole."""

from __future__ import annotations

import contextlib
import json
import os
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from tautflex.case.plugins import LOADED
from tautflex.case.prepared import digest, files_of, own_code
from tautflex.case.schema import Case
from tautflex.errors import NotWrittenError
from tautflex.files import netcdf

SCHEMA = 1
"""Raise it when the content of a stored point changes."""


@dataclass(frozen=True)
class Store:
    """Folder of points: ``ab/abcdef....json`` with the numbers of each, and ``.nc`` beside it where records are kept.

    Parameters
    ----------
    directory
        The folder, which every worker sees under this name.
    records
        Whether a point is finished only with its whole record.
    """

    directory: Path
    records: bool = False

    def path(self, key: str) -> Path:
        """File of the numbers of a point."""
        return self.directory / key[:2] / f"{key}.json"

    def record(self, key: str) -> Path:
        """File of the record of a point."""
        return self.path(key).with_suffix(".nc")

    def read(self, key: str) -> dict[str, Any] | None:
        """Content of a finished point; None if it is not there, or damaged."""
        try:
            content = json.loads(self.path(key).read_bytes())
        except (OSError, ValueError):
            return None
        whole = isinstance(content, dict) and content.get("key") == key
        if whole and self.records and content.get("record"):
            whole = netcdf.is_whole(self.record(key))
        elif whole and self.records:
            whole = content.get("status") != "completed"
        return content if whole else None

    def write(self, key: str, content: dict[str, Any], record: xr.Dataset | None = None) -> None:
        """Write a point, whole or not at all: only then does it count as finished.

        Raises
        ------
        NotWrittenError
            If the folder cannot be written.
        """
        if record is not None:
            netcdf.save(record, self.record(key))
        target = self.path(key)
        aside = target.with_name(f".{key}.{uuid.uuid4().hex}.part")
        text = json.dumps({"key": key, "record": record is not None, **content}, allow_nan=False)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            try:
                aside.write_text(f"{text}\n", encoding="utf-8")
                os.replace(aside, target)  # not forced to the disk: what a power failure takes is computed again
            finally:
                aside.unlink(missing_ok=True)
        except OSError as error:
            text = f"directory: expected a place that can be written, got {str(self.directory)!r} ({error.strerror})"
            raise NotWrittenError(f"{text}; free some space or choose another one") from None

    def sweep_leftovers(self) -> None:
        """Remove what a killed process left half written."""
        for path in self.directory.rglob(".*.part"):
            with contextlib.suppress(OSError):
                path.unlink()


def case_key(case: Case) -> str:
    """Hash of everything a run's result depends on: its case and the files that it names, version and code."""
    own = case.model_dump(mode="json", by_alias=True, exclude_none=True)
    return digest([code_key(), own, files_of(own)])[:24]


def code_key() -> str:
    """Hash of version, sources and plugins: results of other equations are never taken for those of these."""
    plugins = {str(path): Path(path).read_text(encoding="utf-8") for path in sorted(LOADED)}
    return digest([SCHEMA, own_code(), sorted(plugins.values())])
