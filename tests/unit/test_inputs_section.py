"""Sections [inputs.NAME]: forces, tensions and temperatures in time from a case file."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex import CaseError, load_case
from tautflex.case import parse_case, template
from tautflex.case.build import build_inputs, build_state
from tautflex.cli import main
from verification.builders import FILM_CASE

M2_TEMPLATE = template("m2-nearest-node")


def film_case(section: str) -> tf.Case:
    return parse_case(f"{FILM_CASE}{section}\n")


@pytest.fixture(scope="module")
def film():
    return tf.solve_prestress(tf.build_model(parse_case(FILM_CASE)))


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(tf.build_model(parse_case(M2_TEMPLATE)))


def test_each_kind_means_its_class(antenna):
    text = """
[inputs.push]
kind = "nodal-force"
nodes = [3, 5]
force = [0.0, 0.0, 1e-3]
[inputs.edge]
kind = "edge-force"
nodes = [0, 1, 2]
force = { times = [0.0, 1.0], values = [[0, 0, 0], [0, 0, 1]] }
[inputs.reel]
kind = "cable-tension"
change = 0.1
breaks = [0.5]
[inputs.sun]
kind = "membrane-temperature"
change = { times = [0.0, 1.0, 2.0], values = [0, 40, 40] }
expansion = 1e-5
"""
    case = parse_case(M2_TEMPLATE + text)
    assert parse_case(case.to_toml()) == case
    push, edge, reel, sun = build_inputs(case, antenna)
    assert push == tf.NodalForce((3, 5), (0.0, 0.0, 1e-3))
    assert (edge.nodes, edge.force(0.25).tolist()) == ((0, 1, 2), [0.0, 0.0, 0.25])
    assert reel == tf.CableTension(0.1, breaks=(0.5,))
    assert (sun.expansion, float(sun.change(0.5)), float(sun.change(9.0))) == (1e-5, 20.0, 40.0)
    assert sun.change.breaks == (0.0, 1.0)


def test_every_effect_is_a_section_of_a_case():
    text = """
[inputs.pull]
kind = "tension-group"
cables = "y"
change = { times = [0.0, 0.1], values = [0.0, 0.2] }
share = "pretension"
[inputs.reel]
kind = "tension-group"
side = "+x"
change = 1e-4
command = "length"
stiffness = 2e3
[inputs.stay]
kind = "stay-cable"
point = [0.2, 0.1]
anchor = [0.0, 0.0, 0.5]
tension = 0.1
[inputs.patch]
kind = "piezo-film"
coefficient = 2e-11
field = 1e5
region = [0.0, 1.0, -0.5, 0.5]
[inputs.frame]
kind = "piezo-pair"
beams = [0, 1]
moment = 0.1
[inputs.shaker]
kind = "nodal-force"
near = [0.1, 0.1]
direction = [0, 0, 1]
force = { times = [0.0, 1.0], values = [0.0, 1e-3] }
"""
    case = parse_case(M2_TEMPLATE + text)
    assert parse_case(case.to_toml()) == case
    state = build_state(case)
    pull, reel, stay, patch, frame, shaker = build_inputs(case, state)
    assert (pull.cables, pull.command, pull.share) == ("y", "tension", "pretension")
    assert (len(reel.cables), reel.stiffness) == (6, 2e3)
    assert stay == tf.StayCable((0.2, 0.1), (0.0, 0.0, 0.5), 0.1)
    assert patch == tf.PiezoFilm(2e-11, 1e5, (0.0, 1.0, -0.5, 0.5))
    assert frame == tf.PiezoPair((0, 1), 0.1)
    assert shaker.direction == (0, 0, 1)
    run = tf.run_case(case.replaced(solver={"end_time": 5e-3}))
    assert run.status.value == "completed"
    bare = tf.solve_prestress(tf.build_model(case))
    moduli = [plant.system.blocks[plant.system.block_index("cable")[0]].elasticity for plant in (bare, state)]
    assert [len(np.unique(modulus)) for modulus in moduli] == [1, 3]


def test_places_instead_of_numbers(antenna):
    model = antenna.model

    def chosen(section: str):
        return built(section, antenna)

    (node,) = chosen('kind = "nodal-force"\nnear = [0.21, -0.1]\nforce = [0, 0, 1]').nodes
    np.testing.assert_allclose(model.nodes[node], [0.2, -0.1, 0.0], atol=1e-12)
    two = chosen('kind = "nodal-force"\nnear = [[0.2, -0.1], [1.0, 0.5]]\nforce = [0, 0, 1]').nodes
    np.testing.assert_allclose(model.nodes[list(two)][:, :2], [[0.2, -0.1], [1.0, 0.5]], atol=1e-12)
    side = chosen('kind = "edge-force"\nside = "-y"\nforce = [0, 0, 1]').nodes
    np.testing.assert_allclose(model.nodes[list(side)][:, 0], np.linspace(-1.0, 1.0, 11), atol=1e-12)
    np.testing.assert_allclose(model.nodes[list(side)][:, 1], -0.5)
    cables = chosen('kind = "cable-tension"\nchange = 0.1\nside = "+x"').cables
    ends = model.nodes[model.cables[list(cables)]]
    assert len(cables) == 6  # per short edge
    np.testing.assert_allclose(ends[:, :, 1].std(axis=1), 0.0, atol=1e-12)
    assert ends[:, :, 0].min() > 0.9


def test_a_force_in_a_case_moves_the_film_as_in_python(film):
    section = '[inputs.push]\nkind = "nodal-force"\nnear = [0.0, 0.0]\n'
    case = film_case(
        section + "force = { times = [0.0, 0.105, 0.105, 0.2], values = [[0, 0, 0], [0, 0, 2e-3], "
        "[0, 0, 1e-3], [0, 0, 0]] }"
    ).replaced(solver={"tolerance": 1e-11})
    node = int(np.linalg.norm(film.model.nodes, axis=1).argmin())

    def force(time):
        up = 2e-3 * time / 0.105 if time < 0.105 else max(0.0, 1e-3 * (0.2 - time) / 0.095)
        return 0.0, 0.0, up

    found = tf.run_case(case)
    expected = tf.simulate(
        film,
        time_step=0.01,
        end_time=0.3,
        tolerance=1e-11,
        probes={"A": (0.2, 0.1)},
        inputs=[tf.NodalForce([node], force, breaks=(0.0, 0.105, 0.2))],
    )
    assert float(np.abs(expected.data.w).max()) > 1e-5
    np.testing.assert_allclose(found.data.w, expected.data.w, rtol=1e-9, atol=1e-15)


def test_tables_from_files_stand_beside_the_case(tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "push.csv").write_text("time,x,y,z\n0,0,0,0\n0.1,0,0,1e-3\n", encoding="utf-8")
    (tmp_path / "there" / "sun.csv").write_text("# K\nchange,time\n0,0\n30,0.2\n", encoding="utf-8")
    section = (
        '[inputs.push]\nkind = "nodal-force"\nnear = [0, 0]\nforce = { file = "push.csv" }\n'
        '[inputs.sun]\nkind = "membrane-temperature"\nexpansion = 1e-6\nchange.file = "sun.csv"\n'
    )
    (tmp_path / "there" / "case.toml").write_text(FILM_CASE + section, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    case = load_case("there/case.toml")
    push, sun = build_inputs(case, tf.solve_prestress(tf.build_model(case)))
    assert push.force(0.05).tolist() == [0.0, 0.0, 5e-4]
    assert float(sun.change(0.1)) == 15.0


BAD = {
    "no kind": ("nodes = [1]", ["inputs.one.kind: missing", "'nodal-force'"]),
    "unknown kind": ('kind = "wind"', ["inputs.one.kind", "'cable-tension'", "got 'wind'"]),
    "no force": ('kind = "nodal-force"\nnodes = [1]', ["inputs.one.force: missing", "[N]"]),
    "no nodes": ('kind = "nodal-force"\nforce = [0, 0, 1]', ["inputs.one.nodes: missing", "near = [0.5, 0.2]"]),
    "nodes twice": (
        'kind = "nodal-force"\nforce = [0, 0, 1]\nnodes = [1]\nside = "+x"',
        ["inputs.one.side", "beside nodes", "'+x'"],
    ),
    "key of another kind": (
        'kind = "nodal-force"\nnear = [0, 0]\nforce = [0, 0, 1]\nexpansion = 1.0',
        ["inputs.one.expansion", "kind = 'nodal-force'", "set kind = 'membrane-temperature'"],
    ),
    "misspelt": ('kind = "nodal-force"\nnear = [0, 0]\nforse = 1', ["inputs.one.forse", "did you mean 'force'"]),
    "force of text": ('kind = "nodal-force"\nnear = [0, 0]\nforce = "up"', ["inputs.one.force", "'up'"]),
    "number for a vector": (
        'kind = "nodal-force"\nnear = [0, 0]\nforce = 1.0',
        ["inputs.one.force: expected shape (3)"],
    ),
    "no such node": ('kind = "nodal-force"\nnodes = [99]\nforce = [0, 0, 1]', ["inputs.one.nodes", "0..24", "got 99"]),
    "no such side": ('kind = "nodal-force"\nside = "up"\nforce = [0, 0, 1]', ["inputs.one.side", "'up'", "'+x'"]),
    "no cables": ('kind = "cable-tension"\nchange = 1.0', ["inputs.one.", "cables", "got none"]),
    "no beams": ('kind = "piezo-pair"\nbeams = [0]\nmoment = 1.0', ["inputs.one.", "beams", "got none"]),
    "unknown command": (
        'kind = "tension-group"\nchange = 1.0\ncommand = "pull"',
        ["inputs.one.command", "'tension', 'length'", "got 'pull'"],
    ),
    "no tension": ('kind = "stay-cable"\npoint = [0, 0]\nanchor = [0, 0, 1]', ["inputs.one.tension: missing", "[N]"]),
    "beside the film": (
        'kind = "stay-cable"\npoint = [9, 0]\nanchor = [0, 0, 1]\ntension = 1.0',
        ["inputs.one.point: expected a point of the film", "[9.0, 0.0]"],
    ),
    "half a table": (
        'kind = "nodal-force"\nnear = [0, 0]\nforce = { times = [0, 1] }',
        ["inputs.one.force", "values: missing"],
    ),
    "rows": (
        'kind = "nodal-force"\nnear = [0, 0]\nforce = { times = [0, 1], values = [[0, 0, 1]] }',
        ["inputs.one.force.values", "2 rows", "got 1"],
    ),
    "falling times": (
        'kind = "membrane-temperature"\nexpansion = 1e-6\nchange = { times = [1, 0], values = [0, 1] }',
        ["inputs.one.change.times", "rising", "0 s after 1 s"],
    ),
    "no such file": (
        'kind = "membrane-temperature"\nexpansion = 1e-6\nchange = { file = "gone.csv" }',
        ["inputs.one.change.file", "'gone.csv': no such file"],
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_mistakes_are_one_line_that_names_the_key(name, film):
    section, words = BAD[name]
    with pytest.raises(CaseError) as caught:
        build_inputs(film_case(f"[inputs.one]\n{section}"), film)
    message = str(caught.value)
    assert "\n" not in message
    for word in words:
        assert word in message


@pytest.mark.slow
def test_check_tries_the_inputs_and_run_takes_them(tmp_path, capsys):
    path = tmp_path / "case.toml"
    path.write_text(FILM_CASE + '[inputs.reel]\nkind = "cable-tension"\nchange = 1.0\n', encoding="utf-8")
    assert main(["check", str(path)]) == 2
    assert "inputs.reel" in capsys.readouterr().err
    path.write_text(
        FILM_CASE + '[inputs.push]\nkind = "nodal-force"\nnear = [0.1, 0.1]\nforce = [0, 0, 1e-3]\n', encoding="utf-8"
    )
    assert main(["check", str(path)]) == 0
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--json"]) == 0
    capsys.readouterr()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["probes"]["A"]["amplitude"] > 1e-5
    assert "[inputs.push]" in tf.load(tmp_path / "out" / "run.nc").attrs["case"]


@pytest.mark.parametrize(
    ("times", "values", "breaks"),
    [
        ([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], (0.0, 2.0)),  # a straight line bends at its ends only
        ([1.0, 2.0], [3.0, 3.0], ()),  # a constant nowhere
        ([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 5.0, 6.0], (0.0, 1.0, 2.0)),  # a jump
        ([0.0, 1.0, 2.0], [[0.0, 1.0], [1.0, 1.0], [2.0, 4.0]], (0.0, 1.0, 2.0)),
    ],
)
def test_tables_in_time_bend_where_they_bend(times, values, breaks):
    assert tf.TimeTable(times, values).breaks == breaks


def test_a_jump_counts_from_its_instant_on():
    table = tf.TimeTable([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 5.0, 6.0])
    before = float(table(np.nextafter(1.0, 0.0)))
    assert (before, float(table(1.0)), float(table(1.5))) == (pytest.approx(1.0), 5.0, 5.5)
    assert (float(table(-1.0)), float(table(3.0))) == (0.0, 6.0)


def test_the_template_shows_a_section_that_works(antenna):
    start = M2_TEMPLATE.index("# [inputs.knock]")
    shown = "\n".join(line.removeprefix("# ") for line in M2_TEMPLATE[start:].splitlines())
    (knock,) = build_inputs(parse_case(M2_TEMPLATE[:start] + shown), antenna)
    np.testing.assert_allclose(antenna.model.nodes[knock.nodes[0]], [0.2, 0.1, 0.0], atol=1e-12)
    assert knock.force(0.1).tolist() == [0.0, 0.0, 1e-3]


def built(section: str, state):
    """The one input of a section, made for a structure."""
    (found,) = build_inputs(parse_case(M2_TEMPLATE + f"\n[inputs.one]\n{section}\n"), state)
    return found


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ('kind = "nodal-force"\nnodes = []\nforce = [0, 0, 1]', ["nodes", "at least one node"]),
        ('kind = "nodal-force"\nnodes = [8, 8]\nforce = [0, 0, 1]', ["nodes", "every node once", "[8, 8]"]),
        ('kind = "nodal-force"\nnear = [5, 5]\nforce = [0, 0, 1]', ["near", "m from the nearest one"]),
        ('kind = "nodal-force"\nnear = [0, 0]\nforce = { file = "/dev/zero" }', ["device or pipe"]),
        ('kind = "nodal-force"\nnear = [0, 0]\nforce = { file = "twice.csv" }', ["different names", "time, x, x"]),
        ('kind = "nodal-force"\nnear = [0, 0]\nforce = { file = "two.csv" }', ["x, y and z", "time, x, y"]),
    ],
)
def test_what_would_act_elsewhere_or_not_at_all_is_refused(section, words, antenna, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "twice.csv").write_text("time,x,x\n0,1,2\n", encoding="utf-8")
    (tmp_path / "two.csv").write_text("time,x,y\n0,1,2\n", encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        built(section, antenna)
    assert all(word in str(caught.value) for word in words)


def test_columns_of_a_table_are_taken_by_their_axes(antenna, tmp_path, monkeypatch):
    """A file whose columns stand in another order is the same force."""
    monkeypatch.chdir(tmp_path)
    rows = {"time,x,y,z": "0,1,2,3\n1,4,5,6\n", "force_z,time,force_y,force_x": "3,0,2,1\n6,1,5,4\n"}
    for number, (header, text) in enumerate(rows.items()):
        (tmp_path / f"{number}.csv").write_text(f"{header}\n{text}", encoding="utf-8")
        force = built(f'kind = "nodal-force"\nnear = [0, 0]\nforce = {{ file = "{number}.csv" }}', antenna).force
        assert force(0.5).tolist() == [2.5, 3.5, 4.5]
