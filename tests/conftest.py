"""The verification table: tests record rows, ``pytest --verification-table=FILE`` writes them."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import settings

# The same examples in every run of the continuous integration; elsewhere new ones each time.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

# Helper modules beside the tests are imported as `verification.builders`.
sys.path.insert(0, str(Path(__file__).parent))

HEADER = """# Verification

Passing tests record these rows; `make verification` rewrites this file.
The error is relative where the expected value is a number other than zero, absolute (abs) where it is zero.

| case | expected | source | got | error | test |
|---|---|---|---|---|---|
"""


class Row(NamedTuple):
    """One verification case."""

    test: str
    case: str
    expected: str
    source: str
    got: str
    error: str


ROWS = pytest.StashKey[list[Row]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--verification-table",
        metavar="FILE",
        default=None,
        help="write the cases that the verification tests recorded to FILE as a Markdown table",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.stash[ROWS] = []


@pytest.fixture
def verification_row(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Record ``verification_row(case, expected, got, source)``; error is derived unless given as text.

    ``expected`` and ``got`` are numbers or short texts; a text leaves the error empty unless it is given.
    """

    def record(case: str, expected: float | str, got: float | str, source: str, error: str | None = None) -> None:
        if error is None:
            error = _error(expected, got)
        if expected == 0 and not isinstance(got, str):
            got = _bound(got)
        texts = [_text(value) for value in (case, expected, source, got, error)]
        path = Path(request.node.path).relative_to(request.config.rootpath / "tests").as_posix()
        row = Row(f"`{path}::{request.node.originalname}`", *texts)
        request.config.stash[ROWS].append(row)

    return record


def _text(value: float | str) -> str:
    text = value if isinstance(value, str) else f"{float(value):.6g}"
    return text.replace("|", "\\|")


def _bound(value: float) -> str:
    """Round-off differs between machines; its power of ten hardly does."""
    return "0" if value == 0 else f"< {10.0 ** math.ceil(math.log10(abs(float(value)))):.0e}"


def _error(expected: float | str, got: float | str) -> str:
    if isinstance(expected, str) or isinstance(got, str):
        return ""
    if expected == 0:
        return f"{_bound(got)} (abs)"
    return f"{abs(float(got) / float(expected) - 1.0):.1e}"


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    target = session.config.getoption("--verification-table")
    if target is None or exitstatus != pytest.ExitCode.OK:
        return
    rows = sorted(session.config.stash[ROWS])
    lines = [f"| {r.case} | {r.expected} | {r.source} | {r.got} | {r.error} | {r.test} |" for r in rows]
    Path(target).write_text(HEADER + "\n".join(lines) + "\n", encoding="utf-8")
