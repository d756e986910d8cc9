"""Frames for pictures that move: every plant keeps them, cut runs have the same, and their memory is bounded."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.control.loop import close_loop
from tautflex.solvers.transient import problem
from verification.dynamic_cases import small_antenna

STEPS = {"time_step": 2e-3, "end_time": 0.1, "method": tf.Newmark()}
HUB = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), angular_velocity=(0.1, 0.0, 0.0))
STOP = tf.Stop(0.6, 0.04)


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def rom(state):
    return tf.reduce(state, tf.ModalBasis(directions=("z", "rx", "ry"), count=6))


def film_of(run):
    return run.data["frame_time"].values, run.data["frame_displacement"].values


@pytest.mark.parametrize(("plant", "maneuver"), [("state", STOP), ("state", HUB), ("rom", STOP), ("rom", HUB)])
def test_frames_are_fields_in_single_precision(plant, maneuver, request):
    plant = request.getfixturevalue(plant)
    data = tf.simulate(plant, maneuver, fields="all", frames=11, **STEPS).data
    assert data["frame_displacement"].dtype == np.float32
    np.testing.assert_allclose(data["frame_time"], np.linspace(0.0, 0.1, 11), atol=1e-12)
    fields = data["displacement"].sel(field_time=data["frame_time"].values, method="nearest").values
    assert np.abs(fields).max() > 0.0
    # Frames of reduced models come from one product in single precision.
    np.testing.assert_allclose(data["frame_displacement"], fields, rtol=2e-7, atol=5e-7 * np.abs(fields).max())


@pytest.mark.slow
def test_hyper_reduced_runs_have_frames(state):
    whole = tf.simulate(state, STOP, fields="all", **STEPS)
    data = tf.simulate(tf.hyper_reduce(state, [whole]), STOP, fields="all", frames=7, **STEPS).data
    fields = data["displacement"].sel(field_time=data["frame_time"].values, method="nearest").values
    np.testing.assert_allclose(data["frame_displacement"], fields, rtol=2e-7, atol=5e-7 * np.abs(fields).max())


@pytest.mark.parametrize("plant", ["state", "rom"])
def test_a_run_that_is_cut_has_the_frames_of_the_whole_one(plant, request):
    plant, asked = request.getfixturevalue(plant), {**STEPS, "frames": 13}
    whole = film_of(tf.simulate(plant, STOP, **asked))
    times = whole[0]
    first = tf.simulate(plant, STOP, **asked | {"end_time": 0.05, "frames": times[times < 0.0501]})
    parts = [film_of(each) for each in (first, tf.simulate(plant, STOP, initial=first.final, **asked))]
    slack = 0.0 if request.node.callspec.id == "state" else 2e-7 * np.abs(whole[1]).max()
    for one, pair in zip(whole, zip(*parts, strict=True), strict=True):
        np.testing.assert_allclose(np.concatenate(pair), one, rtol=0.0, atol=slack)


@pytest.mark.parametrize("plant", ["state", "rom"])
def test_frames_do_not_change_a_run(plant, request):
    """They end stretches of compiled steps, which leaves no trace."""
    state = request.getfixturevalue(plant)
    asked = {"time_step": 1e-3, "end_time": 0.1, "probes": {"A": (0.3, 0.2)}}
    few, many = (tf.simulate(state, STOP, frames=count, **asked) for count in (0, 60))
    np.testing.assert_array_equal(few.data["w"], many.data["w"])
    assert few.stats.steps == many.stats.steps
    assert (few.data.sizes["frame_time"], many.data.sizes["frame_time"]) == (0, 60)


def test_loops_have_frames_too_however_long(state, rom, monkeypatch):
    """A plant that is commanded reserves its record part by part."""
    for reserved, each in ((1024, rom), (4, rom), (4, state)):
        monkeypatch.setattr("tautflex.control.plant._RESERVED", reserved)
        plant = tf.Plant(each, HUB, {"torque": tf.HubTorque("x")}, {"rate": tf.Rate()})
        data = close_loop(plant, lambda t, y: -y[:1], end_time=0.11, frames=4).data
        assert data["frame_time"].values.tolist() == pytest.approx([0.0, 0.04, 0.07, 0.11])
        assert data["frame_displacement"].shape == (4, len(state.model.nodes), 3)
        assert np.abs(data["frame_displacement"][1:]).max(axis=(1, 2)).all()


def test_memory_of_frames_is_bounded(state, monkeypatch):
    monkeypatch.setattr(problem, "MOST_FRAME_BYTES", 12.0 * len(state.model.nodes) * 5)
    asked = {"time_step": 1e-3, "end_time": 0.1}
    for frames in (300, np.linspace(0.0, 0.1, 40)):
        steps = sorted(tf.TransientProblem(state, frames=frames, **asked).frame_steps)
        assert len(steps) == 5
        assert (steps[0], steps[-1]) == (0, 100)


@pytest.mark.parametrize("frames", [-1, 1.5, "all", [2.0], None, True])
def test_wrong_frames_are_named(state, frames):
    with pytest.raises(tf.InputError, match=r"^frames: expected"):
        tf.simulate(state, frames=frames, **STEPS)


def test_case_tells_how_many(tmp_path):
    from tautflex.case import parse_case
    from verification.builders import FILM_CASE

    text = FILM_CASE.replace("[output.probes]", "[output]\nframes = 5\n[output.probes]")
    data = tf.run_case(parse_case(text)).data
    tf.save(data, tmp_path / "run.nc")
    stored = tf.load(tmp_path / "run.nc")
    assert stored.sizes["frame_time"] == 5
    assert stored["frame_displacement"].dtype == np.float32
    np.testing.assert_array_equal(stored["frame_displacement"], data["frame_displacement"])
