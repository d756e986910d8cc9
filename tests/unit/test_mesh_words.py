"""Every card and keyword is read, without effect, or refused; the page says which. Run this file to rewrite it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tautflex import MeshError
from tautflex.files.mesh import abaqus, nastran

PAGE = Path(__file__).parents[2] / "docs" / "meshes.md"
TABLES = {"cards": nastran.WORDS, "keywords": abaqus.WORDS}


def page() -> str:
    """The page with its tables as the code has them."""
    text = PAGE.read_text(encoding="utf-8")
    for name, words in TABLES.items():
        pattern = rf"<!-- {name} -->.*<!-- end of {name} -->"
        table = f"<!-- {name} -->\n{words.markdown()}\n<!-- end of {name} -->"
        text = re.sub(pattern, lambda found, table=table: table, text, flags=re.S)
    return text


def test_tables_of_the_page_are_those_of_the_code():
    assert PAGE.read_text(encoding="utf-8") == page(), "run `python tests/unit/test_mesh_words.py`"


@pytest.mark.parametrize("words", TABLES.values(), ids=TABLES)
def test_every_word_stands_once(words):
    listed = [one for table in (words.read, words.idle) for text in table.values() for one in text.split()]
    listed += [one for text, _ in words.refused.values() for one in text.split()]
    assert len(listed) == len(set(listed))


@pytest.mark.parametrize("words", TABLES.values(), ids=TABLES)
def test_unknown_words_are_refused(words):
    with pytest.raises(MeshError, match=r"line 3: expected a \w+ of the tables in docs/meshes.md, got 'NONSENSE'"):
        words.is_read("NONSENSE", "line 3")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
