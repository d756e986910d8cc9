"""What all tests share: compiled code is kept but never stale; the verification table.

Tests record rows of the table, ``pytest --verification-table=FILE`` writes them.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import settings

# The same examples in every run of the continuous integration; elsewhere new ones each time.
settings.register_profile("ci", derandomize=True)
if os.environ.get("CI"):
    settings.load_profile("ci")

# Helper modules beside the tests are imported as `verification.builders`.
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tools")]

from house import drop_stale_code  # noqa: E402  (found on the path just made)
from tautflex import compiling  # noqa: E402
from tautflex.case.plugins import LOADED  # noqa: E402

compiling.announced = True  # what a command says does not hang on what was compiled before

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


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--verification-table",
        metavar="FILE",
        default=None,
        help="write the cases that the verification tests recorded to FILE as a Markdown table",
    )


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):  # once, before workers of pytest-xdist start
        drop_stale_code()
    if config.getoption("--verification-table"):
        config.pluginmanager.register(Table(Path(config.getoption("--verification-table"))))
    # JAX compiles for half a minute what it then reads in a second; processes that tests start find it too.
    kept = config.rootpath / ".pytest_cache" / "jax"
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(kept))
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.1")


@pytest.fixture(scope="module", autouse=True)
def plugins_end_with_their_module() -> Iterator[None]:
    """Results of studies are those of the plugins of a process, which here are other tests'."""
    before = dict(LOADED)
    yield
    LOADED.clear()
    LOADED.update(before)


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
        request.node.user_properties.append(("row", tuple(row)))  # workers of pytest-xdist hand these on

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


class Table:
    """Collects the rows and writes them if all tests passed."""

    def __init__(self, target: Path) -> None:
        self.target = target
        self.rows: list[Row] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "teardown":
            self.rows += [Row(*value) for name, value in report.user_properties if name == "row"]

    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        if exitstatus != pytest.ExitCode.OK or hasattr(session.config, "workerinput"):
            return
        lines = [
            f"| {r.case} | {r.expected} | {r.source} | {r.got} | {r.error} | {r.test} |" for r in sorted(self.rows)
        ]
        self.target.write_text(HEADER + "\n".join(lines) + "\n", encoding="utf-8")
