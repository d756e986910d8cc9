"""Sections [[links]] and [[springs]] of a case file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

import tautflex as tf
from tautflex import CaseError
from tautflex.case.registry import LINKS
from verification.builders import FILM_CASE

JOINTS = """
[[links]]
kind = "rigid"
reference_near = [0.0, 0.0]
near = [[0.25, 0.0], [-0.25, 0.0]]
[[links]]
kind = "equation"
terms = [[6, "z", 1.0], [8, "z", -1.0]]
[[springs]]
near = [0.0, 0.2]
stiffness = [0.0, 0.0, 50.0]
"""


@pytest.fixture
def case(tmp_path):
    def load(text: str) -> tf.Case:
        path = tmp_path / "film.toml"
        path.write_text(FILM_CASE + text, encoding="utf-8")
        return tf.load_case(path)

    return load


def test_joints_by_number_and_place(case):
    loaded = case(JOINTS)
    again = tf.Case(**loaded.model_dump(by_alias=True, exclude_none=True))
    assert again == loaded
    assert "links" in repr(loaded)
    model = tf.build_model(loaded)
    assert [type(link).__name__ for link in model.links] == ["RigidLink", "LinkEquation"]
    rigid = model.links[0]
    assert model.nodes[[rigid.reference, *rigid.nodes]].tolist() == [[0, 0, 0], [0.25, 0, 0], [-0.25, 0, 0]]
    assert model.springs[0].stiffnesses.tolist() == [0.0, 0.0, 50.0, 0.0, 0.0, 0.0]
    plain = tf.build_model(case(""))
    one, other = (tf.solve_modes(tf.solve_prestress(each), n=2).frequencies[0] for each in (model, plain))
    assert one > 1.1 * other
    run = tf.run_case(loaded)
    assert run.status.value == "completed"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[links]]\nkind = 'weld'\n", ["links", "'rigid'"]),
        ("[[links]]\nkind = 'rigid'\nreference = 1\n", ["links", "nodes: missing"]),
        ("[[links]]\nkind = 'rigid'\nnodes = [1]\n", ["links", "reference", "got neither"]),
        ("[[links]]\nkind = 'rigid'\nreference = 1\nnodes = [1]\n", ["links", "each once"]),
        ("[[links]]\nkind = 'tie'\nreference = 1\nnodes = [2]\ndirections = ['w']\n", ["links", "directions", "'w'"]),
        ("[[links]]\nkind = 'equation'\nterms = [[1, 'z', 0.0]]\n", ["links", "terms", "other than 0"]),
        ("[[springs]]\nstiffness = 1.0\n", ["springs", "got neither"]),
    ],
)
def test_what_a_case_cannot_say(case, text, words):
    with pytest.raises(CaseError) as caught:
        case(text)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[links]]\nkind = 'rigid'\nreference = 1000\nnodes = [1]\n", "links[0]: expected node numbers"),
        ("[[links]]\nkind = 'rigid'\nreference = 12\nnear = [9.0, 0.0]\n", "links[0].near"),
        ("[[springs]]\nnodes = [12]\nstiffness = 1.0\n", "springs[0].stiffness"),
    ],
)
def test_what_a_structure_cannot_have(case, text, words):
    loaded = case(text)
    with pytest.raises(tf.InputError) as caught:
        tf.build_model(loaded)
    assert words in str(caught.value)


QUADS = """
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
GRID,5,,2.,0.,0.
GRID,6,,2.,1.,0.
CQUAD4,1,1,1,2,3,4
CQUAD4,2,1,2,5,6,3
PSHELL,1,1,1e-4
MAT1,1,3.e9,,.3,1500.
SPC1,1,123456,1,4
"""


def test_sides_of_films_of_quadrilaterals(tmp_path):
    """Joints of a case with a mesh are placed before there is a model."""
    (tmp_path / "film.bdf").write_text(QUADS, encoding="utf-8")
    case = tmp_path / "film.toml"
    links = "[[links]]\nkind = 'rigid'\nreference_near = [2.0, 0.0]\nside = '+x'\n"
    head = "schema = 1\n[mesh]\nfile = 'film.bdf'\n[membrane]\nedges = 'fixed'\nstress_x = 1e5\nstress_y = 1e5\n"
    case.write_text(head + links.replace("side = '+x'", "nodes = [5]"), encoding="utf-8")
    by_number = tf.build_model(tf.load_case(case)).links
    case.write_text(head + "[[links]]\nkind = 'tie'\nreference_near = [1.0, 0.0]\nside = '+x'\n", encoding="utf-8")
    by_side = tf.build_model(tf.load_case(case)).links
    assert (by_number[0].reference, by_side[0].reference) == (4, 1)
    assert set(by_side[0].nodes) == {4, 5}


@dataclass(frozen=True)
class Mirrored(tf.Link):
    """Node that moves across the film against another one.

    Parameters
    ----------
    node
        Number of the node that follows.
    other
        Number of the other.
    """

    node: int
    other: int
    kind: ClassVar[str] = "mirrored-nodes"

    @property
    def joined(self) -> tuple[int, ...]:
        return self.node, self.other

    def follows(self, structure: Any) -> Iterator[Any]:
        yield (self.node, 2), (((self.other, 2), -1.0),)


def test_a_link_from_outside(case, monkeypatch):
    monkeypatch.setattr(LINKS, "_classes", dict(LINKS._classes))  # forgotten again for other tests
    tf.register(Mirrored)
    model = tf.build_model(case("[[links]]\nkind = 'mirrored-nodes'\nnode = 6\nother = 8\n"))
    modes = tf.solve_modes(tf.solve_prestress(model), n=2)
    assert modes.shapes[0, 6, 2] == pytest.approx(-modes.shapes[0, 8, 2])
    assert abs(modes.shapes[0, 6, 2]) > 0.0
