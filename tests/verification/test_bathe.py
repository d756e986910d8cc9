"""Bathe's method in every plant: reduced, hyper-reduced, batch, free hub, and with error control."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import tautflex as tf
from tautflex import BasisVectors, InputError
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.marching.steps import march
from tautflex.reduction.marching.work import stage_numbers
from tautflex.solvers.transient.adaptive import error_constant
from verification.dynamic_cases import small_antenna, soft_film, string

METHODS = [tf.Bathe(), tf.Bathe(split=0.5)]
STOP = tf.Stop(rate=0.6, duration=0.0437)


@pytest.fixture(scope="module")
def film():
    return soft_film()


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


class Everything(tf.Basis):
    """Basis of all motions, none of which is condensed."""

    def vectors(self, state) -> BasisVectors:
        size = state.system.size
        mass = state.system.inertia.mass_matrix.toarray()
        kept = np.linalg.inv(np.linalg.cholesky(mass))
        return BasisVectors(kept, np.zeros((0, size)), np.ones(size), "all unknowns")


def options(method, **more):
    return {"method": method, "time_step": 5e-3, "probes": {"A": (0.12, 0.1)}, "tolerance": 1e-11, **more}


def speed(x, y):
    return 2.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x)


def largest_difference(one, other) -> float:
    names = ("u", "v", "w", "w_velocity")
    return max(float(np.abs(one[name] - other[name]).max() / np.abs(other[name]).max()) for name in names)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_complete_basis_gives_the_full_run(film, method, verification_row):
    asked = options(method, end_time=0.2, initial_velocity=speed, damping=tf.Rayleigh(0.1, 1e-4))
    rom = tf.reduce(film, Everything(), weak_field=0.0)
    full, reduced = (tf.simulate(plant, STOP, **asked).data for plant in (film, rom))
    error = largest_difference(reduced, full)
    assert error < 1e-8
    verification_row(f"{method.name}: reduced on a complete basis", 0.0, error, "full run")


@pytest.mark.slow
def test_hyper_reduced_model_with_all_elements_gives_the_run_it_was_made_from():
    state, method = soft_film((3, 2)), tf.Bathe(split=0.5)
    asked = options(method, end_time=0.2, initial_velocity=speed)
    training = tf.simulate(state, STOP, fields="all", **asked).data
    rom = tf.hyper_reduce(state, training, lost=(0.0, 0.0), tolerance=0.0)
    assert largest_difference(tf.simulate(rom, STOP, **asked).data, training) < 1e-6


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.jax
def test_batch_is_the_single_runs(antenna, method, verification_row):
    rom = tf.reduce(antenna, tf.ModalBasis(directions=("rx",), count=3), weak_field=0.0)
    asked = options(method, end_time=0.08, time_step=2e-3, tolerance=1e-13)
    rates = [0.6, 0.9]
    for name, plant in (("reduced", rom), ("full", antenna)):
        data = tf.Batch(plant).simulate({"maneuver.rate": rates}, STOP, **asked)
        singles = [tf.simulate(plant, tf.Stop(rate, STOP.duration), **asked).data for rate in rates]
        worst = max(largest_difference(data.isel(run=run), single) for run, single in enumerate(singles))
        assert worst < (1e-12 if plant is rom else 1e-9)
        verification_row(f"{method.name}: batch of a {name} model", 0.0, worst, "single runs")


def test_reduced_step_whose_second_stage_fails_leaves_its_start(antenna):
    rom = tf.reduce(antenna, tf.ModalBasis(directions=("rx",), count=3))
    asked = options(tf.Bathe(), end_time=0.1, initial_velocity=lambda x, y: np.cos(0.5 * np.pi * x))
    run = ReducedRun(rom, tf.TransientProblem(rom, STOP, **asked))
    run.start()
    before = [part.copy() for part in run._work[:3]]
    stages = stage_numbers(tf.Bathe(), 5e-3)
    frame, nowhere = run._frames(run.segments[0], np.zeros(1), stages), np.full(1, -1)
    fails = stages[0], stages[1]._replace(weight=np.nan)
    for tried, done in ((fails, 0), (stages, 1)):
        assert march(run.arrays, frame, tried, run._work, nowhere, (run.eta, run.rate), 1e-9) == done
        assert run._work.counts[0] == done
        same = [np.array_equal(part, old) for part, old in zip(run._work[:3], before, strict=True)]
        assert same == [not done] * 3


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_error_control_keeps_its_tolerance(method, verification_row):
    """A string's mode: the error over ten periods is near tolerance times velocity times time."""
    state = string(8, tension=1.0, modulus=1.0, free_directions="z")
    frequency = float(tf.solve_modes(state, n=1).frequencies[0])
    period, tolerance = 1.0 / frequency, 1e-3
    run = tf.simulate(
        state,
        method=method,
        time_step=period / 20,
        end_time=10 * period,
        adaptive=tf.Adaptive(tolerance),
        initial_velocity=lambda x, y: 1e-6 * np.sin(np.pi * x),
        probes={"middle": (0.5, 0.0, 0.0)},
        tolerance=1e-10,
    )
    w = run.data.w.values[:, 0] / 1e-6
    exact = np.sin(2.0 * np.pi * frequency * run.data.time.values) / (2.0 * np.pi * frequency)
    error = float(np.abs(w - exact).max()) / (10 * period)
    assert 0.2 * tolerance < error < 1.5 * tolerance
    # constant (w h)^3 = tolerance w h
    wanted = 10 * 2.0 * np.pi / np.sqrt(tolerance / error_constant(method))
    assert run.stats.steps == pytest.approx(wanted, rel=0.45)
    verification_row(f"{method.name}, adaptive: error per time over velocity", tolerance, error, "the tolerance")


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_second_order_on_a_free_hub(film, method, verification_row):
    """Film in large motion on a light hub under a torque, all waves resolved: halved steps differ a fourth."""
    hub = tf.FreeHub(
        1.0, (0.1, 0.12, 0.2), angular_velocity=(0.3, 0.0, 0.1), torque=lambda t, _: (0.0, 0.1 * np.sin(9.0 * t), 0.0)
    )
    runs = [
        tf.simulate(
            film,
            hub,
            initial_velocity=speed,
            every=2**level,
            **options(method, time_step=2.5e-3 / 2**level, end_time=0.1),
        ).data
        for level in range(4)
    ]
    for name in ("w", "angular_velocity", "hub_position"):
        differences = [np.abs(a[name].values - b[name].values).max() for a, b in itertools.pairwise(runs)]
        order = float(np.log2(differences[1] / differences[2]))
        assert order == pytest.approx(2.0, abs=0.05)
        verification_row(f"{method.name}, free hub: observed order of {name}", 2.0, order, "second order")


def test_split_out_of_range_is_said_in_one_line():
    with pytest.raises(InputError, match=r"split: expected a number in \[0.1, 0.9\], got 1.0"):
        tf.Bathe(split=1.0)
