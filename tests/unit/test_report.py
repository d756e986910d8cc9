"""Pages of runs: what is in them, how large they are, and what they say of what they cannot show."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from tautflex.analysis.turning import recorded_attitude
from tautflex.case import parse_case
from tautflex.cli import main
from tautflex.errors import TautflexError
from tautflex.mechanics.loads.effects.cable_tension import CableTension
from tautflex.motion.rotations import exponential, rotation_vectors
from tautflex.pages.encode import packed, plain, quantised
from tautflex.pages.numbers import in_words
from tautflex.pages.rebuilt import Structure, stresses_over_time
from tautflex.pages.thinning import drawing_of
from tautflex.plot.style import thinned
from tautflex.structure.shapes import TRIANGLE3
from verification.builders import FILM_CASE
from verification.dynamic_cases import small_antenna

KINDS = {"float32": "<f4", "int16": "<i2", "uint8": "u1", "uint16": "<u2", "uint32": "<u4"}


def unpacked(given):
    values = np.frombuffer(base64.b64decode(given["base64"]), dtype=KINDS[given["array"]]).reshape(given["shape"])
    return values * np.array(given["scale"]) if "scale" in given else values


def data_of(path: Path):
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)[1])


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def run(state):
    asked = {"time_step": 5e-3, "end_time": 0.3, "probes": {"A": (0.2, 0.1)}, "frames": 20, "fields": [0.1, 0.3]}
    return tf.simulate(state, tf.Stop(2.0, 0.1), **asked)


def test_numbers_come_back_from_their_text():
    chance = np.random.default_rng(0)
    wide = chance.standard_normal((7, 5, 3)) * np.array([1e-6, 1.0, 1e3])
    wide[2, 1, 1] = np.nan
    found = unpacked(quantised(wide))
    small = quantised(wide)["scale"]
    there = np.isfinite(wide)
    assert np.all(np.abs(found - wide)[there] <= 0.5001 * np.broadcast_to(small, wide.shape)[there])
    assert found[2, 1, 1] < np.abs(wide[..., 1][there[..., 1]]).max() * -1.0  # where JavaScript reads NaN
    for whole, kind in ((255, "uint8"), (256, "uint16"), (70000, "uint32")):
        given = packed([0, whole])
        assert given["array"] == kind
        assert unpacked(given).tolist() == [0, whole]
    assert plain({"a": [np.float64(1.5), float("nan"), (2,)]}) == {"a": [1.5, None, [2]]}


def test_thinned_curves_keep_their_extremes():
    x = np.linspace(0.0, 1.0, 20_001)
    y = np.sin(900.0 * x)
    y[777], y[13_000] = 9.0, -7.0
    some, values = thinned(x, y, 400, 0)
    assert len(some) <= 402
    assert (values.max(), values.min()) == (9.0, -7.0)
    assert (some[0], some[-1]) == (0.0, 1.0)
    assert np.all(np.isin(values, y))


def test_fine_meshes_are_drawn_coarser(run):
    cells = 60
    x, y = np.meshgrid(np.linspace(0, 2, cells), np.linspace(0, 1, cells), indexing="ij")
    nodes = np.stack([x, y, 0.0 * x], axis=-1).reshape(-1, 3)
    low = np.arange(cells * (cells - 1)).reshape(cells - 1, cells)[:, :-1].ravel()
    triangles = np.concatenate(
        [np.stack([low, low + cells, low + 1], 1), np.stack([low + 1, low + cells, low + cells + 1], 1)]
    )
    mesh = {"node_position": (("node", "component"), nodes), "triangle": (("t", "c"), triangles)}
    mesh |= {"cable": (("e", "end"), [[0, cells * cells - 1]]), "beam": (("b", "end"), [[0, 1]])}
    drawing = drawing_of(xr.Dataset(mesh), 500)
    corners = drawing.mesh.nodes[drawing.mesh.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    assert 100 < len(drawing.nodes) <= 500
    assert area == pytest.approx(2.0, rel=0.15)
    assert len(drawing.mesh.cables) == 1
    np.testing.assert_array_equal(drawing.mesh.nodes, nodes[drawing.nodes])
    whole = drawing_of(run.data)
    assert len(whole.nodes) == run.data.sizes["node"]
    assert len(whole.mesh.edges) == len(
        np.unique(np.sort(TRIANGLE3.sides(run.data["triangle"].values), axis=1), axis=0)
    )


def test_attitude_of_a_record_is_that_of_its_spin():
    """A steady rate about a fixed axis, on samples that are not even."""
    time, spin = np.array([0.0, 0.1, 0.4, 1.0]), np.array([0.1, 0.0, -0.2])
    data = xr.Dataset({"angular_velocity": (("time", "component"), np.tile(spin, (4, 1)))}, {"time": time})
    found = recorded_attitude(data, np.array([0.02, 0.3, 2.0]))
    np.testing.assert_allclose(found, [exponential(t * spin) for t in (0.0, 0.4, 1.0)], atol=1e-15)


def test_rotation_vectors_go_on_beyond_half_a_turn():
    """A spin about one axis, there and back over three turns: its angle, whatever turns of it come first."""
    axis = np.array([0.0, 0.6, -0.8])
    angles = np.concatenate([np.linspace(0.0, 20.0, 90), np.linspace(20.0, -9.0, 120)])
    found = rotation_vectors(np.array([exponential(angle * axis) for angle in angles]))
    np.testing.assert_allclose(found, angles[:, None] * axis, atol=1e-12)


def test_a_run_that_ended_early_says_so(state, tmp_path):
    hub = tf.FreeHub(20.0, (3.0, 4.0, 5.0), torque=lambda time, _: (2.0 if time < 0.1 else 1e9, 0.0, 0.0))
    with pytest.raises(tf.NotConvergedError) as caught:
        tf.simulate(state, hub, time_step=5e-3, end_time=0.3, frames=20)
    found = data_of(tf.report(caught.value.result, tmp_path / "early.html"))["runs"][0]
    said = f"the run ended early, at t = {caught.value.result.reached:.6g} s; its status says why"
    assert found["warnings"][0] == said
    assert said in found["notes"]
    assert "settled" not in dict(found["numbers"])["Surface, rms"]


def test_tensions_of_frames_are_what_a_sensor_measures(state):
    """A plant with a sensor on all cables records what the frames of its run tell; its input pulls at them."""
    pull = CableTension(lambda t: 0.2 * np.sin(20.0 * t), cables=[0, 1])
    state = tf.equip(state, [pull])
    sensors = {"pull": tf.CableTensionSensor()}
    plant = tf.Plant(state, None, {}, sensors, interval=0.01, maneuver=tf.Stop(2.0, 0.1), inputs=[pull])
    measured = np.array([plant.reset(options={"frames": 0.01 * np.arange(11)}), *(plant.step([]) for _ in range(10))])
    data = plant.run.data
    frames = data["frame_displacement"].values.astype(float)
    tension, _ = stresses_over_time(Structure(state, [pull]), data["frame_time"].values, frames)
    assert np.ptp(measured, axis=0).max() > 0.1
    np.testing.assert_allclose(tension, measured, atol=1e-4 * np.abs(measured).max())
    with pytest.raises(TautflexError, match="actuators change the stress"):
        stresses_over_time(Structure(state, None), data["frame_time"].values, frames)


def test_report_holds_the_run(run, state, tmp_path):
    path = tf.report(run, tmp_path / "run.html", state=state)
    shown = data_of(path)["runs"][0]
    moved = unpacked(shown["frames"]["displacement"])
    largest = np.abs(run.data["frame_displacement"].values).max()
    np.testing.assert_allclose(moved, run.data["frame_displacement"], atol=2e-5 * largest)
    np.testing.assert_allclose(
        unpacked(shown["frames"]["attitude"])[-1], exponential(np.array([0.1, 0.0, 0.0])), atol=1e-7
    )
    assert len(shown["modes"]) == 10
    assert shown["mesh"]["probes"]["names"] == ["A"]
    assert unpacked(shown["mesh"]["held"]).tolist() == sorted({int(n) for s in state.model.supports for n in s.nodes})
    curve = next(panel for panel in shown["curves"] if panel["key"] == "w")["lines"][0]
    np.testing.assert_allclose(unpacked(curve["y"]), 1e3 * run.data["w"].sel(probe="A"), rtol=1e-6)
    text = path.read_text(encoding="utf-8")
    assert not re.search(r'(?:src|href)="', text)  # nothing to fetch
    assert "Copyright" in text


def test_report_tells_what_it_leaves_out(run, tmp_path, monkeypatch):
    alone = data_of(tf.report(run, tmp_path / "run.html"))["runs"][0]
    assert alone["modes"] == []
    assert "no case text" in alone["modes_missing"]
    assert "tension" not in alone["frames"]
    monkeypatch.setattr("tautflex.pages.report._LIBRARY", 1.9)
    monkeypatch.setattr("tautflex.pages.content._TEXT", 400.0)
    some = data_of(tf.report(run, tmp_path / "run.html", size=2.0))["runs"][0]
    assert 2 <= len(unpacked(some["frames"]["time"])) < 20
    assert re.search(r"of 20 frames are shown, 0\.\d+ s apart", some["notes"][0])


def test_texts_of_a_run_cannot_leave_their_place(run, tmp_path):
    nasty = "</script><script>alert(1)</script>{{ data }}"
    data = run.data.assign_attrs(title=nasty, warnings=[nasty])
    path = tf.report(data, tmp_path / "run.html")
    assert "<script>alert" not in path.read_text(encoding="utf-8")
    assert data_of(path)["runs"][0]["warnings"] == [nasty]


def test_wrong_reports_are_named(run, tmp_path):
    bare = tf.simulate(tf.solve_prestress(small_antenna()), time_step=0.01, end_time=0.05, frames=0)
    for arguments, options, text in (
        ((bare, "a.html"), {}, "run: expected two frames or more, got 0"),
        ((run, tmp_path / "a.pdf"), {}, "path: expected a name that ends with .html"),
        ((run, tmp_path / "a.html"), {"size": 1.0}, "size: expected 2 MB or more"),
        ((run, tmp_path / "a.html"), {"size": 0}, "size: expected 2 MB or more, which hold the page"),
        ((run, tmp_path / "a.html"), {"other": run, "names": ["one"]}, "names: expected 2 names"),
        (
            (run, tmp_path / "a.html"),
            {"state": tf.solve_prestress(small_antenna((6, 4)))},
            "state: expected the state of",
        ),
    ):
        with pytest.raises(tf.InputError, match=f"^{text}"):
            tf.report(*arguments, **options)


def test_command_takes_folders_and_files(tmp_path, capsys):
    case = parse_case(FILM_CASE)
    found = tf.run_case(case)
    for name in ("one", "two"):
        tf.save(found, tmp_path / name / "run.nc")
    assert main(["report", str(tmp_path / "one")]) == 0
    shown = data_of(tmp_path / "one" / "report.html")["runs"]
    assert len(shown) == 1
    assert "length = 1.0" in shown[0]["case"]
    assert len(shown[0]["modes"]) == 10
    assert main(["report", str(tmp_path / "one")]) == 2
    both = [
        "report",
        str(tmp_path / "one"),
        str(tmp_path / "two" / "run.nc"),
        "-o",
        str(tmp_path / "both.html"),
        "--json",
    ]
    capsys.readouterr()
    assert main(both) == 0
    assert json.loads(capsys.readouterr().out)["megabytes"] < 6.0
    assert [each["name"] for each in data_of(tmp_path / "both.html")["runs"]] == ["one", "two"]
    assert main(["report", str(tmp_path / "none")]) == 2
    assert "tautflex run" in capsys.readouterr().err


def test_what_moves_is_told_in_words_with_units():
    hub = tf.FreeHub(20.0, (4, 5, 6), angular_velocity=(0, 0, 0.1), torque=lambda time, state: np.zeros(3), axes="z")
    steps = (tf.Stop(rate=0.1, duration=1.0), tf.Slew(angle=np.pi / 6, duration=2.0, axis=(0.0, 1.0, 0.0)))
    table = tf.Tabulated([0.0, 1.0, 2.0], rates=[0.0, 1.0, 0.0])
    for given, words in (
        (steps[0], "stop, rate 0.1 rad/s, duration 1 s, axis x"),
        (steps[1], "slew, angle 0.5236 rad (30°), duration 2 s, axis y"),
        (tf.Sequence(steps, (3.0,)), f"{in_words(repr(steps[0]))}, then {in_words(repr(steps[1]))}"),
        (table, "tabulated: 3 rows of rates from 0 to 2 s"),
        (tf.AtRest(), "none, the spacecraft stands still"),
        (tf.Rayleigh(0.01, 0.02), "rayleigh, alpha 0.01 1/s, beta 0.02 s"),
    ):
        assert in_words(repr(given)) == words
    told = (
        "free hub, mass 20 kg, inertia (4, 5, 6) kg m^2, angular velocity (0, 0, 0.1) rad/s, torque a function, axes z"
    )
    assert in_words(repr(hub)) == told
    assert in_words("what another version wrote") == "what another version wrote"
