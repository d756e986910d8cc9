from __future__ import annotations

import csv
import json
import sys
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from regression.small_result import small_result
from tautflex import InputError, write_csv, write_vtu
from tautflex.cli import main
from tautflex.files.vtu import write_grid
from verification.builders import antenna

TYPES = {"Float64": np.float64, "Float32": np.float32, "Int64": np.int64, "Int32": np.int32, "UInt8": np.uint8}


@pytest.fixture(scope="module")
def run():
    return small_result()


def read_grid(path):
    """Arrays of a VTU file by section and name, after checking lengths and component counts."""
    head, mark, raw = path.read_bytes().partition(b'<AppendedData encoding="raw">\n_')
    assert mark
    root = ElementTree.fromstring(head + b"</VTKFile>")
    assert root.attrib["type"] == "UnstructuredGrid"
    assert root.attrib["header_type"] == "UInt64"
    assert root.attrib["byte_order"] == f"{sys.byteorder.capitalize()}Endian"
    (piece,) = root.iter("Piece")
    rows = {"Points": "Points", "Cells": "Cells", "PointData": "Points", "CellData": "Cells"}
    arrays, end = {}, 0
    for section in piece:
        for array in section:
            assert array.attrib["format"] == "appended"
            assert int(array.attrib["offset"]) == end  # nothing between the arrays
            dtype, components = TYPES[array.attrib["type"]], int(array.attrib["NumberOfComponents"])
            length = int(np.frombuffer(raw, np.uint64, 1, end)[0])
            values = np.frombuffer(raw, dtype, length // dtype().itemsize, end + 8)
            arrays[section.tag, array.attrib["Name"]] = values.reshape(-1, components) if components > 1 else values
            end += 8 + length
            if array.attrib["Name"] != "connectivity":
                assert len(values) == components * int(piece.attrib[f"NumberOf{rows[section.tag]}"])
    assert raw[end:].split() == [b"</AppendedData>", b"</VTKFile>"]
    return arrays


def test_series_lists_every_stored_instant(run, tmp_path):
    collection, *files = write_vtu(run, tmp_path / "deep", "run")
    root = ElementTree.parse(collection).getroot()
    sets = list(root.iter("DataSet"))
    assert [float(item.attrib["timestep"]) for item in sets] == run["field_time"].values.tolist()
    assert [collection.parent / item.attrib["file"] for item in sets] == files
    assert len(files) == 3


def test_grid_holds_mesh_and_displacement_exactly(run, tmp_path):
    _, _, middle, _ = write_vtu(run, tmp_path)
    grid = read_grid(middle)
    np.testing.assert_array_equal(grid["Points", "points"], run["node_position"].values)
    displacement = grid["PointData", "displacement"]
    np.testing.assert_array_equal(displacement, run["displacement"].isel(field_time=1).values)
    assert np.abs(displacement).max() > 0.0
    ends = np.split(grid["Cells", "connectivity"], grid["Cells", "offsets"][:-1])
    wanted = [row.tolist() for kind in ("triangle", "cable", "beam") for row in run[kind].values]
    assert [row.tolist() for row in ends] == wanted
    assert grid["Cells", "types"].tolist() == [5 if len(row) == 3 else 3 for row in wanted]
    film = len(run["triangle"])
    np.testing.assert_array_equal(grid["CellData", "film_state"][:film], run["film_state"].values[1])
    counts = [run.sizes[f"{kind}_element"] for kind in ("triangle", "cable", "beam")]
    assert np.bincount(grid["CellData", "kind"]).tolist() == counts


def test_every_field_over_nodes_and_elements_goes_along(run, tmp_path):
    film, ropes = run.sizes["triangle_element"], run.sizes["cable_element"]
    resultant = np.random.default_rng(1).standard_normal((3, film, 3))
    extended = run.assign(
        velocity=2.0 * run["displacement"],
        resultant=(("field_time", "triangle_element", "stress"), resultant),
        film_state=(("field_time", "triangle_element"), np.arange(3 * film).reshape(3, film)),
        tension=(("cable_element",), np.arange(float(ropes))),
        remark=(("triangle_element",), ["taut"] * film),
    )
    grid = read_grid(write_vtu(extended, tmp_path)[3])
    np.testing.assert_array_equal(grid["PointData", "velocity"], 2.0 * run["displacement"].values[2])
    np.testing.assert_array_equal(grid["CellData", "resultant"][:film], resultant[2])
    assert np.isnan(grid["CellData", "resultant"][film:]).all()
    assert grid["CellData", "film_state"][:film].tolist() == list(range(2 * film, 3 * film))
    assert set(grid["CellData", "film_state"][film:]) == {-1}
    np.testing.assert_array_equal(grid["CellData", "tension"][film : film + ropes], np.arange(float(ropes)))
    assert ("CellData", "remark") not in grid


def test_cells_of_any_type_go_together(tmp_path):
    """Six-node triangles, quadrilaterals and lines in one grid; numbers of any type and count of components."""
    points = np.random.default_rng(0).random((9, 3))
    groups = [
        (np.array([[0, 1, 2, 3, 4, 5]]), 22),
        (np.array([[0, 1, 2, 3], [5, 6, 7, 8]]), 9),
        (np.array([[7, 8]]), 3),
    ]
    fields = {"pair": np.arange(8, dtype=">f4").reshape(4, 2), "taut": np.array([True, False, True, True])}
    write_grid(tmp_path / "mixed.vtu", points, groups, {"half": np.arange(9, dtype=np.float16)}, fields)
    grid = read_grid(tmp_path / "mixed.vtu")
    assert grid["Cells", "types"].tolist() == [22, 9, 9, 3]
    cells = np.split(grid["Cells", "connectivity"], grid["Cells", "offsets"][:-1])
    assert [cell.tolist() for cell in cells] == [row.tolist() for corners, _ in groups for row in corners]
    np.testing.assert_array_equal(grid["CellData", "pair"], fields["pair"])
    assert grid["CellData", "taut"].tolist() == [1, 0, 1, 1]
    np.testing.assert_array_equal(grid["PointData", "half"], np.arange(9.0))


def test_mode_shapes_are_a_series_over_the_modes(tmp_path):
    modes = tf.solve_modes(tf.solve_prestress(antenna((0.59, 1.0), (4, 2))), n=2).to_dataset()
    collection, first, second = write_vtu(modes, tmp_path, "modes")
    for k, file in enumerate((first, second)):
        np.testing.assert_array_equal(read_grid(file)["PointData", "shape"], modes["shape"].values[k])
    assert 'timestep="2.0"' in collection.read_text(encoding="utf-8")


def test_names_are_escaped(run, tmp_path):
    named = run.rename(displacement='a<b>&"c" ü')
    collection, first, *_ = write_vtu(named, tmp_path / "a&b", 'x&"y"')
    assert ("PointData", 'a<b>&"c" ü') in read_grid(first)
    listed = next(ElementTree.parse(collection).getroot().iter("DataSet")).attrib["file"]
    assert collection.parent / listed == first


def test_table_reads_back_exactly(run, tmp_path):
    path = write_csv(run, tmp_path / "deep" / "run.csv")
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    columns = dict(zip(head, np.array(rows, dtype=float).T, strict=True))
    np.testing.assert_array_equal(columns["time [s]"], run["time"].values)
    np.testing.assert_array_equal(columns["w A [m]"], run["w"].sel(probe="A").values)
    np.testing.assert_array_equal(columns["v_velocity B [m s-1]"], run["v_velocity"].sel(probe="B").values)
    spin = run["angular_velocity"].sel(component="x").values
    np.testing.assert_array_equal(columns["angular_velocity x [rad s-1]"], spin)
    assert not any("displacement" in title for title in head)


def test_runs_without_fields_or_time_say_what_to_do(run, tmp_path):
    with pytest.raises(InputError, match=r"output\.fields"):
        write_vtu(run.isel(field_time=slice(0, 0)), tmp_path)
    with pytest.raises(InputError, match=r"with .*'triangle'"):
        write_vtu(run.drop_vars("triangle"), tmp_path)
    with pytest.raises(InputError, match="with 'time'"):
        write_csv(xr.Dataset(), tmp_path / "x.csv")


@pytest.fixture
def stored(run, tmp_path):
    return tf.save(run, tmp_path / "out" / "run.nc")


def test_command_writes_beside_the_result(stored, capsys):
    assert main(["export", str(stored), "--to", "vtu"]) == 0
    assert "run.pvd" in capsys.readouterr().out
    assert (stored.parent / "run_vtu" / "run_0002.vtu").is_file()


def test_command_as_json(stored, tmp_path, capsys):
    assert main(["export", str(stored), "--to", "csv", "-o", str(tmp_path / "tables"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"files": [str(tmp_path / "tables" / "run.csv")]}
    assert (tmp_path / "tables" / "run.csv").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["export", "none.nc", "--to", "csv"], ["none.nc", "does not exist"]),
        (["export", "bad.nc", "--to", "vtu"], ["bad.nc", "NetCDF-4"]),
        (["export", "bad.nc", "--to", "stl"], ["stl", "vtu"]),
        (["export", "bad.nc"], ["--to"]),
        (["export", "bad.nc", "--to", "csv", "-o", "bad.nc"], ["expected an output directory"]),
    ],
)
def test_command_refuses_in_one_line(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.nc").write_bytes(b"no result")
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert all(word in captured.err for word in words)


def test_damage_to_a_result_is_recognised_before_it_is_read(stored):
    content = bytearray(stored.read_bytes())
    content[len(content) // 2] ^= 1
    stored.write_bytes(content)
    with pytest.raises(InputError, match="checksum does not match"):
        tf.load(stored)


def test_a_result_that_lost_its_end_is_still_a_result(run, stored):
    stored.write_bytes(stored.read_bytes()[:-80])
    xr.testing.assert_identical(tf.load(stored), run)
