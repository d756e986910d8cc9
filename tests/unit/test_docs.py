"""What stands in the README and in docs/ runs, and prints the numbers that stand beside it.

Cells of the tutorials, which the manual runs for their pictures, run here too.

Blocks of a page run in their order, in one folder and with one set of names. ``# -> text`` behind a line says what its
output holds. A comment before a block marks it: ``<!-- test: slow -->``, ``extra PACKAGE`` (skipped without it),
``skip (why)``, ``setup`` and lines of Python that run before it, unseen by readers.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import re
import shlex
from pathlib import Path
from typing import NamedTuple

import pytest

from tautflex.cli import main

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = [page for page in PAGES if not {"generated", "_build"} & set(page.parts)]
BLOCK = re.compile(
    r"(?:<!-- test: ([^\n]*?)(?:\n(.*?))? ?-->\n)?^```(?:{code-cell} )?(\w*)\n(?::[^\n]*\n)*(.*?)^```$", re.S | re.M
)
LANGUAGES = {"python", "console"}


class Block(NamedTuple):
    """A fenced block and its mark."""

    mark: str
    setup: str
    language: str
    text: str


def blocks(page: Path) -> list[Block]:
    found = (Block(*(part or "" for part in match.groups())) for match in BLOCK.finditer(page.read_text("utf-8")))
    return [block for block in found if block.language in LANGUAGES]


def cases():
    for page in PAGES:
        found = blocks(page)
        if found:
            slow = any("slow" in block.mark for block in found)
            jax = any("extra jax" in block.mark for block in found)
            marks = [pytest.mark.slow] * slow + [pytest.mark.jax] * jax
            yield pytest.param(page, id=page.name, marks=marks)


def check_output(text: str, printed: str) -> None:
    """Every promised output is there, in order."""
    place = 0
    for promise in re.findall(r"# -> (.*)$", text, re.M):
        found = printed.find(promise, place)
        assert found >= 0, f"{promise!r} is promised, printed was: {printed[place:]}"
        place = found + len(promise)


@pytest.mark.parametrize("page", list(cases()))
@pytest.mark.filterwarnings("default")
def test_page_runs_and_prints_what_it_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks(page):
        for extra in re.findall(r"extra (\w+)", block.mark):
            if importlib.util.find_spec(extra) is None:
                pytest.skip(f"{extra} is not installed")
        if "skip" in block.mark:
            continue
        exec(block.setup, names)
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            if block.language == "python":
                exec(compile(block.text, page.name, "exec"), names)
            else:
                for line in block.text.splitlines():
                    command, *words = shlex.split(line, comments=True)
                    assert command == "tautflex"
                    assert main(words) == 0, line
        check_output(block.text, printed.getvalue())


def test_nothing_is_left_out():
    """Snippets stand in fences, so that they are seen here; the README has both languages."""
    assert {block.language for block in blocks(PAGES[0])} == LANGUAGES
    for page in PAGES:
        text = re.sub(r"^```.*?^```$|<!--.*?-->", "", page.read_text("utf-8"), flags=re.S | re.M)
        assert not re.search(r"^    (tautflex |import |.*\btf\.\w+\()", text, re.M), page
