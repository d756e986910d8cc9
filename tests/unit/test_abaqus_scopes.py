"""Abaqus and CalculiX input: scopes, instances, steps, directions, includes."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import MeshError
from tautflex.files.mesh.abaqus import read_abaqus

WING = """*PART, NAME=Wing
*NODE, NSET=all
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
*ELEMENT, TYPE=M3D4, ELSET=skin
1, 1, 2, 3, 4
*ELEMENT, TYPE=B31, ELSET=spar
2, 1, 2
*BEAM SECTION, ELSET=spar, SECTION=RECT, MATERIAL=m
0.1, 0.1
0., 1., 0.
*NSET, NSET=root
1, 4
*END PART
"""
TWO = (
    WING
    + """*ASSEMBLY, NAME=a
*INSTANCE, NAME=right, PART=Wing
1., 0., 0.
*END INSTANCE
*INSTANCE, NAME=left, PART=Wing
1., 0., 0.
0., 0., 0., 0., 0., 1., 180.
*END INSTANCE
*NSET, NSET=roots, INSTANCE=right
root
*NSET, NSET=roots, INSTANCE=left
root
*END ASSEMBLY
*BOUNDARY
roots, ENCASTRE
"""
)


@pytest.fixture
def read(tmp_path):
    def from_text(text, names=None, **options):
        (tmp_path / "mesh.inp").write_text(text, encoding="utf-8")
        return tf.read_mesh(tmp_path / "mesh.inp", names, **options)

    return from_text


def test_instances_in_their_places(read):
    """Shifted by 1 along x, then turned about z by half a turn: the wings are each other's mirror image."""
    mesh = read(TWO)
    np.testing.assert_allclose(mesh.nodes[:4], [[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]], atol=1e-15)
    np.testing.assert_allclose(mesh.nodes[4:], -mesh.nodes[:4], atol=1e-15)
    assert mesh.quads.tolist() == [[0, 1, 2, 3], [4, 5, 6, 7]]
    assert mesh.supports[0].nodes == (0, 3, 4, 7)
    assert mesh.groups["right.skin"]["quads"].tolist() == [0]
    assert mesh.groups["left.skin"]["quads"].tolist() == [1]
    assert mesh.groups["roots"]["nodes"].tolist() == [0, 3, 4, 7]
    np.testing.assert_allclose(mesh.beam_orientation, [[0, 0, 1], [0, 0, 1]], atol=1e-15)  # t x n1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TWO.replace("roots, ENCASTRE", "root, ENCASTRE"), "got 'root'; write right.root"),
        (TWO.replace("roots, ENCASTRE", "right.tip, 1"), "got 'tip'"),
        (TWO.replace("INSTANCE=left\n", "INSTANCE=middle\n"), "expected an instance above, got 'middle'"),
        (TWO.replace("NAME=left, PART=Wing", "NAME=right, PART=Wing"), "instance 'right': defined twice"),
        (TWO.replace("NAME=left, PART=Wing", "NAME=left, PART=Tail"), "got part 'Tail'"),
        (TWO.replace("0., 0., 0., 0., 0., 1., 180.", "0., 0., 0., 0., 0., 0., 180."), "axis through two points"),
        (TWO.replace("0., 0., 0., 0., 0., 1., 180.", "0., 0., 1., 180."), "lines of [3, 4]"),
        (TWO.replace("0., 1., 0.\n", ""), "direction n1 in a turned instance"),
        (TWO.replace("0., 1., 0.\n", "2., 0., 0.\n"), "direction n1 across the beams"),
        (TWO.replace("SECTION=RECT", "SECTION=ARBITRARY"), "SECTION of RECT"),
        (WING, "instances of the parts, got none"),
        (TWO.replace("*END PART", "*BOUNDARY\nroot, 1\n*END PART"), "outside of parts"),
        (TWO.replace("1, 0, 0, 0", "1, 0, 0, 0, 0, 0, 1"), "expected number, x, y, z"),
        (TWO.replace("ELSET=skin", "ELSET=skin, OFFSET=0.1"), "got 'OFFSET'"),
        (TWO + "*SOMETHING NEW\n", "(SOMETHING NEW): expected a keyword of the tables"),
        (TWO + "*NODE, SYSTEM=C\n", "got 'SYSTEM'"),
        (TWO + "*BOUNDARY, TYPE=VELOCITY\nroots, 1\n", "TYPE=DISPLACEMENT"),
        (TWO + "*BOUNDARY, OP=OLD\nroots, 1\n", "OP=NEW or OP=MOD"),
        (TWO + "*NODE\n1, 0\n*ELEMENT, TYPE=SPRING1\n9, 1\n", "expected *SPRING or *DASHPOT of every such element"),
        (TWO + "*NSET, NSET=b,\n", "rest of a keyword"),
    ],
)
def test_what_does_not_hold_together(text, words, read):
    with pytest.raises(MeshError) as caught:
        read(text)
    assert words in str(caught.value)


FLAT = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
*ELEMENT, TYPE=M3D4, ELSET=skin
1, 1, 2, 3, 4
*NSET, NSET=root
1
*NSET, NSET=tip
3
"""


def held(mesh):
    return {node: support.directions for support in mesh.supports for node in support.nodes}


@pytest.mark.parametrize(
    ("name", "directions"),
    [
        ("ENCASTRE", ("x", "y", "z", "rx", "ry", "rz")),
        ("PINNED", ("x", "y", "z")),
        ("XSYMM", ("x", "ry", "rz")),
        ("ysymm", ("y", "rx", "rz")),
        ("ZSYMM", ("z", "rx", "ry")),
        ("XASYMM", ("y", "z", "rx")),
        ("YASYMM", ("x", "z", "ry")),
        ("ZASYMM", ("x", "y", "rz")),
    ],
)
def test_conditions_with_names(name, directions, read):
    assert held(read(f"{FLAT}*BOUNDARY\nroot, {name}\n")) == {0: directions}


STEPS = """*BOUNDARY
root, 1
*STEP
*STATIC
*BOUNDARY
tip, 2
*END STEP
*STEP
*STATIC
*BOUNDARY, OP=NEW
tip, 3
*END STEP
"""


def test_steps(read):
    assert held(read(FLAT + STEPS, step=1)) == {0: ("x",), 2: ("y",)}
    assert held(read(FLAT + STEPS, step=2)) == {2: ("z",)}
    assert held(read(FLAT + STEPS.replace("*STATIC\n*BOUNDARY\ntip", "*FREQUENCY\n3\n*BOUNDARY\ntip"))) == {
        0: ("x",),
        2: ("y",),
    }
    assert held(read(FLAT + "*BOUNDARY\nroot, 1\n*STEP\n*STATIC\n*END STEP\n*STEP\n*STATIC\n*END STEP\n")) == {
        0: ("x",)
    }
    with pytest.raises(
        MeshError, match=r"steps with the same supports and elements, got others \(1 has 2 cond.*, 2 has 1 .*\)"
    ):
        read(FLAT + STEPS)
    with pytest.raises(MeshError, match="expected step = 1 to 2, a step of the file, got 3"):
        read(FLAT + STEPS, step=3)
    with pytest.raises(MeshError, match="root"):
        read(FLAT + "*BOUNDARY\nroot, 1, 1, 0.5\n")


def test_directions_of_cylinders(read):
    """Radius and tangent at (1, 1) are along the diagonals; at (1, 0) along x and y."""
    around = "*NSET, NSET=two\n2, 3\n*TRANSFORM, NSET=two, TYPE=C\n0., 0., 0., 0., 0., 1.\n*BOUNDARY\n"
    assert held(read(FLAT + around + "2, 1\n3, 1, 2\n")) == {1: ("x",), 2: ("x", "y")}
    assert held(read(FLAT + around + "3, 1\n3, 2\n2, 2\n")) == {1: ("y",), 2: ("x", "y")}
    (along,) = read(FLAT + around + "3, 1\n").links
    (one, _, first), (two, _, second) = along.terms
    assert (one, two) == (2, 2)
    assert first == pytest.approx(second)  # (x + y) is held at (1, 1)
    with pytest.raises(MeshError, match="TYPE=R or C"):
        read(FLAT + around.replace("TYPE=C", "TYPE=S") + "3, 1\n")


def test_sections_of_beams():
    """Without a direction n1 is -z, so that local z is t x (-z)."""
    text = (
        "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 2, 0, 0\n*ELEMENT, TYPE=B31, ELSET=a\n1, 1, 2\n*ELEMENT, TYPE=B31\n2, 2, 3\n"
    )
    raw = read_abaqus(text + "*BEAM SECTION, ELSET=a, SECTION=CIRC\n0.01\n")
    np.testing.assert_allclose(raw.orientation[0], [0.0, 1.0, 0.0], atol=1e-15)
    assert np.isnan(raw.orientation[1]).all()
    raw = read_abaqus(text + "*BEAM GENERAL SECTION, ELSET=a\n1., 1., 0., 1., 1.\n0., 1., 0.\n7e10\n")
    np.testing.assert_allclose(raw.orientation[0], [0.0, 0.0, 1.0], atol=1e-15)


def test_shells_are_asked_for(read):
    shells = FLAT.replace("M3D4, ELSET=skin", "S4R")
    with pytest.raises(MeshError, match=r"group 'S4R': expected membranes, got shells.*names = \{'S4R': 'membrane'\}"):
        read(shells)
    assert len(read(shells, {"S4R": "membrane"}).quads) == 1
    assert len(read(FLAT.replace("M3D4, ELSET=skin", "S4, ELSET=Film of the sail")).quads) == 1


def test_second_order_films(read):
    nodes = "5, .5, 0\n6, 1, .5\n7, .5, 1\n8, 0, .5\n9, .5, .5, .1\n"
    text = FLAT.replace("*ELEMENT", nodes + "*ELEMENT").replace("1, 1, 2, 3, 4", "1, 1, 2, 3, 4, 5, 6, 7,\n8, 9")
    mesh = read(text.replace("M3D4", "M3D9"))
    assert mesh.triangles.tolist() == [[0, 1, 2, 4, 5, 8], [0, 2, 3, 8, 6, 7]]
    assert mesh.groups["skin"]["triangles"].tolist() == [0, 1]
    mesh = read(text.replace("M3D4", "M3D8").replace("8, 9\n", "8\n"))
    np.testing.assert_allclose(mesh.nodes[8], [0.5, 0.5, 0.0])


def test_files_within_files(tmp_path, read):
    (tmp_path / "nodes.csv").write_text(FLAT[6:62].partition("*")[0], encoding="utf-8")
    (tmp_path / "rest.inp").write_text(FLAT[FLAT.index("*ELEMENT") :], encoding="utf-8")
    mesh = read("*NODE, INPUT=nodes.csv\n*INCLUDE,\nINPUT=rest.inp\n*BOUNDARY\ntip, 3\n")
    assert mesh.quads.tolist() == [[0, 1, 2, 3]]
    assert held(mesh) == {2: ("z",)}
    for wrong in ("../x.inp", "/etc/passwd", "rest.inp/x"):
        with pytest.raises(MeshError, match="line 1"):
            read(f"*INCLUDE, INPUT={wrong}\n")
    with pytest.raises(MeshError, match="depth of 10"):
        read("*INCLUDE, INPUT=mesh.inp\n")


BODIES = "*ELEMENT, TYPE=MASS, ELSET=payload\n8, 2\n*ELEMENT, TYPE=ROTARYI, ELSET=wheel\n9, 2\n"
VALUES = "*MASS, ELSET=payload\n2.5\n*ROTARY INERTIA, ELSET=wheel\n0.1, 0.2, 0.3\n"


def test_point_masses(read):
    """In every instance, the inertia turned with it: by a quarter about z it changes axes."""
    text = TWO.replace("180.", "90.").replace("*BEAM", BODIES + VALUES + "*BEAM")
    bodies = read(text).masses
    assert [(one.node, one.mass) for one in bodies] == [(1, 2.5), (1, 0.0), (5, 2.5), (5, 0.0)]
    np.testing.assert_allclose(bodies[1].tensor, np.diag([0.1, 0.2, 0.3]), atol=1e-15)
    np.testing.assert_allclose(bodies[3].tensor, np.diag([0.2, 0.1, 0.3]), atol=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BODIES, "of every point element, got none of 2"),
        (BODIES + VALUES.replace("2.5", "2.5, 1."), "expected one line with a mass"),
        (BODIES + VALUES.replace("0.3", "0.3, 0.1"), "principal moments"),
        (BODIES + VALUES.replace("ELSET=wheel", "ELSET=payload"), "elements of TYPE=ROTARYI"),
        (BODIES + VALUES.replace("ELSET=payload", "ELSET=skin"), "elements of TYPE=MASS"),
        (BODIES + VALUES.replace("ELSET=payload", "ELSET=payload, ALPHA=0.1"), "got 'ALPHA'"),
        (BODIES.replace("9, 2", "9, 2, 3") + VALUES, "expected number and 1 nodes"),
    ],
)
def test_point_masses_that_are_refused(text, words, read):
    with pytest.raises(MeshError) as caught:
        read(FLAT + text)
    assert words in str(caught.value)
