"""Abaqus decks with hinges, ties and embedded elements, against merged meshes and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import MeshError
from verification import decks
from verification.decks import CLAMPED_CLAMPED, CLAMPED_FREE, beam_frequency, frequencies

STRESS = "*Initial conditions, type=STRESS\nleft, 1e6, 1e6\nright, 1e6, 1e6\n"
FILM = (
    "*Membrane section, elset=left, material=m\n1e-4\n*Membrane section, elset=right, material=m\n1e-4\n"
    f"*Material, name=m\n*Elastic\n3.5e9, 0.34\n*Density\n1530.\n{STRESS}*Boundary\nedge, PINNED\n"
)


@pytest.fixture
def read(tmp_path):
    def from_text(text, **options):
        path = tmp_path / "deck.inp"
        path.write_text(text, encoding="utf-8")
        return tf.read_mesh(path, **options)

    return from_text


@pytest.mark.parametrize("free", ["ALLM", "M1-M2"])
def test_hinge_at_mid_span(free, read, verification_row):
    """Two cantilevers of half the length: 4 times the frequency of one."""
    held = "*Boundary\nroot, ENCASTRE\ntip, ENCASTRE\n"
    found = frequencies(read(decks.abaqus(f"*Release\n5, S2, {free}\n", held)))[0]
    wanted = beam_frequency(4.0 * CLAMPED_FREE)
    verification_row(f"deck, RELEASE {free} at mid-span: first frequency [Hz]", wanted, found, "Euler-Bernoulli beam")
    assert found == pytest.approx(wanted, rel=1e-4)


def test_a_hinge_about_one_axis(read):
    """The other plane is clamped on both sides; n1 = z is local y, about which M1 turns, in the plane of x and y."""
    section = (
        "*Beam section, elset=B31, material=al, section=GENERAL\n1e-4, 8.33e-10, 0., 33.32e-10, 1e-9\n0., 0., 1.\n"
    )
    held = "*Boundary\nroot, ENCASTRE\ntip, ENCASTRE\n"
    for free, hinged in (("M1", 1.0), ("M2", 2.0)):
        mesh = read(decks.abaqus(f"{section}*Release\n5, S2, {free}\n", held))
        found = tf.solve_modes(tf.solve_prestress(mesh.model()), n=4).frequencies
        other = 3.0 - hinged
        wanted = sorted([hinged * beam_frequency(4.0 * CLAMPED_FREE), other * beam_frequency(CLAMPED_CLAMPED)])
        np.testing.assert_allclose(found[:1], wanted[:1], rtol=1e-3)
        assert min(abs(found / wanted[1] - 1.0)) < 1e-3


def halves(rows, first_of_right):
    """Film of 2 m x 1 m in two halves, the right one with so many rows of cells, numbered from some number on."""
    nodes, elements, edge = [], [], []
    number, element = 1, 1
    for name, across, x0 in (("left", 4, 0.0), ("right", rows, 1.0)):
        number = 1 if name == "left" else first_of_right
        grid = {}
        for i in range(5):
            for j in range(across + 1):
                grid[i, j] = number
                x, y = x0 + i / 4, j / across
                nodes.append(f"{number}, {x}, {y}, 0.")
                if x in (0.0, 2.0) or y in (0.0, 1.0):
                    edge.append(number)
                number += 1
        elements.append(f"*Element, type=M3D4, elset={name}")
        for i in range(4):
            for j in range(across):
                corners = grid[i, j], grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]
                elements.append(f"{element}, {', '.join(map(str, corners))}")
                element += 1
    # The edge along x = 1 is E4 of the right half's first elements, E2 of the left half's last ones.
    elements.append(
        f"*Elset, elset=seam_right, generate\n17, {16 + rows}, 1\n*Elset, elset=seam_left, generate\n13, 16, 1"
    )
    text = "\n".join(["*Node", *nodes, *elements, ""])
    return text, edge


TIED = "*Surface, name=a\nseam_right, E4\n*Surface, name=b\nseam_left, E2\n*Tie, name=t, adjust=no\na, b\n"


@pytest.mark.parametrize("name", ["edges", "nodes"])
def held(nodes):
    """Set of the nodes that are held."""
    return "\n".join(["*Nset, nset=edge", *map(str, nodes), ""]) + FILM


NODES = "*Surface, type=NODE, name=a\n101\n102\n103\n104\n105\n*Surface, name=b\nleft, SPOS\n*Tie, name=t\na, b\n"


@pytest.mark.parametrize("tie", [TIED, NODES])
def test_films_tied_along_matching_edges_are_one_film(tie, read):
    text, edge = halves(4, 101)
    same = {str(101 + j): str(21 + j) for j in range(5)}
    kept = [line for line in text.splitlines() if not (line.split(",")[0] in same and "1.0" in line)]
    merged = "\n".join(", ".join(same.get(part, part) for part in line.split(", ")) for line in kept) + "\n"
    # What is held leads nothing: the ends of the seam are held on the left only.
    edge = [node for node in edge if str(node) not in same]
    wanted = tf.solve_modes(tf.solve_prestress(read(merged + held(edge)).model()), n=4).frequencies
    mesh = read(text + tie + held(edge))
    assert len(mesh.links) == 5
    assert tf.solve_modes(tf.solve_prestress(mesh.model()), n=4).frequencies == pytest.approx(wanted, rel=1e-9)


def test_films_of_other_meshes_tied_along_an_edge(read, verification_row):
    """f = sqrt(stress / density (1 / a^2 + 1 / b^2)) / 2 of a film of a x b."""
    text, edge = halves(8, 101)
    mesh = read(text + TIED + held([node for node in edge if node not in (101, 109)]))
    assert len(mesh.links) == 5 + 3 * 4
    model = mesh.model()
    assert model.mass == pytest.approx(1530.0 * 1e-4 * 2.0)
    found = tf.solve_modes(tf.solve_prestress(model), n=1).frequencies[0]
    wanted = 0.5 * np.sqrt(1e6 / 1530.0 * (1.0 + 0.25))
    verification_row("deck, TIE of 4 and 8 cells: film of 2 m x 1 m [Hz]", wanted, found, "closed form")
    assert found == pytest.approx(wanted, rel=0.03)


def embedded(lines):
    nodes = "".join(f"{1 + i + 5 * j}, {i / 4}, {j / 4}, 0.\n" for j in range(5) for i in range(5))
    quads = "".join(
        f"{1 + i + 4 * j}, {a}, {a + 1}, {a + 6}, {a + 5}\n"
        for j in range(4)
        for i in range(4)
        for a in [1 + i + 5 * j]
    )
    rope = "101, 0.125, 0.25, 0.\n102, 0.4, 0.375, 0.\n103, 0.7, 0.6, 0.\n"
    edge = "\n".join(str(1 + i + 5 * j) for j in range(5) for i in range(5) if {i, j} & {0, 4})
    return (
        f"*Node\n{nodes}{rope}*Element, type=M3D4, elset=film\n{quads}*Element, type=T3D2, elset=rope\n21, 101, 102\n"
        f"22, 102, 103\n{lines}*Nset, nset=edge\n{edge}\n*Boundary\nedge, PINNED\n*Initial conditions, type=STRESS\n"
        "film, 1e6, 1e6\nrope, 1e6\n*Membrane section, elset=film, material=m\n1e-4\n"
        "*Solid section, elset=rope, material=m\n1e-5\n*Material, name=m\n*Elastic\n3.5e9, 0.34\n*Density\n1530.\n"
    )


@pytest.mark.parametrize(
    "lines",
    [
        "*Embedded element, host elset=film\nrope\n",
        "*Surface, type=NODE, name=a\n101\n102\n103\n*Surface, name=b\nfilm\n*Tie, name=t\na, b\n",
    ],
)
def test_ropes_in_a_film_move_with_it(lines, read):
    """As `Attachment` of the same nodes."""
    mesh = read(embedded(lines))
    plain = mesh.model(links=(tf.Attachment([25, 26, 27]),))
    wanted = tf.solve_modes(tf.solve_prestress(plain), n=4).frequencies
    found = tf.solve_modes(tf.solve_prestress(mesh.model()), n=4).frequencies
    assert found == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (decks.abaqus("*Release\n5, S2, M3\n"), "expected element or set, S1 or S2, and one of T, M1"),
        (embedded("*Release\n21, S2, ALLM\n"), "expected beams, got others"),
        (embedded("*Tie, name=t\na, b\n"), "expected a *SURFACE, got 'a'"),
        (embedded("*Surface, name=a\nfilm, E5\n"), "expected SPOS, SNEG or an edge E1 to E4"),
        (embedded("*Surface, name=a, type=CUTTING SURFACE\nfilm\n"), "expected TYPE=NODE or ELEMENT"),
        (embedded("*Surface, name=a\nfilm\n*Surface, name=a\nfilm\n"), "a surface of a new name"),
        (embedded("*Surface, name=a\nfilm\n*Tie, name=t\na\n"), "expected two surfaces"),
        (embedded("*Embedded element, host elset=film\nrope\n").replace("0.6, 0.\n", "0.6, 0.01\n"), "beside it"),
        (embedded("*Embedded element, host elset=film, embed node\nrope\n"), "got 'EMBED NODE'"),
    ],
)
def test_joints_that_are_not_read(text, words, read):
    with pytest.raises(MeshError) as caught:
        read(text)
    assert words in str(caught.value)


def test_couplings_of_edges_of_film(read):
    """The nodes of an edge move with a node of their own as one body."""
    point = "*Node\n200, 2., 0.5, 0.\n*Nset, nset=hub\n200\n"
    surface = (
        "*Surface, name=a\nseam_left, E2\n*Coupling, constraint name=c, ref node=200, surface=a\n*Kinematic\n1, 3\n"
    )
    text, edge = halves(4, 101)
    (link,) = read(text + point + surface + held(edge).replace("edge, PINNED", "1, PINNED")).links
    assert isinstance(link, tf.RigidLink)
    assert len(link.nodes) == 5
