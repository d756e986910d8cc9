from __future__ import annotations

import importlib.util
import os
import re
import stat
import subprocess
import sys

import numpy as np
import pytest

import tautflex as tf
from regression import mesh_files
from tautflex import (
    BeamSection,
    CableSection,
    InputError,
    Material,
    MembraneSection,
    MeshData,
    MeshError,
    MissingExtraError,
    read_mesh,
)
from tautflex.files.mesh.gmsh import reader as gmsh_reader
from tautflex.files.mesh.numerals import natural, real
from tautflex.structure.shapes import QUAD4, TRIANGLE6
from verification.builders import CABLE, FILM, FRAME, THICKNESS, antenna

needs_gmsh = pytest.mark.skipif(not mesh_files.gmsh_starts(), reason="needs Gmsh, of the extra tautflex[mesh]")
FORMATS = [
    pytest.param(".msh", mesh_files.msh, ("membrane", "cables_x", "cables_y", "frame"), marks=needs_gmsh),
    pytest.param(".inp", mesh_files.abaqus, ("FILM", "CABLES-X", "CABLES-Y", "FRAME")),
    pytest.param(".bdf", mesh_files.nastran, ("pid1", "pid2", "pid3", "pid4")),
]

INP = """*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 2, 2, 0
*ELEMENT, TYPE=M3D3, ELSET=skin
1, 1, 2, 3
*ELEMENT, TYPE=T3D2, ELSET=stay
2, 3, 4
*NSET, NSET=support
4
"""
BDF = """BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,2.,2.,0.
CTRIA3,1,1,1,2,3
CROD,2,2,3,4
SPC1,7,123,4
"""
MSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "skin"
1 2 "cable"
0 3 "support"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 2 2 0
$EndNodes
$Elements
3
1 2 2 1 1 1 2 3
2 1 2 2 2 3 4
3 15 2 3 3 4
$EndElements
"""


@pytest.fixture
def read(tmp_path):
    """Read a text as a mesh file of a suffix."""

    def from_text(suffix, text, names=None, **options):
        path = tmp_path / f"mesh{suffix}"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_mesh(path, names, **options)

    return from_text


def sections():
    return {
        "membrane": MembraneSection(FILM, THICKNESS),
        "cable": CableSection(Material(133e9, CABLE.density, 0.36), 3.14e-6),
        "beam": BeamSection(FRAME, 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
    }


@pytest.mark.parametrize(("suffix", "writer", "groups"), FORMATS)
def test_antenna_through_a_file_keeps_its_frequencies(suffix, writer, groups, read, verification_row):
    built = antenna((0.59, 1.0), (10, 5), distribution="equal")
    mesh = read(suffix, writer(built))
    np.testing.assert_array_equal(mesh.nodes, built.nodes)
    tensions = dict(zip(groups[1:3], (0.59 / 5, 1.0 * 2.0 / 10), strict=True))
    tension = mesh.values("cables", tensions)
    again = mesh.model(**sections(), cable_tension=tension, prestress_mode="equilibrium")
    assert again.mass == pytest.approx(built.mass, rel=1e-14)
    wanted, found = (tf.solve_modes(tf.solve_prestress(model), n=6).frequencies for model in (built, again))
    worst = float(np.max(np.abs(found / wanted - 1.0)))
    verification_row(f"antenna written as {suffix} and read back: first six frequencies", 0.0, worst, "round trip")
    assert worst < 1e-12


@pytest.mark.parametrize(("suffix", "writer", "groups"), FORMATS)
def test_groups_and_supports_come_with_the_mesh(suffix, writer, groups, read):
    built = antenna((0.59, 1.0), (4, 2))
    mesh = read(suffix, writer(built))
    assert set(groups) <= set(mesh.groups)
    assert len(mesh.groups[groups[0]]["triangles"]) == len(built.triangles)
    assert len(mesh.groups[groups[1]]["cables"]) == 2 * 3
    assert len(mesh.groups[groups[2]]["cables"]) == 2 * 5
    assert len(mesh.groups[groups[3]]["beams"]) == len(built.beams)
    (support,) = mesh.supports
    assert list(support.nodes) == mesh_files.held_nodes(built)
    assert support.directions == ("x", "y", "z", "rx", "ry", "rz")


@needs_gmsh
@pytest.mark.parametrize(("version", "binary"), [(2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)])
def test_what_gmsh_itself_meshes_and_writes(version, binary, tmp_path):
    """A square of side 2 with a strut at a corner, meshed by Gmsh in a process of its own."""
    script = f"""
import gmsh
gmsh.initialize([], readConfigFiles=False, interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
corners = [gmsh.model.geo.addPoint(x, y, 0, 0.5) for x, y in ((0, 0), (2, 0), (2, 2), (0, 2))]
tip = gmsh.model.geo.addPoint(3, 3, 0, 0.5)
sides = [gmsh.model.geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
strut = gmsh.model.geo.addLine(corners[2], tip)
gmsh.model.geo.mesh.setTransfiniteCurve(strut, 2)
film = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(sides)])
gmsh.model.geo.synchronize()
gmsh.model.addPhysicalGroup(2, [film], name="Film")
gmsh.model.addPhysicalGroup(2, [film], name="membrane again")
gmsh.model.addPhysicalGroup(1, [strut], name="cable")
gmsh.model.addPhysicalGroup(1, sides[3:], name="pinned side")
gmsh.model.addPhysicalGroup(0, [tip], name="Support")
gmsh.model.mesh.generate(2)
gmsh.option.setNumber("Mesh.MshFileVersion", {version})
gmsh.option.setNumber("Mesh.Binary", {binary})
gmsh.write("square.msh")
"""
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, timeout=60)
    mesh = read_mesh(tmp_path / "square.msh")
    corner = mesh.nodes[mesh.triangles]
    area = 0.5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2]
    assert area.sum() == pytest.approx(4.0, rel=1e-14)
    assert mesh.cables.shape == (1, 2)
    assert mesh.beams.shape == (0, 2)
    held = {support.directions: mesh.nodes[list(support.nodes)] for support in mesh.supports}
    np.testing.assert_allclose(held["x", "y", "z", "rx", "ry", "rz"], [[3.0, 3.0, 0.0]])
    np.testing.assert_allclose(held["x", "y", "z"][:, 0], 0.0)
    assert len(held["x", "y", "z"]) == 5
    assert len(mesh.groups["membrane again"]["triangles"]) == len(mesh.triangles)


@needs_gmsh
@pytest.mark.parametrize(("order", "recombine", "kind"), [(2, 0, "triangles"), (1, 1, "quads")])
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_curved_triangles_and_quads_of_gmsh(order, recombine, kind, version, tmp_path):
    """A quarter disc, whose round side is held; its area converges as the sides bend or the cells shrink."""
    script = f"""
import gmsh
gmsh.initialize([], readConfigFiles=False, interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
centre, a, b, tip = [gmsh.model.geo.addPoint(x, y, 0, 0.2) for x, y in ((0, 0), (1, 0), (0, 1), (-1, 0))]
round = gmsh.model.geo.addCircleArc(a, centre, b)
sides = [gmsh.model.geo.addLine(centre, a), round, gmsh.model.geo.addLine(b, centre)]
strut = gmsh.model.geo.addLine(centre, tip)
gmsh.model.geo.mesh.setTransfiniteCurve(strut, 2)
film = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(sides)])
gmsh.model.geo.synchronize()
gmsh.model.addPhysicalGroup(2, [film], name="membrane")
gmsh.model.addPhysicalGroup(1, [round], name="pinned rim")
gmsh.model.addPhysicalGroup(1, [strut], name="beam")
gmsh.option.setNumber("Mesh.RecombineAll", {recombine})
gmsh.model.mesh.generate(2)
gmsh.model.mesh.setOrder({order})
gmsh.option.setNumber("Mesh.MshFileVersion", {version})
gmsh.write("disc.msh")
"""
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, timeout=60)
    mesh = read_mesh(tmp_path / "disc.msh")
    elements, shape = getattr(mesh, kind), {"triangles": TRIANGLE6, "quads": QUAD4}[kind]
    assert elements.shape[1] == len(shape.nodes)
    assert len(mesh.groups["membrane"][kind]) == len(elements)
    assert mesh.beams.shape == (order, 2)  # with a node in its middle, it is two
    rim = mesh.nodes[list(mesh.supports[0].nodes)]
    np.testing.assert_allclose(np.linalg.norm(rim, axis=1), 1.0, rtol=1e-9)
    model = mesh.model(
        membrane=MembraneSection(Material(1.0, 1.0), 1.0), beam=BeamSection(Material(1.0, 1e-9), 1.0, 1.0, 1.0, 1.0)
    )
    assert model.mass == pytest.approx(0.25 * np.pi, rel=1e-4 if order == 2 else 1e-2)


def test_element_types_decide_in_abaqus_and_names_hold_nodes(read):
    mesh = read(".inp", INP)
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    assert mesh.cables.tolist() == [[2, 3]]
    assert mesh.supports[0].nodes == (3,)


def test_boundary_conditions_of_abaqus(read):
    mesh = read(".inp", INP + "*NSET, NSET=two, GENERATE\n1, 1000000000000, 3\n*BOUNDARY\ntwo, PINNED\n2, 3\n")
    held = {support.directions: support.nodes for support in mesh.supports}
    assert held["x", "y", "z"] == (0, 3)
    assert held["z",] == (1,)


def test_parts_of_names_and_instances_of_abaqus(read):
    text = INP.replace("*NODE", "*PART, NAME=a\n*NODE").replace(
        "*NSET", "*END PART\n*INSTANCE, NAME=i, PART=a\n*END INSTANCE\n*NSET"
    )
    mesh = read(".inp", text.replace("\n4\n", "\ni.4\n"))
    assert mesh.supports[0].nodes == (3,)


def test_strange_names_of_sets(read):
    """Found by coverage-guided fuzzing: an instance, a point, and a quoted name with a blank."""
    mesh = read(".inp", INP + '*NSET, NSET=i. "5\n1\n*NSET, NSET=more\ni. "5, 2\n')
    assert mesh.groups["more"]["nodes"].tolist() == [0, 1]


def test_names_of_the_user_come_first(read):
    mesh = read(".inp", INP, {"STAY": "beam", "support": "pinned"})
    assert mesh.beams.tolist() == [[2, 3]]
    assert mesh.supports[0].directions == ("x", "y", "z")
    mesh = read(".bdf", BDF, {"pid2": "ignore", "spc7": "ignore"})
    assert len(mesh.nodes) == 3  # the strut's far end belongs to nothing now
    assert mesh.supports == ()


@needs_gmsh
@pytest.mark.parametrize(
    ("renamed", "names", "lines"),
    [
        (
            {},
            {},
            ["group 'skin': expected a name .*membrane, film, support.*names=\\{'skin': 'membrane'\\} \\(or 'cla"],
        ),
        (
            {"cable": "rim"},
            {},
            [  # a surface is no cable, a line no membrane
                "group 'rim': (?!.*membrane).*begins with one of cable, beam, frame, .*names=\\{'rim': 'cable'\\}",
                "group 'skin': (?!.*(cable|beam)).*begins with one of membrane, film, .*names=\\{'skin': 'membrane'\\}",
            ],
        ),
        (
            {"cable": "rim"},
            {"skinn": "membrane", "rim": "cabel"},  # what they are meant to be is not asked again
            ["names: .*'skin'.*got 'skinn'; did you mean 'skin'", "names: .*'rim' one of .*got 'cabel'; did you mean"],
        ),
        (
            {"cable": "film"},
            {"skin": "beam"},
            ["group 'film': expected lines to be cable or beam, got mem", "group 'skin': expected triangles to be mem"],
        ),
    ],
)
def test_all_groups_of_gmsh_without_a_usable_role_are_told_with_remedies_that_fit(read, renamed, names, lines):
    text = MSH
    for old, new in renamed.items():
        text = text.replace(f'"{old}"', f'"{new}"')
    with pytest.raises(MeshError) as caught:
        read(".msh", text, names)
    assert len(caught.value.problems) == len(lines)
    for told, line in zip(caught.value.problems, lines, strict=True):
        assert re.search(f"mesh.msh: {line}", told), told


@needs_gmsh
def test_a_stated_role_makes_a_group_of_gmsh_what_it_is(read):
    assert len(read(".msh", MSH, {"skin": "membrane"}).triangles) == 1


def test_millimetres(read):
    assert np.abs(read(".bdf", BDF, unit_length=1e-3).nodes).max() == pytest.approx(2e-3)
    with pytest.raises(InputError, match="unit_length"):
        read(".bdf", BDF, unit_length=0.0)


def test_fields_of_nastran(read):
    text = BDF.replace("GRID,4,,2.,2.,0.", "GRID*   4                               2.0             2.0\n*       0.")
    text = text.replace("GRID,2,,1.,0.,0.", "GRID           2             1.0    0.-3   0.0             345")
    mesh = read(".bdf", text.replace("SPC1,7,123,4", "SPC1,7,123,1,THRU,3\nSPC,7,4,6,0.0,1,45\nCBAR,3,9,1,2,0.,0.,1."))
    np.testing.assert_array_equal(mesh.nodes[[1, 3]], [[1.0, 0.0, 0.0], [2.0, 2.0, 0.0]])
    held = {support.directions: support.nodes for support in mesh.supports}
    assert held == {
        ("x", "y", "z"): (1, 2),
        ("rz",): (3,),
        ("x", "y", "z", "rx", "ry"): (0,),
        ("z", "rx", "ry"): (1,),
    }
    assert mesh.beams.tolist() == [[0, 1]]


@pytest.mark.parametrize(
    ("text", "value"), [("1.5-3", 1.5e-3), ("-1.D2", -100.0), (" .5e+1", 5.0), ("", 0.0), ("7", 7.0), ("1.+3", 1e3)]
)
def test_spellings_of_numbers(text, value):
    assert real(text, "line 1") == value


@pytest.mark.parametrize("text", ["nan", "inf", "1_0", "0x1", "²", "1e", "--1", "1.0.0", "1" * 100])
def test_what_is_no_number(text):
    with pytest.raises(MeshError, match="expected a number"):
        real(text, "line 1")


@pytest.mark.parametrize("text", ["1.0", "1_0", "²", "", "9" * 5000, "9223372036854775807"])
def test_what_is_no_integer(text):
    with pytest.raises(MeshError, match="expected an integer"):
        natural(text, "line 1")


WRONG = {
    "quad": (".inp", INP + "*ELEMENT, TYPE=C3D4\n9, 1, 2, 3, 4\n", ["'C3D4'", "M3D3", "mesh the film"]),
    "missing node": (".inp", INP.replace("1, 1, 2, 3", "1, 1, 2, 99"), ["M3D3", "99", "define it"]),
    "node twice": (".inp", INP.replace("2, 1, 0, 0", "1, 1, 0, 0"), ["node 1", "twice"]),
    "element twice": (".inp", INP.replace("2, 3, 4", "1, 3, 4"), ["element 1", "twice"]),
    "copied element": (".inp", INP.replace("1, 1, 2, 3", "1, 1, 2, 3\n9, 3, 1, 2"), ["triangles", "same nodes"]),
    "not a number": (".inp", INP.replace("1, 0, 0, 0", "1, nan, 0, 0"), ["line 2 (NODE)", "'nan'"]),
    "too large": (".inp", INP.replace("1, 0, 0, 0", "1, 1e999, 0, 0"), ["node 1", "inf"]),
    "no area": (".inp", INP.replace("3, 1, 1, 0", "3, 2, 0, 0"), ["degenerate", "nodes [0, 1, 2]"]),
    "include": (".inp", "*INCLUDE, INPUT=/etc/passwd\n" + INP, ["line 1", "in the folder", "'/etc/passwd'"]),
    "nodes elsewhere": (".inp", INP.replace("*NODE", "*NODE, INPUT=/etc/passwd"), ["NODE", "in the folder"]),
    "moved instance": (".inp", INP + "*INSTANCE, NAME=i, PART=p\n1., 0., 0.\n", ["INSTANCE", "'p'"]),
    "parts without a place": (".inp", "*PART, NAME=a\n" + INP, ["instances"]),
    "unknown set": (".inp", INP + "*NSET, NSET=b\nnowhere\n", ["'nowhere'", "sets above"]),
    "set without name": (".inp", INP + "*NSET\n1\n", ["NSET=name"]),
    "moved support": (".inp", INP + "*BOUNDARY\n1, 1, 1, 0.5\n", ["displacement", "zero"]),
    "direction 7": (".inp", INP + "*BOUNDARY\n1, 7\n", ["directions 1 to 6"]),
    "prose": (".inp", "hello\n", ["'hello'", "*NODE"]),
    "empty": (".inp", "", ["expected triangles, cables or beams, got none"]),
    "loose support": (
        ".inp",
        INP.replace("4, 2, 2, 0", "4, 2, 2, 0\n5, 9, 9, 9").replace("\n4\n", "\n5\n"),
        ["support"],
    ),
    "quad card": (".bdf", BDF + "CQUADX,9,1,1,2,3,4\n", ["CQUADX", "CTRIA3"]),
    "rigid card": (".bdf", BDF + "RSPLINE,9,1,123,2\n", ["RSPLINE"]),
    "include card": (".bdf", BDF + "INCLUDE '/etc/passwd'\n", ["line 9", "in the folder", "'/etc/passwd'"]),
    "local coordinates": (".bdf", BDF.replace("GRID,1,,", "GRID,1,5,"), ["coordinate system", "5", "CORD2R"]),
    "component 9": (".bdf", BDF.replace("7,123", "7,129"), ["123456", "'129'"]),
    "moved point": (".bdf", BDF + "SPC,1,1,1,0.5\n", ["displacement '0.5'"]),
    "continuation first": (".bdf", "+,1,2\n" + BDF.replace("BEGIN BULK\n", ""), ["continuation"]),
    "negative node": (".bdf", BDF.replace("CROD,2,2,3,4", "CROD,2,2,-3,4"), ["CROD", "-3"]),
    "binary": (".bdf", bytes(range(256)), ["mesh.bdf"]),
    "suffix": (".stl", "solid", ["'.stl'", ".msh"]),
    "script": (".msh", 'SystemCall "touch owned";\n', ["$MeshFormat"]),
    "old format": (".msh", "$NOD\n0\n$ENDNOD\n", ["format 2 or 4"]),
}


@pytest.mark.parametrize(("suffix", "text", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_files_are_one_line(suffix, text, words, read):
    with pytest.raises(MeshError) as caught:
        read(suffix, text)
    message = str(caught.value)
    assert "\n" not in message
    for word in [f"mesh{suffix}", *words]:
        assert word in message


@needs_gmsh
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("1 2 2 1 1 1 2 3", "1 21 2 1 1 1 2 3 4 1 2 3 4 1 2", ["Triangle 10", "order 1"]),
        ("$Elements\n3\n", "$Elements\n-5\n", ["mesh.msh"]),
        ("$Nodes\n4\n", "$Nodes\n999999999999\n", ["Gmsh"]),
        ("4 2 2 0", "4 nan 2 0", ["mesh.msh"]),
        ("2 1 2 2 2 3 4", "2 1 2 2 2 3 77", ["mesh.msh"]),
        ("$EndElements", '$EndElements\nSystemCall "touch owned";', None),
    ],
)
def test_damaged_gmsh_files(old, new, words, read, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert old in MSH
    if words is None:
        assert len(read(".msh", MSH.replace(old, new), {"skin": "membrane"}).triangles) == 1
    else:
        with pytest.raises(MeshError) as caught:
            read(".msh", MSH.replace(old, new), {"skin": "membrane"})
        assert all(word in str(caught.value) for word in words)
    assert not (tmp_path / "owned").exists()


@pytest.mark.slow
def test_gmsh_that_takes_too_long_is_ended(tmp_path, monkeypatch):
    sleeper = tmp_path / "_gmsh_worker.py"
    sleeper.write_text("import time\ntime.sleep(60)\n", encoding="utf-8")
    monkeypatch.setattr(gmsh_reader, "__file__", str(tmp_path / "gmsh_reader.py"))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    with pytest.raises(MeshError, match="within 1 s"):
        gmsh_reader.read_gmsh(MSH.encode(), seconds=1)


@pytest.mark.parametrize(
    ("status", "said", "error", "words"),
    [
        (3, "libGLU.so.1: cannot open shared object file", MissingExtraError, ["libGLU.so.1", "apt install libglu1"]),
        (4, "Wrong node index", MeshError, ["refuses", "Wrong node index"]),
        (-11, "", MeshError, ["broke off", "damaged"]),
        (0, "", MeshError, ["arrays"]),
    ],
)
def test_what_becomes_of_the_worker(status, said, error, words, tmp_path, monkeypatch):
    worker = tmp_path / "_gmsh_worker.py"
    end = f"os.kill(os.getpid(), {-status})" if status < 0 else f"sys.exit({status})"
    worker.write_text(f"import os, sys\nsys.stderr.write({said!r})\n{end}\n", encoding="utf-8")
    monkeypatch.setattr(gmsh_reader, "__file__", str(tmp_path / "gmsh_reader.py"))
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: name)
    with pytest.raises(error) as caught:
        gmsh_reader.read_gmsh(MSH.encode())
    assert all(word in str(caught.value) for word in words)


def test_without_gmsh_the_extra_is_named(read, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"pip install 'tautflex\[mesh\]'"):
        read(".msh", MSH)


def test_paths_that_are_no_files(tmp_path):
    (tmp_path / "folder.inp").mkdir()
    os.mkfifo(tmp_path / "pipe.inp", stat.S_IRUSR | stat.S_IWUSR)
    (tmp_path / "zero.inp").symlink_to("/dev/zero")
    for name, words in {
        "none.inp": "no such file",
        "a\0b.inp": "cannot read the mesh",
        "folder.inp": "expected a mesh.*got a directory",
        "pipe.inp": "expected a mesh.*got a device or pipe",
        "zero.inp": "expected a mesh.*got a device or pipe",
    }.items():
        with pytest.raises(MeshError, match=words):
            read_mesh(tmp_path / name)


def test_sets_that_unfold_without_end_are_refused(read, monkeypatch):
    monkeypatch.setattr("tautflex.files.mesh.raw._LARGEST_EXPANSION", 1000)
    sets = "".join(f"*NSET, NSET=s{k}\nall, all, all\n" for k in range(100))
    with pytest.raises(MeshError, match="more than 1000 members"):
        read(".inp", INP.replace("*NODE", "*NODE, NSET=all") + sets)


def test_values_of_groups_cover_every_element_once():
    lines = np.array([[0, 1], [1, 2]])
    groups = {"a": {"cables": np.array([0])}, "b": {"cables": np.array([1])}, "all": {"cables": np.array([0, 1])}}
    mesh = MeshData(np.zeros((3, 3)), np.zeros((0, 3), int), lines, np.zeros((0, 2), int), (), groups)
    assert mesh.values("cables", {"a": 1.0, "b": 2.0}).tolist() == [1.0, 2.0]
    with pytest.raises(InputError, match="got none for 1"):
        mesh.values("cables", {"a": 1.0})
    with pytest.raises(InputError, match="shares"):
        mesh.values("cables", {"all": 1.0, "b": 2.0})
    with pytest.raises(InputError, match=r"\('a', 'b', 'all'\), got 'c'"):
        mesh.values("cables", {"c": 1.0})


def test_roles_of_the_user_are_checked(read):
    with pytest.raises(MeshError, match="got 'rope'; choose"):
        read(".inp", INP, {"stay": "rope"})
    with pytest.raises(MeshError, match="expected groups of the file"):
        read(".inp", INP, {"nothing": "cable"})
    with pytest.raises(MeshError, match="expected triangles to be membrane, got cable"):
        read(".inp", INP, {"skin": "cable"})
    twice = INP + "*ELSET, ELSET=again\n2\n"
    with pytest.raises(MeshError, match="are cable here and beam by another group"):
        read(".inp", twice, {"stay": "beam", "again": "cable"})
