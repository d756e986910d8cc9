"""Text of Nastran decks: fields, continuations, replication, includes, case control, coordinate systems."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import MeshError
from tautflex.files.mesh.nastran import read_nastran
from tautflex.files.mesh.nastran.text import cards
from verification import decks

FILM = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4\n"


def fields(text):
    return [(card.name, [text for text in card.fields if text]) for card in cards(enumerate_lines(text))]


def enumerate_lines(text):
    return [(f"line {k}", line) for k, line in enumerate(text.splitlines(), start=1)]


@pytest.mark.parametrize(
    "text",
    [
        "GRID,7,,1.5,2.5,3.5,,123",
        "grid 7 0 1.5 2.5 3.5 0 123",
        "GRID,7 0 1.5 2.5 3.5 0 123",
        "GRID    7               1.5     2.5     3.5             123",
        "GRID*   7                               1.5             2.5\n*       3.5                             123",
        "GRID*,7,,1.5,2.5,*A\n*A,3.5,,123",
        "GRID*   7                               1.5             2.5             *A\n"
        "CROD,1,1,7,7\n*A      3.5                             123",
        "\tGRID\t7\t\t1.5\t2.5\t3.5\t\t123".lstrip(),
        "GRID,7,,1.5,2.5,3.5,,123 $ comment, with commas\nENDDATA and, more\nGRID,8",
    ],
)
def test_ways_to_write_a_card(text):
    name, found = fields(text)[0]
    assert name == "GRID"
    assert [one for one in found if one != "0"] == ["7", "1.5", "2.5", "3.5", "123"]


def test_continuations_belong_to_their_marks():
    text = "SPC1,1,123,1,2,3,4,5,6,+A\nSPC1,2,123,11,12,13,14,15,16,+B\n+B,17\n+A,7,8\nSPC1,3,123,1,2,3,4,5,6\n,9\n"
    found = {card.fields[0]: [f for f in card.fields[2:] if f] for card in cards(enumerate_lines(text))}
    assert found == {"1": list("12345678"), "2": [str(k) for k in range(11, 18)], "3": [*"123456", "9"]}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("SPC1,1,123,1,2,3,4,5,6,7", "8 fields and a continuation mark, got '7'"),
        ("SPC1,1,123,1,2,3,4,5,6,7,8,9", "8 fields and a continuation mark, got 11"),
        ("CROD,1,1,2,3,,,,,+A\n+A,1\n+A,2", "one continuation of a line"),
        ("CROD,1,1,2,3,,,,,+A\n+B,1", "continued by '+B', got none"),
        ("CROD,1,1,2,3,,,,,+A\nCROD,2,1,2,3,,,,,+A\nCROD,3,1,2,3,,,,,X\n+A,1", "got 2 of them"),
        ("+A,1,,,,,,,,+B\n+B,1,,,,,,,,+A", "continue each other only"),
        ("=,*(1)", "got none before"),
        ("=(3)", "got none before"),
        ("GRID,1\n==", "expected '=' or '=(count)'"),
        ("GRID,1,,0.,0.,0.\n=,*(1),==\n=(9999999)", "lines by repetition"),
        ("GRID,1,,0.,0.,0.\n=,*(x),==", "expected a number, got 'x'"),
    ],
)
def test_lines_that_are_not_clear(text, words):
    with pytest.raises(MeshError) as caught:
        [card.require_right() for card in cards(enumerate_lines(text))]
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        f"{'PCOMP   1':<72}KFREQ\n+FREQ   7\n",  # the first column of a mark is free
        f"{'PCOMP   1':<72}+X     0\n+X     0 7\n",
        f"{'PCOMP   1':<72}A\n+A      7\n",
    ],
)
def test_marks_as_programs_write_them(text):
    (card,) = cards(enumerate_lines(text))
    assert (card.get(1), card.get(9), card.wrong) == ("1", "7", "")


@pytest.mark.parametrize("begin", ["BEGIN SUPER=1", "BEGIN BULK SUPER=1", "BEGIN BULK AUXMODEL=2", "begin"])
def test_other_parts_of_a_deck_are_refused(begin):
    """A superelement in front of the bulk data would else be taken for case control."""
    with pytest.raises(MeshError, match="line 3: expected BEGIN BULK, got"):
        read_nastran(f"SOL 101\nCEND\n{begin}\nGRID,1\nBEGIN BULK\n{FILM}")


def test_numbers_of_the_case_control_are_of_ascii():
    with pytest.raises(MeshError, match="expected SPC = number"):
        read_nastran(f"SOL 101\nCEND\nSPC = 6\N{SUPERSCRIPT THREE}\nBEGIN BULK\n{FILM}")


def test_columns_behind_the_fields_may_hold_a_date():
    (card,) = cards(
        enumerate_lines("GRID    3903    0       1.0     1.7320510.0     0       1456            6/20/72\n")
    )
    assert card.wrong == ""


def test_what_has_no_effect_may_have_any_form(tmp_path):
    """DEQATN has commas of its own, idle materials any number of fields."""
    idle = "DEQATN,1,f(a,b,c,d,e,g,h,i,j)=max(a,b,c,d,e,g,h,i,j)\nCBARAO,1,FR,4,.2,.2\nSPOINT,7,THRU,9\n"
    (tmp_path / "mast.bdf").write_text(decks.nastran(decks.HELD + idle), encoding="utf-8")
    assert len(tf.read_mesh(tmp_path / "mast.bdf").beams) == 10


def test_replicated_numbers():
    text = "GRID,1,,.1,5,-1.\n=,*2,=,*(.1),*(-2),=\n=2\n"
    assert [found for _, found in fields(text)] == [
        ["1", ".1", "5", "-1."],
        ["3", "0.2", "3", "-1."],
        ["5", "0.30000000000000004", "1", "-1."],
        ["7", "0.4", "-1", "-1."],
    ]


def test_included_files(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "points.bdf").write_text(FILM.partition("CQUAD4")[0], encoding="utf-8")
    (tmp_path / "sides.bdf").write_text("include 'parts/\n   points.bdf'\n", encoding="utf-8")
    deck = "SOL 103\nCEND\nBEGIN BULK\nINCLUDE 'sides.bdf'\nCQUAD4,1,1,1,2,3,4\nENDDATA\n"
    (tmp_path / "film.bdf").write_text(deck, encoding="utf-8")
    assert tf.read_mesh(tmp_path / "film.bdf").quads.tolist() == [[0, 1, 2, 3]]
    (tmp_path / "sides.bdf").write_text("INCLUDE 'sides.bdf'\n", encoding="utf-8")
    with pytest.raises(MeshError, match="depth of 10"):
        tf.read_mesh(tmp_path / "film.bdf")
    (tmp_path / "parts" / "film.bdf").write_text(deck.replace("sides", "../sides"), encoding="utf-8")
    with pytest.raises(MeshError, match=r"in the folder of the mesh or below, got '../sides.bdf'"):
        tf.read_mesh(tmp_path / "parts" / "film.bdf")
    (tmp_path / "sides.bdf").unlink()
    (tmp_path / "sides.bdf").symlink_to("/etc/passwd")
    with pytest.raises(MeshError, match="in the folder of the mesh"):
        tf.read_mesh(tmp_path / "film.bdf")


def test_an_error_in_an_included_file_names_it(tmp_path):
    (tmp_path / "points.bdf").write_text("GRID,x\n", encoding="utf-8")
    (tmp_path / "film.bdf").write_text("BEGIN BULK\nINCLUDE 'points.bdf'\n", encoding="utf-8")
    with pytest.raises(MeshError, match=r"film.bdf: points.bdf line 1 \('GRID'\): expected an integer, got 'x'"):
        tf.read_mesh(tmp_path / "film.bdf")


HELD = "SPC1,1,123,1\nSPC1,2,123,2\n"


@pytest.mark.parametrize(
    ("control", "step", "held"),
    [
        ("SPC = 2\n", None, ["spc2"]),
        ("SPC(ALL)=1 $ held\n", None, ["spc1"]),
        ("SPC = 1\nSUBCASE 1\nSUBCASE 5\n  SPC = 2\n", 5, ["spc2"]),
        ("SPC = 1\nSUBCASE 1\nSUBCASE 5\n  SPC = 2\n", 1, ["spc1"]),
        ("SUBCASE 1\nSPC = 2\nSUBCASE 2\nSPC = 2\n", None, ["spc2"]),
        ("SPC = 0\n", None, []),
    ],
)
def test_supports_of_the_case_control(control, step, held):
    raw = read_nastran(f"SOL 103\nCEND\n{control}BEGIN BULK\n{FILM}{HELD}", step=step)
    assert [group.name for group in raw.groups if group.directions] == held


@pytest.mark.parametrize(
    ("control", "step", "words"),
    [
        ("", None, "expected SPC = number for the sets 1, 2 of SPC1, got none"),
        ("SPC = 3\n", None, "expected set 3, which SPC = 3 selects"),
        ("SPC = 1\nSUBCASE 1\nSUBCASE 5\nSPC = 2\n", None, "got 1: SPC = 1, 5: SPC = 2; choose one with step"),
        ("SPC = 1\nSUBCASE 1\n", 2, "got 2; choose one of them"),
        ("SPC = skew\n", None, "expected SPC = number, got 'skew'"),
    ],
)
def test_supports_that_are_not_chosen(control, step, words):
    with pytest.raises(MeshError) as caught:
        read_nastran(f"SOL 103\nCEND\n{control}BEGIN BULK\n{FILM}{HELD}", step=step)
    assert words in str(caught.value)


def test_without_case_control_one_set_holds(tmp_path):
    (tmp_path / "film.bdf").write_text(FILM + HELD, encoding="utf-8")
    with pytest.raises(MeshError, match=r"groups spc1, spc2: expected a case control .*names = \{spc2 = 'ignore'\}"):
        tf.read_mesh(tmp_path / "film.bdf")
    (support,) = tf.read_mesh(tmp_path / "film.bdf", {"spc2": "ignore"}).supports
    assert support.nodes == (0,)


@pytest.mark.parametrize(
    ("card", "place"),
    [
        ("CORD2R,5,,1.,2.,3.,1.,2.,4.\n,1.,3.,3.\n", [1.0 - 3.0, 2.0 + 2.0, 3.0 + 4.0]),
        ("CORD2C,5,,1.,2.,3.,1.,2.,4.\n,2.,2.,3.\n", [1.0, 2.0 + 2.0, 3.0 + 4.0]),
        ("CORD2S,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n", [0.0, 0.0, -2.0]),
        ("CORD1R,5,2,12,13\nGRID,12,,1.,0.,5.\nGRID,13,,1.,1.,0.\n", [1.0 - 3.0, 2.0, 4.0]),
        ("CORD1C,9,2,12,13,5,2,12,13\nGRID,12,,1.,0.,5.\nGRID,13,,2.,0.,0.\n", [1.0, 2.0, 4.0]),
        ("CORD2R,6,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\nCORD2C,5,6,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n", [-2.0, 0.0, 4.0]),
    ],
)
def test_points_in_coordinate_systems(card, place):
    """Point (2, 3, 4), or radius 2 at an angle of 90 degrees (from z: 180)."""
    angle = {"CORD2C": "90.", "CORD1C": "90.", "CORD2S": "180."}
    kind = next((kind for kind in angle if card.startswith(kind) or f"\n{kind}" in card), "")
    point = f"GRID,4,5,2.,{angle.get(kind, '3.')},{'0.' if kind == 'CORD2S' else '4.'}\n"
    raw = read_nastran(FILM.replace("GRID,4,,0.,1.,0.\n", point) + card)
    np.testing.assert_allclose(raw.nodes[3], place, atol=1e-14)


@pytest.mark.parametrize(
    ("card", "words"),
    [
        ("CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n", "three points that are not on a line"),
        ("CORD2R,5,5,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n", "got 5 by itself"),
        ("CORD1R,5,2,3,4\n", "got 5 by itself"),
        ("CORD2R,5,7,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n", "coordinate system, got 7"),
        ("", "coordinate system, got 5"),
    ],
)
def test_coordinate_systems_that_points_cannot_use(card, words):
    with pytest.raises(MeshError) as caught:
        read_nastran(FILM.replace("GRID,4,,", "GRID,4,5,") + card)
    assert words in str(caught.value)


def test_supports_in_turned_directions():
    system = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,{}\nSPC1,1,{},3\n"
    deck = FILM.replace("GRID,3,,1.,1.,0.", "GRID,3,,1.,1.,0.,5")
    held = [group for group in read_nastran(deck + system.format("0.,1.,0.", "16")).groups if group.directions]
    assert [group.directions for group in held] == [("y", "rz")]
    held = [group for group in read_nastran(deck + system.format("1.,1.,0.", "123")).groups if group.directions]
    assert [group.directions for group in held] == [("x", "y", "z")]
    (slanted,) = [group for group in read_nastran(deck + system.format("1.,1.,0.", "1")).groups if group.links]
    assert [way for _, way, _ in slanted.links[0].link.terms] in (["x", "y"], ["y", "x"])
    around = (
        deck.replace("GRID,3,,1.,1.,0.,5", "GRID,3,,0.,1.,0.,6")
        + "CORD2C,6,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nSPC1,1,1,3\n"
    )
    held = [group for group in read_nastran(around).groups if group.directions]
    assert [group.directions for group in held] == [("y",)]  # the radius at this point


def test_orientation_of_beams():
    """Plane 1 is local y: local z is normal to beam and vector; by vector, by point, by default, in turned axes."""
    points = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.,5\nGRID,3,,2.,0.,0.\nGRID,4,,3.,0.,0.\nGRID,9,,0.,0.,7.\n"
    beams = "CBAR,1,1,1,2,0.,1.,0.\nCBAR,2,1,2,3,1.,0.,0.\nCBEAM,3,2,3,4,9\nCBAR,4,,1,3\nCROD,5,4,1,4\n"
    system = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"
    raw = read_nastran(points + beams + system + "BAROR,,8,,,0.,0.,-1.\n")
    wanted = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]
    found = raw.orientation / np.linalg.norm(raw.orientation, axis=1)[:, None]
    np.testing.assert_allclose(found[:4], wanted, atol=1e-15)
    assert np.isnan(found[4]).all()
    assert sorted({group.name for group in raw.groups}) == ["pid1", "pid2", "pid4", "pid8"]
    with pytest.raises(MeshError, match="vector across the beam"):
        read_nastran(points + beams + system + "CBAR,6,1,1,2,1.,0.,0.\n")


def test_sections_bend_the_way_the_deck_says(tmp_path):
    """A mast along x whose I1 is 4 times I2: plane 1 holds z, so it is the stiffer one."""
    bars = "".join(f"CBAR,{k},1,{k},{k + 1},0.,0.,1.\n" for k in range(1, 11))
    grids = "".join(f"GRID,{k + 1},,{k / 10},0.,0.\n" for k in range(11))
    (tmp_path / "mast.bdf").write_text(grids + bars + "SPC1,1,123456,1\n", encoding="utf-8")
    section = tf.BeamSection(tf.Material(7e10, 2700.0, 0.33), 1e-4, 1e-9, 4e-9, 1e-9)  # inertia_z is I1
    modes = tf.solve_modes(tf.solve_prestress(tf.read_mesh(tmp_path / "mast.bdf").model(beam=section)), n=2)
    assert modes.frequencies[1] / modes.frequencies[0] == pytest.approx(2.0, rel=1e-3)
    soft, stiff = np.abs(modes.vectors[:, -6:])
    assert soft[1] > 1e3 * soft[2]
    assert stiff[2] > 1e3 * stiff[1]


def test_second_order_films():
    """A quadrilateral of 8 nodes is two curved triangles of the same area."""
    nodes = [(0, 0), (2, 0), (2, 1), (0, 1), (1, -0.1), (2, 0.5), (1, 1.1), (0, 0.5)]
    grids = "".join(f"GRID,{k},,{x},{y},0.\n".replace(",0,", ",0.,") for k, (x, y) in enumerate(nodes, start=1))
    raw = read_nastran(grids + "CQUAD8,1,1,1,2,3,4,5,6\n,7,8\n")
    np.testing.assert_allclose(raw.nodes[8], [1.0, 0.5, 0.0])
    model = tf.Model.from_mesh(
        raw.nodes, triangles=raw.elements["triangles"], membrane=tf.MembraneSection(tf.Material(1.0, 1.0), 1.0)
    )
    assert model.mass == pytest.approx(2.0 + 2.0 * (2.0 / 3.0) * 2.0 * 0.1, rel=1e-12)
    assert raw.groups[0].of("triangles").tolist() == [0, 1]
    again = read_nastran(grids + "CTRIA6,1,1,1,2,4,5,9,8\nGRID,9,,1.,.5,0.\n")
    assert again.elements["triangles"].tolist() == [[0, 1, 3, 4, 8, 7]]
    with pytest.raises(MeshError, match="film of one order, got elements 1 of 3 nodes and 1 of 6 nodes"):
        read_nastran(grids + "GRID,9,,1.,.5,0.\nCTRIA6,1,1,1,2,4,5,9,8\nCTRIA3,2,1,2,3,4\n")


def test_films_that_bend_are_asked_for(tmp_path):
    path = tmp_path / "film.bdf"
    path.write_text(FILM + "PSHELL,1,1,1.-4,1\n", encoding="utf-8")
    with pytest.raises(
        MeshError, match=r"group 'pid1': expected membranes, got shells.*names = \{'pid1': 'membrane'\}"
    ):
        tf.read_mesh(path)
    assert len(tf.read_mesh(path, {"pid1": "membrane"}).quads) == 1
    path.write_text(FILM + "PSHELL,1,1,1.-4\n", encoding="utf-8")
    assert len(tf.read_mesh(path).quads) == 1


MAST = "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.,5\nCBAR,1,1,1,2\nCORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\n"
TENSOR = np.array([[0.5, -0.01, -0.02], [-0.01, 0.6, -0.03], [-0.02, -0.03, 0.7]])
QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # axes of system 5 as rows


@pytest.mark.parametrize(
    ("cards", "mass", "inertia", "offset"),
    [
        ("CONM2,9,2,,2.5\n", 2.5, 0.0 * TENSOR, [0.0, 0.0, 0.0]),
        ("CONM2,9,2,,2.5,.1,.2,.3\n,.5,.01,.6,.02,.03,.7\n", 2.5, TENSOR, [0.1, 0.2, 0.3]),
        ("CONM2,9,2,-1,2.5,.1,.2,.3\n,.5,.01,.6,.02,.03,.7\n", 2.5, TENSOR, [-0.9, 0.2, 0.3]),
        ("CONM2,9,2,5,2.5,.1,.2,.3\n,.5,.01,.6,.02,.03,.7\n", 2.5, QUARTER.T @ TENSOR @ QUARTER, [-0.2, 0.1, 0.3]),
        ("CONM2,9,2,,2.5\nPARAM,WTMASS,.1\n", 0.25, 0.0 * TENSOR, [0.0, 0.0, 0.0]),
        (
            "CMASS2,1,2.5,2,1\nCMASS2,2,2.5,2,2\nCMASS2,3,2.5,2,3\nCMASS1,4,7,2,4\nPMASS,7,.5,8,.25\n",
            2.5,
            np.diag([0.0, 0.5, 0.0]),
            [0.0, 0.0, 0.0],
        ),
        (
            "CONM1,9,2,5,2.,0.,2.,0.,0.\n,2.,0.,-.6,.4,1.3,.6,0.,-.2\n,-.04,1.2,-.4,.2,0.,-.06,-.12,1.1\n",
            2.0,
            QUARTER.T @ (np.diag([1.3, 1.2, 1.1]) - 2.0 * np.diag([0.13, 0.10, 0.05])) @ QUARTER,
            [-0.2, 0.1, 0.3],
        ),
    ],
)
def test_point_masses(cards, mass, inertia, offset, tmp_path):
    """Offsets and inertias in their systems; CONM1 is of the same body about the grid point: -m (x y) = -.04 ..."""
    (tmp_path / "mast.bdf").write_text(MAST + cards, encoding="utf-8")
    (body,) = tf.read_mesh(tmp_path / "mast.bdf").masses
    assert (body.node, body.mass) == (1, pytest.approx(mass))
    np.testing.assert_allclose(body.tensor, inertia, atol=1e-14)
    np.testing.assert_allclose(body.arm, offset, atol=1e-14)


@pytest.mark.parametrize(
    ("cards", "words"),
    [
        ("CMASS2,1,2.5,2,1\n", "the same mass along all three directions, got [2.5, 0.0, 0.0]"),
        ("CMASS2,1,2.5,2,1,1,1\n", "field 6 to be blank"),
        ("CMASS1,1,7,2,1\n", "expected a PMASS 7"),
        ("CMASS2,1,2.5,2,7\n", "component from 1 to 6"),
        ("CONM2,9,7,,2.5\n", "existing grid point, got 7"),
        ("CONM2,9,2,6,2.5\n", "coordinate system, got 6"),
        ("CONM2,9,2,,-2.5\n", "mast.bdf: line 6 ('CONM2'): mass: expected a number >= 0"),
        ("CONM2,9,2,,2.5\nPARAM,WTMASS,0.\n", "a factor > 0"),
        ("CONM1,9,2,,2.,1.,2.\n", "matrix of a rigid body"),
        ("GRID,3,,2.,0.,0.\nCONM2,9,3,,2.5\n", "at a node of an element"),
        ("CONM2,9,2,,1.,,,,1.\n", "field 9 to be blank"),
    ],
)
def test_point_masses_that_are_refused(cards, words, tmp_path):
    (tmp_path / "mast.bdf").write_text(MAST + cards, encoding="utf-8")
    with pytest.raises(MeshError) as caught:
        tf.read_mesh(tmp_path / "mast.bdf")
    assert words in str(caught.value)


def test_units_of_masses(tmp_path):
    (tmp_path / "mast.bdf").write_text(MAST + "CONM2,9,2,,2.5,.1\n,.5,,.6,,,.7\n", encoding="utf-8")
    with pytest.raises(MeshError, match=r"expected unit_mass beside unit_length = 0.001"):
        tf.read_mesh(tmp_path / "mast.bdf", unit_length=1e-3)
    (body,) = tf.read_mesh(tmp_path / "mast.bdf", unit_length=1e-3, unit_mass=1e3).masses
    assert body.mass == pytest.approx(2.5e3)
    np.testing.assert_allclose(body.arm, [1e-4, 0.0, 0.0])
    np.testing.assert_allclose(np.diag(body.tensor), [0.5e-3, 0.6e-3, 0.7e-3])
