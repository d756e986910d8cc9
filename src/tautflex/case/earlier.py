"""Earlier results in a folder: whether there are any, what they say, and files that a new one leaves behind."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from tautflex.errors import CaseError

RESULTS = "run.nc", "summary.json"


def require_no_results(directory: Path, remedy: str) -> None:
    """Raise CaseError if a folder holds the results of a run."""
    found = [name for name in RESULTS if (directory / name).exists()]
    if found:
        text = f"{directory}: expected a directory without results, got one with {' and '.join(found)}"
        raise CaseError(f"{text}; choose another with -o, or {remedy}")


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
