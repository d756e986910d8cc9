"""The manual without building it: every page is in a contents list, every name on a page, examples are current."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import tautflex as tf
from manual import api

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [path for path in DOCS.rglob("*.md") if not {"generated", "_build"} & set(path.relative_to(DOCS).parts)]
EXAMPLES = sorted((ROOT / "examples" / "gallery").glob("*.py"))


def test_every_page_is_in_a_contents_list():
    listed = {DOCS / "index.md"}
    for page in PAGES:
        for block in re.findall(r"^```\{toctree\}\n(.*?)^```$", page.read_text("utf-8"), re.S | re.M):
            entries = [line for line in block.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{entry}.md").resolve() for entry in entries}
    assert set(PAGES) <= listed, f"in no contents list: {sorted(map(str, set(PAGES) - listed))}"


@pytest.mark.parametrize("page", [*PAGES, ROOT / "README.md"], ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text("utf-8"), flags=re.S | re.M)
    for link in re.findall(r"\]\(([^)#\s]+)", text):
        link = link.strip("<>")
        if not re.match(r"\w+:", link) and "generated" not in link:
            assert (page.parent / link).exists(), f"{page}: {link}"


def test_every_public_name_is_on_one_page():
    placed = [name for names in api.pages().values() for name in names]
    assert len(placed) == len(set(placed))
    assert {*dir(tf), *(f"plot.{name}" for name in dir(tf.plot) if name != "animate")} <= set(placed)


def test_a_name_of_an_unknown_room_is_refused(monkeypatch):
    monkeypatch.setattr(api, "public_names", lambda *_: {"Thing": "attic.thing"})
    with pytest.raises(LookupError, match=r"Thing of tautflex\.attic\.thing stands on no page"):
        api.pages()


def test_there_are_a_dozen_examples():
    assert len(EXAMPLES) >= 12


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples_use_what_there_is(example):
    """They run when the manual is built; here a name that is gone is seen at once."""
    for node in ast.walk(ast.parse(example.read_text("utf-8"))):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "tf":
            assert hasattr(tf, node.attr), node.attr
