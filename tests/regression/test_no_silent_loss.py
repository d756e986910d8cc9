"""Every line of a deck counts: without it, twice, or with a field changed the mesh is another or the reader speaks.

Left alone are numbers of elements, which are labels, and in the tables of docs/meshes.md what has no effect.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest

import tautflex as tf
from regression.rich_decks import ABAQUS, NASTRAN

pytestmark = pytest.mark.campaign

# Lines without effect: ends of blocks that others end, conditions that OP=NEW takes away.
IDLE = {
    ".bdf": {"BEGIN BULK"},
    ".inp": {"*END PART", "*END INSTANCE", "*ASSEMBLY, NAME=all", "*END ASSEMBLY", "*END STEP", "*STATIC"}
    | {"*BOUNDARY, AMPLITUDE=a", "right.5, 1, 2", ""},
}
ELEMENTS = ("1, 1, 2, 3, 4", "2, 3, 5", "3, 2, 5", "4, 5", "5, 2", "10, 8", "11, 11, 2", "12, 12, 13", "13, 1, 2, 4")
LABELLED = ("CQUAD4", "CTRIA3", "CROD", "CTUBE", "CONROD", "CBAR", "CBEAM", "CONM1", "CONM2", "CMASS1", "CMASS2")
LABELLED += ("RBE2", "RBE3", "CELAS1", "CELAS2", "CBUSH", "CDAMP1", "CDAMP2", "CVISC")


def fingerprint(path, text: str) -> object:
    """All that a mesh says; None if the reader speaks."""
    path.write_text(text, encoding="utf-8")
    try:
        mesh = tf.read_mesh(path)
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


def changed(line: str, suffix: str) -> Iterator[str]:
    """The line with one of its fields changed."""
    parts = line.split(",")
    label = parts[0] in LABELLED or (suffix == ".inp" and line in ELEMENTS)
    start = 1 if suffix == ".bdf" or line.startswith("*") else 0
    for place in range(start, len(parts)):
        number = re.fullmatch(r"(.*?)([-+]?\d*\.?\d+|\d+\.)(\D*)", parts[place])
        if number is None or (label and place == (1 if suffix == ".bdf" else 0)):
            continue
        value = float(number[2])
        new = f"{value + 0.375:g}" if "." in number[2] else str(int(value) + 1)
        yield ",".join([*parts[:place], f"{number[1]}{new}{number[3]}", *parts[place + 1 :]])


@pytest.mark.parametrize(("suffix", "deck"), [(".bdf", NASTRAN), (".inp", ABAQUS)])
def test_no_line_is_lost_in_silence(suffix, deck, tmp_path, verification_row):
    path = tmp_path / f"deck{suffix}"
    whole = fingerprint(path, deck)
    assert whole is not None
    lines, silent, tried = deck.splitlines(), [], 0
    for number, line in enumerate(lines):
        if line in IDLE[suffix]:
            continue
        for new in ([], *([one] for one in changed(line, suffix))):
            tried += 1
            if fingerprint(path, "\n".join([*lines[:number], *new, *lines[number + 1 :], ""])) == whole:
                silent.append((line, new))
    assert silent == []
    verification_row(f"decks ({suffix}) without a line or with a field changed: silent losses", 0, 0, f"{tried} decks")


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
