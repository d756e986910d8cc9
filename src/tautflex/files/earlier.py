"""Earlier results in a folder: whether there are any, what they say, and files that a new one leaves behind."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from tautflex.errors import CaseError
from tautflex.files import netcdf
from tautflex.files.checkpoints import FOLDER

RESULTS = "run.nc", "summary.json", FOLDER


def require_no_results(directory: Path, remedy: str) -> None:
    """Raise CaseError if a folder holds the results of a run, or one that is not finished."""
    found = [name for name in RESULTS if (directory / name).exists()]
    if found:
        text = f"{directory}: expected a directory without results, got one with {' and '.join(found)}"
        raise CaseError(f"{text}; choose another with -o, or {remedy}")


def finished(case: str, directory: Path) -> dict[str, Any] | None:
    """Summary of a run of this case (its text) that is not to go on: it ended by itself; None if there is none yet.

    Raises
    ------
    InputError
        If the folder holds the result of another case, or of a run that nothing is left of to go on from.
    """
    if not (directory / "run.nc").exists() or (directory / FOLDER).exists():
        return None  # a checkpoint beside a result is of a run that was to replace it
    with netcdf.opened(directory / "run.nc") as data:
        there, summary = data.attrs, read_summary(directory)
    if there.get("case") != case:
        text = f"{directory}: expected a result of this case to go on with, got one of another case"
        raise CaseError(f"{text}; choose another folder with -o, or replace it with --force")
    if there.get("status") != "interrupted" and summary:
        return summary
    text = f"{directory}: expected a checkpoint to go on from, got a result without one"
    raise CaseError(f"{text}; replace it with --force")


def read_summary(directory: Path) -> dict[str, Any]:
    """What summary.json of an earlier run says; empty if there is none that can be read."""
    with suppress(OSError, ValueError):
        found = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
        return found if isinstance(found, dict) else {}
    return {}


def remove_left_files(directory: Path, earlier: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Remove files of an earlier run that the one in its place has not."""
    before, after = ({Path(path).name for path in dict(each.get("files", {})).values()} for each in (earlier, now))
    for name in before - after:
        with suppress(OSError):
            (directory / name).unlink()
