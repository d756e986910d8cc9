"""Cases whose mesh comes from a file."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from regression import mesh_files
from tautflex import CaseError, InputError
from tautflex.case import parse_case, template
from tautflex.case.build import build_inputs
from tautflex.case.loop import build_sensors
from tautflex.case.messages import of_mesh_file
from tautflex.cli import main

M2_TEMPLATE = template("m2-nearest-node")

GEOMETRY = ("length", "width", "per_long_edge", "per_short_edge", "support", "divisions", "pattern", "distribution")


def without_geometry(text=M2_TEMPLATE, mesh='file = "antenna.bdf"\n'):
    """The M2 case without the keys of the built-in antenna, and with a mesh file."""
    lines = [line for line in text.splitlines() if line.partition("=")[0].strip() not in GEOMETRY]
    return "\n".join(lines).replace("[mesh]\n", f"[mesh]\n{mesh}")


@pytest.fixture
def built():
    return parse_case(M2_TEMPLATE, ["mesh.divisions=[10,5]"])


@pytest.fixture
def folder(tmp_path, built):
    """A case and its mesh in a folder that is not the current one."""
    model = tf.build_model(built)
    (tmp_path / "antenna.bdf").write_text(mesh_files.nastran(model), encoding="utf-8")
    (tmp_path / "antenna.inp").write_text(mesh_files.abaqus(model), encoding="utf-8")
    (tmp_path / "case.toml").write_text(without_geometry(), encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("name", ["antenna.bdf", "antenna.inp"])
def test_a_mesh_file_gives_what_the_built_in_mesh_gives(folder, built, name):
    (folder / "case.toml").write_text(without_geometry(mesh=f'file = "{name}"\n'), encoding="utf-8")
    case = tf.load_case(folder / "case.toml")
    models = tf.build_model(built), tf.build_model(case)
    wanted, found = (tf.solve_modes(tf.solve_prestress(model), n=4).frequencies for model in models)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_a_case_with_a_mesh_file_is_written_and_read_again(folder):
    case = tf.load_case(folder / "case.toml", ["mesh.unit_length=0.5", "mesh.names={pid1='membrane', spc1='pinned'}"])
    assert case.mesh.file == str(folder / "antenna.bdf")
    text = case.to_toml()
    assert "divisions" not in text
    assert parse_case(text) == case
    model = tf.build_model(case)
    assert model.nodes[:, 0].max() == pytest.approx(0.5 * 1.25)
    assert model.supports[0].directions == ("x", "y", "z")


@pytest.mark.slow
def test_commands_take_a_mesh_file(folder, capsys):
    assert main(["check", str(folder / "case.toml"), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["nodes"] == 104
    arguments = ["--set", "solver.end_time=0.02", "--json"]
    assert main(["run", str(folder / "case.toml"), "-o", str(folder / "out"), *arguments]) == 0
    assert (folder / "out" / "run.nc").is_file()


@pytest.mark.slow
def test_a_mesh_that_nothing_holds_is_told(folder, capsys):
    """Six rigid motions: a doubt of `check`, a note beside the frequencies of `modes`; `run` refuses it."""
    asked = [str(folder / "case.toml"), "--set", "mesh.names={spc1='ignore'}", "--json"]
    assert main(["check", *asked]) == 0
    assert "nothing holds the structure against 6 rigid motion(s)" in capsys.readouterr().out
    assert main(["modes", *asked]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["rigid_motions"] == 6
    # Stresses that do not balance hold against turning.
    assert np.abs(answer["frequencies"][:3]).max() < 1e-3 < answer["frequencies"][3]
    assert main(["modes", *asked[:-1]]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "6 rigid motion(s): the lowest modes are these, at 0 Hz where the prestress balances" in told
    assert main(["run", *asked, "-o", str(folder / "out")]) == 2
    assert main(["check", asked[0], "--json"]) == 0
    assert "nothing holds" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("mesh.divisions=[4,2]", ["mesh.divisions", "beside file", "remove one"]),
        ("mesh.pattern=regular", ["mesh.pattern", "beside file"]),
        ("membrane.length=2.0", ["membrane.length", "mesh.file", "got 2.0"]),
        ("cables.per_long_edge=11", ["cables.per_long_edge", "mesh.file"]),
        ("cables.distribution=tributary", ["cables.distribution", "mesh.file"]),
        ("frame.support=free", ["frame.support", "mesh.file"]),
        ("mesh.file=3", ["mesh.file", "got 3"]),
        ("mesh.unit_length=-1", ["mesh.unit_length", "> 0"]),
        ("mesh.names={pid1='rope'}", ["mesh.names.pid1", "'rope'", "'membrane'"]),
    ],
)
def test_geometry_is_stated_once(change, words):
    with pytest.raises(CaseError) as caught:
        parse_case(without_geometry(), [change])
    for word in words:
        assert word in str(caught.value)


def test_keys_of_a_file_need_a_file():
    with pytest.raises(CaseError, match=r"mesh\.unit_length: expected no value without file"):
        parse_case(M2_TEMPLATE, ["mesh.unit_length=0.001"])


@pytest.mark.parametrize("key", ["frame.length", "frame.width", "cables.per_long_edge", "membrane.width"])
def test_geometry_is_needed_without_a_file(key):
    values = parse_case(M2_TEMPLATE).model_dump(by_alias=True, exclude_none=True)
    section, _, name = key.partition(".")
    del values[section][name]
    with pytest.raises(CaseError, match=rf"{key}: missing, expected the .* for example {name} = "):
        tf.Case(**values)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["mesh.file=nowhere.bdf"], ["nowhere.bdf", "no such file"]),
        (["mesh.file=/dev/zero.bdf"], ["no such file"]),
        (["mesh.names={pid4='ignore', spc1='ignore'}"], ["expected beams", "remove [frame]"]),
        (["mesh.names={pid9='cable'}"], ["'pid9'", "groups of the file"]),
    ],
)
def test_meshes_that_do_not_fit_the_case(folder, overrides, words):
    case = tf.load_case(folder / "case.toml", overrides)
    with pytest.raises(InputError) as caught:
        tf.build_model(case)
    for word in words:
        assert word in str(caught.value)


def test_a_mesh_with_beams_needs_a_frame(folder):
    text = without_geometry()
    start, end = text.index("\n[frame]\n"), text.index("\n[mesh]\n")
    (folder / "case.toml").write_text(text[:start] + text[end:], encoding="utf-8")
    with pytest.raises(InputError, match=r"beams, expected a section \[frame\]"):
        tf.build_model(tf.load_case(folder / "case.toml"))


def test_a_film_held_by_a_pinned_edge(tmp_path):
    mesh = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,.5,.5,0\n*ELEMENT,TYPE=M3D3,ELSET=film\n"
    mesh += "1,1,2,5\n2,2,3,5\n3,3,4,5\n4,4,1,5\n*NSET,NSET=pinned,GENERATE\n1,4\n"
    (tmp_path / "film.inp").write_text(mesh, encoding="utf-8")
    film = {"thickness": 1e-4, "youngs_modulus": 3.5e9, "poisson_ratio": 0.34, "density": 1530.0, "edges": "fixed"}
    case = tf.Case(membrane=film | {"stress_x": 4e3, "stress_y": 4e3}, mesh={"file": str(tmp_path / "film.inp")})
    (frequency,) = tf.solve_modes(tf.solve_prestress(tf.build_model(case)), n=1).frequencies
    # one free node: stiffness of a square under isotropic tension is 4 N, mass by linear shape functions rho h / 6
    assert frequency == pytest.approx(np.sqrt(4.0 * 4e3 / (1530.0 / 6.0)) / (2.0 * np.pi), rel=1e-9)


def test_a_device_is_no_case():
    with pytest.raises(CaseError, match=r"expected a case file.*got a device"):
        tf.load_case("/dev/zero")


MASSES = """
[[masses]]
near = [1.25, 0.75]
mass = 2.5
inertia = [0.1, 0.1, 0.2]
[[masses]]
node = 60
mass = 0.25
"""


def test_masses_of_a_case(folder, capsys):
    """At the frame's corner with an inertia, and on the film."""
    plain = tf.build_model(parse_case(M2_TEMPLATE))
    case = parse_case(M2_TEMPLATE + MASSES)
    assert parse_case(case.to_toml()) == case
    assert "2, 2.75 kg" in repr(case)
    model = tf.build_model(case)
    assert model.mass - plain.mass == pytest.approx(2.75)
    np.testing.assert_allclose(model.nodes[model.masses[0].node], [1.25, 0.75, 0.0])
    (folder / "masses.toml").write_text(without_geometry() + MASSES, encoding="utf-8")
    assert main(["check", str(folder / "masses.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mass"] == pytest.approx(model.mass, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[[masses]]\nmass = 1.0\n", ["masses", "got neither"]),
        ("[[masses]]\nnode = 1\nnear = [0.0, 0.0]\nmass = 1.0\n", ["masses", "give one"]),
        ("[[masses]]\nnode = -1\nmass = 1.0\n", ["masses", "node"]),
        ("[[masses]]\nnode = 1\nmass = -1.0\n", ["masses", "mass", "-1"]),
        ("[[masses]]\nnode = 1\nmas = 1.0\n", ["masses", "mas"]),
    ],
)
def test_masses_that_a_case_cannot_have(text, words):
    with pytest.raises(CaseError) as caught:
        parse_case(M2_TEMPLATE + text)
    assert all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("node = 100000\nmass = 1.0", ["masses[0]", "node"]),
        ("near = [9.0, 0.0]\nmass = 1.0", ["masses[0].near", "move it"]),
        ("node = 1\ninertia = [1.0, -1.0, 1.0]", ["masses[0]", "inertia"]),
        ("node = 1", ["masses[0]", "mass"]),
        ("near = [0.0, 0.0]\nmass = 1.0\ninertia = 1.0", ["masses", "no beam turns"]),
    ],
)
def test_masses_that_a_structure_cannot_have(text, words):
    case = parse_case(f"{M2_TEMPLATE}\n[[masses]]\n{text}\n")
    with pytest.raises(InputError) as caught:
        tf.build_model(case)
    assert all(word in str(caught.value) for word in words), caught.value


def test_cables_and_nodes_by_the_names_of_the_deck(folder, built):
    """Property 2 are the cables along x, set 1 the held nodes; a group of elements stands for their nodes too."""
    text = """
[inputs.pull]
kind = "cable-tension"
group = "pid2"
change = 0.1

[inputs.push]
kind = "nodal-force"
group = "pid3"
force = [0.0, 0.0, 1e-3]
"""
    case = tf.load_case(folder / "case.toml").to_toml() + text
    state = tf.solve_prestress(tf.build_model(parse_case(case)))
    assert set(state.model.selections) >= {"pid1", "pid2", "pid3", "pid4", "spc1"}
    along = mesh_files.along_x(state.model)
    pull, push = build_inputs(parse_case(case), state)
    assert sorted(pull.cables) == np.flatnonzero(along).tolist()
    assert sorted(push.nodes) == np.unique(state.model.cables[~along]).tolist()
    sensors = """
[sensors.load]
kind = "cable-tension"
group = "pid2"
[sensors.ends]
kind = "displacement"
group = "pid3"
"""
    told = build_sensors(parse_case(case + sensors), state, None)
    assert sorted(told["load"].cables) == sorted(pull.cables)
    assert told["ends"].points == tuple(map(tuple, state.model.nodes[sorted(push.nodes)].tolist()))
    with pytest.raises(CaseError, match="points: missing, kind = 'displacement' expects points or group"):
        parse_case(case + '[sensors.ends]\nkind = "displacement"\n')
    with pytest.raises(CaseError, match="group: expected no value beside points"):
        parse_case(case + '[sensors.ends]\nkind = "displacement"\npoints = [0, 0]\ngroup = "pid3"\n')
    for change, words in (
        ('group = "pid9"', "group: expected a group of the mesh file with cables .pid2, pid3., got 'pid9'"),
        ('group = "pid1"', "group: expected a group of the mesh file with cables"),
        ('group = "pid2"\nside = "+x"', "group: expected no value beside side"),
    ):
        with pytest.raises(CaseError, match=words):
            build_inputs(parse_case(case.replace('group = "pid2"', change)), state)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        (
            "a.msh: group 'skin': ...; state its role with names={'skin': 'membrane'}",
            "mesh.names = { skin = 'membrane' }",
        ),
        (
            "g: ...; take them with names = {'a b': 'membrane', 'c': 'membrane'}",
            "{ 'a b' = 'membrane', c = 'membrane' }",
        ),
        ("groups a, b: leave out all but one with names = {b = 'ignore'}", "with mesh.names = { b = 'ignore' }"),
        ("names: expected groups of the file", "mesh.names: expected"),
        ("a.inp: expected step = 1 to 3, a step of the file", "expected mesh.step = 1 to 3, a step of"),
        ("expected unit_mass beside unit_length = 0.001", "expected mesh.unit_mass beside mesh.unit_length = 0.001"),
        ("sections.rim.area: missing, neither the file nor you state it", "mesh.sections.rim.area: missing, neither"),
        ("beam.area: missing, neither the file nor you state it", "frame.area: missing, neither"),
    ],
)
def test_remedies_for_mesh_files_are_keys_of_the_case(told, words):
    assert words in of_mesh_file(told)


def test_a_mesh_that_a_case_names_is_told_in_words_of_the_case(folder):
    for override, words in {
        "mesh.names={nonsense='membrane'}": "mesh.names: expected groups of the file",
        "mesh.step=7": "expected mesh.step = 1",
    }.items():
        with pytest.raises(tf.MeshError) as caught:
            tf.build_model(parse_case(without_geometry(mesh=f'file = "{folder}/antenna.inp"\n'), [override]))
        assert words in str(caught.value)
        assert all(not problem.startswith(("names:", "step")) for problem in caught.value.problems)
