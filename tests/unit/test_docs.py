"""What stands in the README files and in docs/ runs, and prints the numbers that stand beside it.

Cells of the tutorials, which the manual runs for their pictures, run here too.

Blocks of a page run in their order, in one folder and with one set of names. ``# -> text`` behind a line says what its
output holds. Sections of case files (toml) are laid over a template and read. A comment before a block marks it:
``<!-- test: slow -->``, ``extra PACKAGE`` (skipped without it), ``case TEMPLATE`` (m2 if not said), ``append FILE``
(which it belongs to), ``skip (why)``, ``setup`` and lines of Python that run before it, unseen by readers. Blocks that
are skipped are read all the same: commands with their options, names of tautflex.
"""

from __future__ import annotations

import contextlib
import importlib.util
import inspect
import io
import re
import shlex
import tomllib
from pathlib import Path
from typing import NamedTuple

import pytest

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.cli import app, main

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), ROOT / "benchmarks" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = [page for page in PAGES if not {"generated", "_build"} & set(page.parts)]
BLOCK = re.compile(
    r"(?:<!-- test: ([^\n]*?)(?:\n(.*?))? ?-->\n)?^```(?:{code-cell} )?([^\n]*)\n(?::[^\n]*\n)*(.*?)^```$", re.S | re.M
)
LANGUAGES = {"python", "console", "toml"}
DIRECTIVES = {"{toctree}", "{include}"}  # Sphinx reads these, with warnings as errors
# Why a block does not run here; whatever else is skipped must be added, with its reason.
SKIPPED = {
    "docs/learning.md": [
        "takes minutes",
        "another environment, a minute of processor time",
        "takes minutes",
        "takes minutes",
        "takes minutes",
    ],
    "docs/reduction.md": ["a slew of your own, and minutes; test_reduced_slews.py runs one like it"],
    "docs/reproduction.md": ["a minute of all cores; test_reproduce_command.py runs it"],
    "docs/studies.md": ["a cluster; test_study_engines.py starts one, kills a worker and adds another"],
}


class Block(NamedTuple):
    """A fenced block and its mark."""

    mark: str
    setup: str
    language: str
    text: str

    @property
    def skipped(self) -> str | None:
        """Why it does not run."""
        found = re.search(r"skip \((.*)\)", self.mark)
        return found and found[1]


def blocks(page: Path) -> list[Block]:
    found = (Block(*(part or "" for part in match.groups())) for match in BLOCK.finditer(page.read_text("utf-8")))
    return [block for block in found if block.language.split(" ")[0] not in DIRECTIVES]


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


def laid_over(base: dict, given: dict) -> dict:
    """A case with sections of another; a section of another kind takes the place of what was there."""
    merged = dict(base)
    for name, value in given.items():
        old = base.get(name)
        both = (
            isinstance(old, dict) and isinstance(value, dict) and old.get("kind") == value.get("kind", old.get("kind"))
        )
        merged[name] = laid_over(old, value) if both else value
    return merged


def read_case(block: Block) -> None:
    """The section of a case file is one; of a page's own file it is the end."""
    own = re.search(r"append (\S+)", block.mark)
    if own:
        with open(own[1], "a", encoding="utf-8") as file:
            file.write(f"\n{block.text}")
        return
    name = (re.search(r"case ([\w-]+)", block.mark) or ["", "m2"])[1]
    import tomli_w

    whole = laid_over(tomllib.loads(template(name)), tomllib.loads(block.text))
    parse_case(tomli_w.dumps(whole))


def commands(text: str) -> list[list[str]]:
    """Words of every line of the console."""
    return [shlex.split(line, comments=True) for line in text.splitlines() if line]


def check_command(words: list[str]) -> None:
    """A line of the console that does not run names what there is: commands, options, targets of make, extras."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    first, *rest = words
    if first == "tautflex":
        function, bound, *_ = app.parse_args(rest, print_error=False, exit_on_error=False)
        assert inspect.signature(function).bind(*bound.args, **bound.kwargs)
    elif first == "make":
        assert all(re.search(rf"^{target}:", (ROOT / "Makefile").read_text("utf-8"), re.M) for target in rest)
    elif "pip" in " ".join(words[:3]):
        asked = re.findall(r"\[(.*?)\]", " ".join(rest))
        assert {extra for names in asked for extra in names.split(",")} <= set(extras)
    else:
        assert first in {"git", "cd", "source", "dask", "python"}, f"{first}: no command that is known here"
        if first == "python" and rest[0].endswith(".py"):
            assert (ROOT / rest[0]).is_file()


def check_names(text: str) -> None:
    """Names of tautflex in a text are public ones."""
    for name in re.findall(r"\btf\.((?:plot\.|learning\.)?[A-Za-z]\w*)", text):
        place = tf
        for part in name.split("."):
            assert hasattr(place, part), f"tf.{name} is no public name"
            place = getattr(place, part)


@pytest.mark.parametrize("page", list(cases()))
@pytest.mark.filterwarnings("default")
def test_page_runs_and_prints_what_it_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks(page):
        for extra in re.findall(r"extra (\w+)", block.mark):
            if importlib.util.find_spec(extra) is None:
                pytest.skip(f"{extra} is not installed")
        if block.skipped:
            continue
        exec(block.setup, names)
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            if block.language == "python":
                exec(compile(block.text, page.name, "exec"), names)
            elif block.language == "toml":
                read_case(block)
            else:
                for words in commands(block.text):
                    check_command(words)
                    assert words[0] != "tautflex" or main(words[1:]) == 0, words
        check_output(block.text, printed.getvalue())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_what_is_skipped_and_said_names_what_there_is(page):
    """Nothing is skipped but what stands in SKIPPED; commands, options and names there and in prose exist."""
    found = blocks(page)
    skipped = [block.skipped for block in found if block.skipped]
    assert skipped == SKIPPED.get(str(page.relative_to(ROOT)), [])
    for block in found:
        for test in re.findall(r"test_\w+\.py", block.skipped or ""):
            assert list((ROOT / "tests").rglob(test)), test
        if block.skipped and block.language == "console":
            for words in commands(block.text):
                check_command(words)
        elif block.skipped:
            compile(block.text, page.name, "exec")
    text = page.read_text("utf-8")
    if page.name != "CHANGELOG.md":  # which tells of names that were
        check_names(text)
        for command in re.findall(r"`tautflex ([a-z]+)[^`]*`", text):
            assert command in app, f"tautflex {command} is no command"


def test_nothing_is_left_out():
    """Snippets stand in fences of a known language, so that they are seen here; the README has both languages."""
    assert {block.language for block in blocks(ROOT / "README.md")} == LANGUAGES - {"toml"}
    for page in PAGES:
        assert {block.language for block in blocks(page)} <= LANGUAGES, page
        text = re.sub(r"^```.*?^```$|<!--.*?-->", "", page.read_text("utf-8"), flags=re.S | re.M)
        assert not re.search(
            r"^    (tautflex |import |from |make |pip |python |\S+ = tf\.|.*\btf\.\w+\()", text, re.M
        ), page
