"""What becomes of quads and six-node triangles on their way out: probes, fields, files, pictures, commands."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import tautflex as tf
from tautflex import CaseError, InputError, load, plot, write_vtu
from tautflex.case import parse_case, template
from tautflex.cli import main
from tautflex.mechanics.system import StructuralSystem
from tautflex.plot.surface import wireframe
from tautflex.solvers.transient.probes import place_probes
from tautflex.structure.antenna import AntennaLayout
from unit.test_export import read_grid

M2_TEMPLATE = template("m2-nearest-node")

FIELDS = {
    "quad4": lambda x, y: 1.0 + 2.0 * x - 3.0 * y + 4.0 * x * y,
    "triangle6": lambda x, y: 1.0 + 2.0 * x - 3.0 * y + 4.0 * x * y - 5.0 * x**2 + 6.0 * y**2,
}
DIVISIONS = {"quad4": "[10,5]", "triangle6": "[5,3]"}
CELL = {"quad4": (9, 4), "triangle6": (22, 6)}
ELEMENTS = sorted(FIELDS)


def settings(element, *more):
    """The paper's antenna with cables at every edge node, or every second one where sides have a middle."""
    return [
        f"mesh.element='{element}'",
        f"mesh.divisions={DIVISIONS[element]}",
        "membrane.law='tension-field'",
        "solver.end_time=0.2",
        "solver.time_step=0.005",
        "output.fields=[0.0,0.1,0.2]",
        "output.probe_reading='interpolate'",
        *more,
    ]


@pytest.fixture(scope="module", params=ELEMENTS)
def antenna(request):
    """Element, model and a run of it."""
    case = parse_case(M2_TEMPLATE, settings(request.param, "cables.per_short_edge=4"))
    model = tf.build_model(case)
    run = tf.simulate(
        tf.solve_prestress(model),
        tf.Stop(rate=0.628, duration=0.1),
        time_step=5e-3,
        end_time=0.2,
        probes={"A": (0.7036, 0.4267)},
        fields=[0.0, 0.1, 0.2],
    )
    return request.param, model, run.data


def test_probes_read_what_the_element_interpolates(antenna):
    element, model, _ = antenna
    system = StructuralSystem.from_model(model)
    points = {f"P{i}": point for i, point in enumerate(np.random.default_rng(4).uniform(-0.5, 0.5, (20, 2)) * [2, 1])}
    q = np.zeros((len(model.nodes), 3))
    q[:, 2] = FIELDS[element](*model.nodes[:, :2].T)
    full = np.zeros(model.dof_count)
    full[model.translation_dofs] = q
    read = place_probes(system, points).read(full[model.free_dofs])
    np.testing.assert_allclose(read[:, 2], [FIELDS[element](*point) for point in points.values()], atol=1e-12)


def test_a_dataset_holds_the_elements_and_what_stands_for_them(antenna):
    element, model, data = antenna
    owner, triangles = data["triangle_owner"].values, data["triangle"].values
    elements = data["membrane"].values
    assert elements.shape == (model.membrane_count, CELL[element][1])
    assert set(data["membrane_cell"].values.tolist()) == {CELL[element][0]}
    assert all(set(row) <= set(elements[own]) for row, own in zip(triangles, owner, strict=True))
    assert set(triangles.ravel()) == set(elements.ravel())
    states = data["film_state"]
    assert states.dims == ("field_time", "triangle_element")
    # The state is that of the element, and some film is not taut in the stop.
    first = np.unique(owner, return_index=True)[1]
    np.testing.assert_array_equal(states.values, states.values[:, first][:, owner])
    assert states.values.max() > 0
    mesh = ["node_position", "triangle", "triangle_owner", "membrane", "membrane_cell", "membrane_edge"]
    assert set(mesh) <= set(tf.pod(data, modes=1)) & set(tf.solve_modes(tf.solve_prestress(model), n=1).to_dataset())


def test_three_node_triangles_are_stored_as_before():
    model = tf.build_model(parse_case(M2_TEMPLATE))
    data = tf.solve_modes(tf.solve_prestress(model), n=1).to_dataset()
    assert {"triangle", "cable", "beam", "node_position"} <= set(data)
    assert not {"triangle_owner", "membrane", "membrane_cell", "membrane_edge"} & set(data)


def test_cells_of_a_vtu_file_are_the_elements(antenna, tmp_path):
    element, model, data = antenna
    tension = np.arange(float(model.membrane_count))
    grid = read_grid(write_vtu(data.assign(tension=("membrane_element", tension)), tmp_path)[2])
    count, (cell, nodes) = model.membrane_count, CELL[element]
    assert grid["Cells", "types"].tolist() == [cell] * count + [3] * (len(model.cables) + len(model.beams))
    film = np.split(grid["Cells", "connectivity"], grid["Cells", "offsets"][:-1])[:count]
    np.testing.assert_array_equal(film, data["membrane"].values)
    assert {len(corners) for corners in film} == {nodes}
    first = np.unique(data["triangle_owner"].values, return_index=True)[1]
    np.testing.assert_array_equal(grid["CellData", "film_state"][:count], data["film_state"].values[1, first])
    np.testing.assert_array_equal(grid["CellData", "tension"][:count], tension)
    assert {name for section, name in grid if section == "CellData"} == {"kind", "film_state", "tension"}
    assert np.bincount(grid["CellData", "kind"]).tolist() == [count, len(model.cables), len(model.beams)]


def test_pictures_show_the_sides_of_elements_and_no_others(antenna):
    element, model, data = antenna
    edges = {tuple(edge) for edge in wireframe(data).edges.tolist()}
    count_x, count_y = (int(n) for n in DIVISIONS[element].strip("[]").split(","))
    sides = count_x * (count_y + 1) + count_y * (count_x + 1)
    if element == "triangle6":
        sides = 2 * (sides + count_x * count_y)  # and the diagonals, each in two pieces
    assert len(edges) == sides
    assert len(plot.plot_shapes(data).axes) > 1
    assert len(plot.plot_modes(tf.solve_modes(tf.solve_prestress(model), n=2).to_dataset(), count=2).axes) > 1


@pytest.mark.slow
@pytest.mark.parametrize("element", ELEMENTS)
def test_commands_take_the_element(element, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    case = parse_case(M2_TEMPLATE, settings(element, "cables.per_short_edge=4"))
    (tmp_path / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    assert parse_case(case.to_toml()) == case
    assert main(["check", "case.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["nodes"] == len(tf.build_model(case).nodes)
    assert main(["modes", "case.toml", "-n", "3", "-o", "out", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["labels"][0] == [1, 1]
    assert main(["run", "case.toml", "-o", "out", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["probes"]["A"]["amplitude"] > 0.0
    for figure in ("modes.png", "shapes.png"):
        assert (tmp_path / "out" / figure).stat().st_size > 10_000
    stored = load(tmp_path / "out" / "run.nc")
    assert stored["membrane_cell"].values[0] == CELL[element][0]
    assert main(["export", "out/run.nc", "--to", "vtu", "-o", "vtu"]) == 0
    assert read_grid(tmp_path / "vtu" / "run_vtu" / "run_0001.vtu")["Cells", "types"][0] == CELL[element][0]


def test_wrong_elements_are_refused_in_one_line():
    text = "mesh.element: expected one of 'triangle3', 'triangle6' or 'quad4', got 'hexagon'; choose one of them"
    with pytest.raises(CaseError, match=re.escape(text)):
        parse_case(M2_TEMPLATE, ["mesh.element='hexagon'"])
    with pytest.raises(CaseError, match=r"mesh\.divisions: expected at least 5 cells along x for 11 cables, got"):
        parse_case(M2_TEMPLATE, ["mesh.element='triangle6'", "mesh.divisions=[4,5]"])
    with pytest.raises(InputError, match="element: expected one of 'triangle3', 'triangle6', 'quad4', got 'line2'"):
        AntennaLayout(2.0, 1.0, (4, 2), element="line2")


def test_a_pattern_that_quads_have_no_use_for_is_said(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = M2_TEMPLATE.replace('pattern = "regular"', "# no pattern")
    said, given = [], {element: settings(element, "cables.per_short_edge=4") for element in ELEMENTS}
    for element, case in (("quad4", M2_TEMPLATE), ("triangle6", M2_TEMPLATE), ("quad4", text)):
        (tmp_path / "case.toml").write_text(case)
        assert main(["check", "case.toml", "--json", *(f"--set={one}" for one in given[element])]) == 0
        said.append([line for line in json.loads(capsys.readouterr().out)["warnings"] if "pattern" in line])
    text = "mesh.pattern = 'regular' is not used: cells of 'quad4' have no diagonal; remove it"
    assert said == [[text], [], []]


def test_without_a_film_probes_stand_on_nodes():
    section = tf.CableSection(tf.Material(7e10, 2700.0), 1e-6)
    nodes = [[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]]
    ends = tf.Support.pinned([0, 2])
    model = tf.Model.from_mesh(nodes, cables=[[0, 1], [1, 2]], cable=section, cable_tension=5.0, supports=[ends])
    system = StructuralSystem.from_model(model)
    np.testing.assert_array_equal(place_probes(system, {"A": (1.0, 0.0)}).positions, [[1.0, 0.0, 0.0]])
    text = r"probes.A: expected the position of a node, because there is no film .* nearest is node 1 at \(1, 0, 0\) m"
    with pytest.raises(InputError, match=text):
        place_probes(system, {"A": (0.8, 0.0)})
    np.testing.assert_array_equal(place_probes(system, {"A": (0.8, 0.0)}, "nearest-node").positions, [[1.0, 0.0, 0.0]])
