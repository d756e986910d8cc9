"""What a case file says about wrong keys, to the letter: these lines are part of what users see.

Where one changes on purpose, ``python tests/unit/test_golden_case_messages.py`` records them anew; read the difference.
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from tautflex import CaseError
from tautflex.case import parse_case, template
from tautflex.case.build import build_maneuver

M2_TEMPLATE = template("m2-nearest-node")

FILM = """schema = 1
[membrane]
length = 1.0
width = 0.8
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 4000.0
stress_y = 3000.0
"""
RECORD = Path(__file__).with_name("golden_case_messages.json")
ROWS = json.loads(RECORD.read_text(encoding="utf-8"))


def without(text: str, keys: list[str]) -> str:
    """The text of a case without some keys or sections."""
    for key in keys:
        section, _, name = key.partition(".")
        values = tomllib.loads(text)[section]
        start = text.index(f"[{section}]\n")
        end = text.find("\n[", start) + 1 or len(text)
        kept = text[start:end] if name else ""
        lines = [line for line in kept.splitlines() if not name or line.partition("=")[0].strip() != name]
        assert not name or name in values
        text = text[:start] + "\n".join(lines) + "\n" + text[end:]
    return text


def message(row: dict) -> str:
    """What today's code says, without the name of the file."""
    text = without(M2_TEMPLATE if row["case"] == "m2" else FILM, row.get("drop", []))
    with pytest.raises(CaseError) as caught:
        build_maneuver(parse_case(text, row.get("set", [])))
    return str(caught.value).removeprefix("case: ")


@pytest.mark.parametrize("row", ROWS, ids=lambda row: " ".join([*row.get("drop", []), *row.get("set", [])]))
def test_message_to_the_letter(row):
    assert message(row) == row["message"]


if __name__ == "__main__":
    rows = [json.dumps({**row, "message": message(row)}, ensure_ascii=False) for row in ROWS]
    RECORD.write_text("[\n" + ",\n".join(rows) + "\n]\n", encoding="utf-8")
