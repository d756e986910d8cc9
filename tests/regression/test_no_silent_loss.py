"""Every line of a deck counts: without it, or with a field changed, the mesh is another or the reader speaks.

A line and then the same with another real number is neither deck alone: none of both is passed over. Left alone are
numbers of elements, which are labels, and in the tables of docs/meshes.md what has no effect.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest

import tautflex as tf
from regression.rich_decks import ABAQUS, NASTRAN
from regression.small_decks import DECKS, INCLUDED, PART, Deck
from tautflex.files.mesh import abaqus, nastran

pytestmark = pytest.mark.campaign

# Lines without effect: ends of blocks that others end, conditions that OP=NEW takes away.
IDLE = {
    ".bdf": {"BEGIN BULK"},
    ".inp": {"*END PART", "*END INSTANCE", "*ASSEMBLY, NAME=all", "*END ASSEMBLY", "*END STEP", "*STATIC"}
    | {"*BOUNDARY, AMPLITUDE=a", "right.5, 1, 2", ""},
}
ALL = {"rich bdf": Deck(".bdf", NASTRAN), "rich inp": Deck(".inp", ABAQUS), **DECKS}
LABELLED = ("CQUAD4", "CTRIA3", "CROD", "CTUBE", "CONROD", "CBAR", "CBEAM", "CONM1", "CONM2", "CMASS1", "CMASS2")
LABELLED += ("RBE2", "RBE3", "CELAS1", "CELAS2", "CBUSH", "CDAMP1", "CDAMP2", "CVISC")
LABELLED += ("CTRIAR", "CQUADR", "CTRIA6", "CQUAD8", "RBAR", "RBE1")
# Cards of which only the kind and the number are read: their sections must be stated, and say so when used.
DOUBTED = ("PCOMP", "PCOMPG", "PBRSECT", "PBMSECT", "PBCOMP")
DOUBTED += ("MAT2", "MAT3", "MAT8", "MAT9", "MAT10", "MATHP", "MATPOR")


def fingerprint(path, text: str, names: dict[str, str] | None = None) -> object:
    """All that a mesh says; None if the reader speaks."""
    path.write_text(text, encoding="utf-8")
    try:
        mesh = tf.read_mesh(path, names)
    except tf.MeshError:
        return None
    arrays = [mesh.nodes, mesh.triangles, mesh.quads, mesh.cables, mesh.beams, mesh.beam_orientation]
    groups = {name: {k: v.tolist() for k, v in parts.items()} for name, parts in mesh.groups.items()}
    held = [(node, one.directions) for one in mesh.supports for node in one.nodes]
    bodies = [(one.node, one.mass, one.tensor.round(12).tolist(), one.arm.round(12).tolist()) for one in mesh.masses]
    joined = [
        (type(one).__name__, *(np.asarray(value, dtype=object).tolist() for value in vars(one).values()))
        for one in (*mesh.links, *mesh.springs, *mesh.dampers)
    ]
    sections = {name: (one.kind, dict(one.values), one.doubt) for name, one in mesh.sections.items()}
    spread = [
        {part: one.tolist() for part, one in own.items()}
        for own in (mesh.initial_stress, mesh.free_strain, mesh.nonstructural_mass)
    ]
    whole = [np.round(array, 12).tolist() for array in arrays]
    return whole, groups, sorted(held), bodies, joined, sections, spread


def changed(line: str, suffix: str, labels: set[str]) -> Iterator[str]:
    """The line with one of its fields changed."""
    parts = line.split(",")
    label = parts[0] in LABELLED or line in labels
    start = 1 if suffix == ".bdf" or line.startswith("*") else 0
    for place in range(start, len(parts)):
        number = re.fullmatch(r"(.*?)([-+]?\d*\.?\d+|\d+\.)(\D*)", parts[place])
        if number is None or (label and place == (1 if suffix == ".bdf" else 0)):
            continue
        value = float(number[2])
        new = f"{value + 0.375:g}" if "." in number[2] else str(int(value) + 1)
        yield ",".join([*parts[:place], f"{number[1]}{new}{number[3]}", *parts[place + 1 :]])


def elements(lines: list[str]) -> set[str]:
    """Data lines of elements, whose first field is a label."""
    found, inside = set(), False
    for line in lines:
        if line.startswith("*"):
            inside = line.startswith("*ELEMENT")
        elif inside:
            found.add(line)
    return found


def overridden(lines: list[str]) -> set[int]:
    """Data lines of which a later one holds where their sets overlap."""
    found, inside = set(), False
    for number, line in enumerate(lines):
        if line.startswith("*"):
            inside = line.startswith(("*INITIAL CONDITIONS", "*TEMPERATURE"))
        elif inside:
            found.add(number)
    return found


def real_number(line: str, new: str) -> bool:
    """Whether the field that differs is a real number, not a name, a count or directions."""
    return any("." in one for one, other in zip(line.split(","), new.split(","), strict=True) if one != other)


@pytest.fixture
def read(tmp_path):
    """Return what a deck says, files that it includes beside it."""
    (tmp_path / "part.bdf").write_text(PART, encoding="utf-8")
    (tmp_path / "part.inp").write_text(INCLUDED, encoding="utf-8")

    def of(deck: Deck, lines: list[str]) -> object:
        return fingerprint(tmp_path / f"deck{deck.suffix}", "\n".join([*lines, ""]), deck.names)

    return of


@pytest.mark.parametrize("name", ALL)
def test_no_line_is_lost_in_silence(name, read, verification_row):
    deck = ALL[name]
    lines = deck.text.splitlines()
    whole, labels = read(deck, lines), elements(lines) if deck.suffix == ".inp" else set()
    assert whole is not None
    silent, tried, doubted, later = [], 0, False, overridden(lines)
    for number, line in enumerate(lines):
        doubted = line.split(",")[0] in DOUBTED or (doubted and line.startswith(","))
        if line in IDLE[deck.suffix] | deck.idle:
            continue
        before, after = lines[:number], lines[number + 1 :]
        tried += 1
        if read(deck, [*before, *after]) == whole and not (doubted and line.startswith(",")):
            silent.append((line, "removed"))
        for new in () if doubted else changed(line, deck.suffix, labels):
            tried += 1
            other = read(deck, [*before, new, *after])
            if other == whole:
                silent.append((line, new))
            if not real_number(line, new) or number in later:
                continue
            tried += 1
            both = read(deck, [*before, line, new, *after])
            if both is not None and both in (whole, other):
                silent.append((line, f"and {new}"))
    assert silent == []
    verification_row(f"deck, {name}: silent losses of a line or field", 0, 0, f"{tried} decks")


TABLES = {".bdf": nastran.WORDS, ".inp": abaqus.WORDS}
MISSING = {".bdf": {"MATT1", "MATT2", "MATT8", "MATT9"}, ".inp": set()}  # refused beside temperatures, else unused


@pytest.mark.parametrize("suffix", TABLES)
def test_every_word_that_is_read_stands_in_a_deck(suffix):
    words, missing = TABLES[suffix], MISSING[suffix]
    read_ones = {one.replace("_", " ") for text in words.read.values() for one in text.split()}
    lines = [line for deck in ALL.values() if deck.suffix == suffix for line in deck.text.splitlines()]
    assert read_ones - {re.split(",| '", line)[0].strip("*").upper() for line in lines} == missing


@pytest.mark.parametrize(("suffix", "deck"), [(".bdf", NASTRAN), (".inp", ABAQUS)])
@pytest.mark.parametrize("word", ["NONSENSE", "RSPLINE,9,1,123456,2", "MPC\nLINK, 1, 2", "CELAS1,9,1,1,1,2,1", "NSM"])
def test_no_word_is_lost_in_silence(suffix, deck, word, tmp_path):
    assert fingerprint(tmp_path / f"deck{suffix}", deck) is not None
    first = word if suffix == ".bdf" else f"*{word}"
    lines = deck.splitlines()
    start = lines.index("BEGIN BULK") + 1 if suffix == ".bdf" else 3
    for number in range(start, len(lines), 5):
        if suffix == ".bdf" or lines[number].startswith("*"):
            text = "\n".join([*lines[:number], first, *lines[number:], ""])
            assert fingerprint(tmp_path / f"deck{suffix}", text) is None
