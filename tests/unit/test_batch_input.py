"""What a batch refuses, and how it says so."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from tautflex import InputError, UnsupportedError
from tautflex.batch.chunks import usual_chunk
from tautflex.batch.equations.rate_history import rate_history
from tautflex.batch.gather import gather_table, multiply, shared_rows
from tautflex.batch.library import jax
from tautflex.batch.output.precision import single_precision_errors
from tautflex.batch.parameters import checked_numbers
from tautflex.batch.steps.grid import steps_of_run
from verification.dynamic_cases import small_antenna

pytestmark = pytest.mark.jax
KINDS = ("membrane", "cable", "beam")
DAMPING = {"damping.alpha": 0.0, "damping.beta": 0.0}
GRID = {"time_step": 1e-3, "end_time": 0.01}


@pytest.fixture(scope="module")
def state() -> tf.Model:
    return tf.solve_prestress(small_antenna())


def test_unknown_parameter_names_the_known_ones():
    with pytest.raises(InputError, match=r"maneuver\.duration.*got 'speed'"):
        checked_numbers({"speed": 1.0}, KINDS, rate_history(tf.Stop(0.1, 1.0)), DAMPING)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"tension_x": -1.0}, "> 0"),
        ({"tension_x": [1.0, np.nan]}, "finite"),
        ({"tension_x": [1.0, 1.1], "tension_y": [1.0, 1.1, 1.2]}, "2 runs, got 3"),
        ({"density.membrane": [[1.0]]}, "shape"),
        ([1.0], "mapping"),
    ],
)
def test_values_out_of_range_are_refused(given, words):
    with pytest.raises(InputError, match=words):
        checked_numbers(given, KINDS, rate_history(tf.Stop(0.1, 1.0)), DAMPING)


def test_lengths_give_the_number_of_runs():
    given = {"tension_x": [1.0, 1.1, 1.2], "maneuver.rates": np.zeros(5), "damping.alpha": 0.1}
    history = rate_history(tf.Tabulated(np.linspace(0, 1, 5), np.zeros(5)))
    _, axes, runs = checked_numbers(given, KINDS, history, DAMPING)
    assert (axes, runs) == ({"tension_x": 0, "maneuver.rates": None, "damping.alpha": None}, 3)


def test_maneuver_refuses_its_own_numbers(state):
    with pytest.raises(InputError, match="duration: expected a number > 0"):
        tf.Batch(state).simulate({"maneuver.duration": [1.0, -1.0]}, tf.Stop(0.1, 1.0), **GRID)


def test_damping_refuses_its_own_numbers(state):
    batch = tf.Batch(state)
    with pytest.raises(InputError, match=r"beta: expected a number >= 0, got -0\.001"):
        batch.simulate({"damping.beta": [0.0, -1e-3]}, tf.Stop(0.1, 1.0), **GRID)
    with pytest.raises(InputError, match=r"expected names among.*damping\.ratio.*got 'damping\.beta'"):
        batch.simulate({"damping.beta": 0.1}, damping=tf.Modal(0.01), **GRID)
    with pytest.raises(InputError, match=r"ratio: expected a number in \[0, 1\], got 1\.5"):
        batch.simulate({"damping.ratio": [0.01, 1.5]}, damping=tf.Modal(0.01), **GRID)


def test_single_precision_is_for_reduced_models(state):
    with pytest.raises(InputError, match=r"precision: expected one of 'double', 'single'.*got 'half'"):
        tf.Batch(state, precision="half")
    with pytest.raises(UnsupportedError, match=r"precision: expected 'double' for the full model.*reduce\(state\)"):
        tf.Batch(state, precision="single")


def test_errors_of_single_precision_are_said_in_words():
    """Two runs: the second is off in one component by 2e-3 of the largest one, and a third ends otherwise."""
    ended = ["completed", "completed", "completed"]
    w, u = np.array([[0.0, 1.0, -2.0]] * 3), np.zeros((3, 3))
    names = ("run", "time")
    double = xr.Dataset({"u": (names, u), "w": (names, w), "status": ("run", ended)}, {"run": [0, 7, 13]})
    assert single_precision_errors(double, double) == ({"displacement": 0.0}, [])
    off = double.copy(deep=True)
    off["u"][1, 1] = 4e-3
    errors, words = single_precision_errors(off, double)
    assert errors["displacement"] == pytest.approx(2e-3)
    assert words == [
        "single precision: the displacement of a run is off by 2.0e-03 of its largest value; take precision='double'"
    ]
    off["status"][2] = "not-converged"
    off["w"][2, 1:] = np.nan
    errors, (first, _) = single_precision_errors(off, double)
    assert errors["displacement"] == pytest.approx(2e-3)
    assert first == "single precision: runs 13 end otherwise in double precision; take precision='double'"
    off["status"][:] = "not-converged"
    assert np.isnan(single_precision_errors(off, double)[0]["displacement"])


def test_plant_method_and_maneuver_must_have_a_batched_form(state):
    with pytest.raises(InputError, match="plant: expected a prestressed state"):
        tf.Batch("antenna")
    batch = tf.Batch(state)
    with pytest.raises(UnsupportedError, match="method: expected Newmark"):
        batch.response(method=tf.EnergyConserving(), **GRID)
    with pytest.raises(UnsupportedError, match="method: expected an implicit method for the full model"):
        batch.response(method=tf.CentralDifference(), **GRID)
    with pytest.raises(UnsupportedError, match="maneuver: expected Stop"):
        batch.response(tf.BaseAcceleration(1.0), **GRID)
    with pytest.raises(InputError, match="store: expected one of"):
        batch.response(store=("w",), **GRID)
    with pytest.raises(InputError, match="parameters: expected names among"):
        batch.response(**GRID)({"maneuver.rate": 1.0})


def test_hubs_and_inputs_must_have_a_batched_form(state):
    body = {"mass": 20.0, "inertia": (4.0, 5.0, 6.0)}
    with pytest.raises(UnsupportedError, match=r"prescribed motion for the full model .*, got FreeHub"):
        tf.Batch(state).simulate({}, tf.FreeHub(**body, axes="x"), **GRID)
    batch = tf.Batch(tf.reduce(state, tf.ModalBasis(directions=("rx",), count=1)))
    explicit = {"method": tf.CentralDifference(), **GRID}
    with pytest.raises(UnsupportedError, match="axes = 'free'"):
        batch.simulate({}, tf.FreeHub(**body), **explicit)
    with pytest.raises(UnsupportedError, match="torque of three numbers"):
        batch.simulate({}, tf.FreeHub(**body, axes="x", torque=lambda time, state: (0, 0, 0)), **explicit)
    with pytest.raises(UnsupportedError, match=r"method: expected CentralDifference\(\) on a free hub"):
        batch.simulate({}, tf.FreeHub(**body, axes="x"), method=tf.Newmark(), **GRID)
    with pytest.raises(InputError, match=r"'hub.inertia' > 0 kg m\^2, got -1\.0"):
        batch.simulate({"hub.inertia": -1.0}, tf.FreeHub(**body, axes="x"), **explicit)
    with pytest.raises(UnsupportedError, match=r"inputs: expected inputs that are linear.*Pressure"):
        batch.simulate({}, inputs=[tf.Pressure([1.0] * state.model.membrane_count)], **explicit)
    wave = tf.NodalForce([0], lambda time: np.sin(float(time)), direction=(0, 0, 1))
    with pytest.raises(UnsupportedError, match=r"function of jax\.numpy .* NodalForce number 1"):
        batch.simulate({}, inputs=[wave], **explicit)
    pull = [tf.CableTension(1.0, [0])]
    with pytest.raises(UnsupportedError, match=r"none that changes the stiffness .*, got tension_x"):
        batch.simulate({"tension_x": 1.1}, inputs=pull, **explicit)
    with pytest.raises(InputError, match=r"expected names among.*inputs\.1, inputs\.1\.values, got 'inputs\.2'"):
        batch.simulate({"inputs.2": 1.1}, inputs=pull, **explicit)


def test_nonlinear_laws_are_refused():
    film = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4, law="tension-field")
    nodes = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.4, 0.4, 0]]
    model = tf.Model.from_mesh(
        nodes,
        triangles=[[0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4]],
        membrane=film,
        membrane_stress=(1e4, 1e4, 0.0),
        supports=(tf.Support.pinned([0, 1, 2, 3]),),
    )
    with pytest.raises(UnsupportedError, match="law: expected elastic"):
        tf.Batch(tf.solve_prestress(model))


@pytest.mark.parametrize("asked", ["Batch", "FunctionalTwin", "train"])
def test_missing_jax_is_said_in_one_line(asked):
    code = (
        "import sys; sys.modules['jax'] = None\n"
        "import tautflex as tf\n"
        f"try:\n    tf.{asked}\nexcept tf.MissingExtraError as error:\n    print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == (
        "batch: expected the packages jax and threadpoolctl, not both installed; pip install 'tautflex[batch]'"
    )


@pytest.mark.parametrize(
    "maneuver",
    [
        tf.Stop(0.5, 0.7303),
        tf.Slew(0.4, 1.1, "versine"),
        tf.Slew(0.4, 1.1, "bang-bang"),
        tf.Slew(0.4, 1.1, "minimum-jerk"),
        tf.Slew(0.4, 1.1, "input-shaped", frequency=2.3, damping_ratio=0.02),
        tf.Slew(0.4, 1.1, "input-shaped", frequency=2.3, shaper="ZV", base="versine"),
        tf.SpinUp(0.6, 0.9, initial_rate=0.1),
        tf.Tabulated([0, 0.2, 0.5, 0.5, 0.8, 1.0], [0.1, 0.3, 0.2, 0.2, -0.1, 0.0]),
    ],
    ids=lambda maneuver: f"{type(maneuver).__name__}-{getattr(maneuver, 'profile', '')}",
)
def test_courses_are_the_maneuvers(maneuver):
    history, segments = rate_history(maneuver), maneuver.segments()
    if history.start is not None:
        assert float(history.start(history.numbers)) == pytest.approx(maneuver.start().angular_velocity[0], abs=1e-15)
    breaks = np.sort(np.asarray(history.breaks(history.numbers)))
    assert breaks == pytest.approx([segment.end for segment in segments[:-1]], rel=1e-12)
    for segment in segments:
        end = min(segment.end, segment.start + 0.3)
        middle = 0.5 * (segment.start + end)
        # Wilson-theta looks beyond the end of a stretch.
        for time in (segment.start, middle, end, end + 1e-3):
            got, motion = history.spin(history.numbers, time, middle), segment.motion(time)
            expected = [motion.angular_velocity[0], motion.angular_acceleration[0]]
            assert [float(got.rate), float(got.acceleration)] == pytest.approx(expected, abs=1e-11)
            assert float(got.square) == pytest.approx(motion.angular_velocity[0] ** 2, abs=1e-11)


def test_steps_end_on_the_grid_and_on_every_discontinuity():
    steps, place = steps_of_run(np.array([0.35, 0.2, 9.0, 0.35]), 0.1, 5, multiple=4)
    ends = np.asarray(steps.start + steps.size)
    assert len(ends) % 4 == 0
    assert ends[np.asarray(place)] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert np.all(np.asarray(steps.size) >= 0.0)
    assert float(np.sum(steps.size)) == pytest.approx(0.5)
    # Coinciding discontinuities jump once.
    assert ends[np.asarray(steps.jump)] == pytest.approx([0.2, 0.35, 0.5])


def test_tables_are_the_sparse_matrices():
    rng = np.random.default_rng(0)
    dense = [np.where(rng.random((9, 9)) < 0.3, rng.standard_normal((9, 9)), 0.0) for _ in range(2)]
    from scipy.sparse import csr_array

    columns, values = shared_rows([csr_array(matrix) for matrix in dense])
    vector = rng.standard_normal(9)
    for matrix, value in zip(dense, values, strict=True):
        assert np.asarray(multiply(columns, value, vector)) == pytest.approx(matrix @ vector, abs=1e-14)
    places = np.array([3, 1, 1, 4, 3, 3])
    table = gather_table(places, 4)
    assert [sorted(row[row < 6].tolist()) for row in table] == [[], [1, 2], [], [0, 4, 5]]


def test_chunks_suit_the_device_that_was_chosen(monkeypatch):
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    assert usual_chunk(4096, reduced=True) == 4096
    with jax.default_device(jax.devices("cpu")[0]):
        assert usual_chunk(4096, reduced=True) == 32
    with jax.default_device("cpu"):
        assert usual_chunk(4096, reduced=True) == 32
