"""The inertial load's factor: of all, of a kind of element, and in every model [paper (45)]."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError
from tautflex.motion.fixed_axis import fixed_axis_motion
from verification.dynamic_cases import small_antenna

STOP = tf.Stop(0.6, 0.04)
OPTIONS = {"time_step": 2e-3, "end_time": 0.06, "probes": {"A": (0.6, 0.3)}, "method": tf.Newmark(), "tolerance": 1e-12}
HALF = {"membrane": 0.5, "cable": 0.5, "frame": 0.5}
OWN = {"membrane": 0.5, "cable": 1.5}


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


def load(state, factor):
    coupling = tf.Coupling(inertial_load=factor)
    motion = fixed_axis_motion(2.0, -3.0, np.array([0.4, 0.1, 0.2]), np.array([0.1, 0.3, -0.2]))
    return coupling.load(motion, coupling.moments(state.system))


def test_half_the_factor_is_half_the_load_exactly(antenna):
    whole = load(antenna, True)
    assert np.abs(whole).max() > 0.0
    np.testing.assert_array_equal(load(antenna, 0.5), 0.5 * whole)
    np.testing.assert_array_equal(load(antenna, 1.0), whole)
    np.testing.assert_array_equal(load(antenna, False), 0.0 * whole)
    np.testing.assert_array_equal(load(antenna, 0), 0.0 * whole)
    np.testing.assert_allclose(load(antenna, HALF), 0.5 * whole, rtol=1e-14, atol=1e-16 * np.abs(whole).max())


def test_kinds_add_up_to_the_whole(antenna, verification_row):
    """Loads of one kind alone; one that is left out is whole."""
    kinds = ("membrane", "cable", "frame")
    alone = {kind: load(antenna, dict.fromkeys(kinds, 0.0) | {kind: 1.0}) for kind in kinds}
    whole, size = load(antenna, 1.0), np.abs(load(antenna, 1.0)).max()
    assert all(np.abs(part).max() > 1e-3 * size for part in alone.values())
    error = float(np.abs(sum(alone.values()) - whole).max() / size)
    assert error < 1e-14
    verification_row("inertial loads of the kinds of element: their sum", 1, 1 + error, "Q_T of the whole")
    expected = 0.5 * alone["membrane"] + 1.5 * alone["cable"] + alone["frame"]
    np.testing.assert_allclose(load(antenna, OWN), expected, rtol=0, atol=1e-14 * size)


def test_a_linear_response_is_in_proportion(antenna, verification_row):
    """Slow rotation: half the load, half the deflection."""
    slow = tf.Stop(1e-3, 0.04)
    whole, half = (
        tf.simulate(antenna, slow, coupling=tf.Coupling(inertial_load=factor), **OPTIONS).data.w.values
        for factor in (True, 0.5)
    )
    error = float(np.abs(half - 0.5 * whole).max() / np.abs(whole).max())
    assert error < 1e-6
    verification_row("deflection under half the inertial load, linear", 0.5, 0.5 + error, "half of the whole")


@pytest.mark.parametrize("factor", [0.5, OWN])
@pytest.mark.slow
def test_models_agree(antenna, factor):
    """Full, reduced and hyper-reduced; what the load prescribes to static derivatives is in it."""
    coupling = tf.Coupling(inertial_load=factor)
    full = tf.simulate(antenna, STOP, coupling=coupling, fields="all", **OPTIONS)
    size = np.abs(full.data.w.values).max()
    rom = tf.reduce(antenna, tf.ModalBasis(directions=("rx",), count=24), weak_field=0.0)
    hyper = tf.hyper_reduce(antenna, full.data, tolerance=0.0, lost=(1e-10, 1e-10))
    whole = tf.simulate(antenna, STOP, **OPTIONS).data.w.values
    assert np.abs(whole - full.data.w.values).max() > 0.1 * size
    for plant in (rom, hyper):
        found = tf.simulate(plant, STOP, coupling=coupling, **OPTIONS).data.w.values
        assert np.abs(found - full.data.w.values).max() < 0.02 * size


def test_a_free_hub_has_no_factor(antenna):
    """Its momentum would not stay: the load is what the structure's own inertia does to the hub."""
    free = tf.solve_prestress(small_antenna())
    hub = tf.FreeHub(10.0, (3.0, 3.0, 3.0))
    for factor in (0.5, OWN, False):
        with pytest.raises(InputError, match="coupling: expected all terms, whole, on a free hub"):
            tf.simulate(free, hub, coupling=tf.Coupling(inertial_load=factor), time_step=1e-3, end_time=2e-3)


def test_wrong_factors_are_refused():
    with pytest.raises(InputError, match="inertial_load: expected a number >= 0, got -1"):
        tf.Coupling(inertial_load=-1.0)
    with pytest.raises(InputError, match="inertial_load: expected kinds of element, each once"):
        tf.Coupling(inertial_load={"film": 0.5})
    with pytest.raises(InputError, match="inertial_load: expected a finite number, got 'half'"):
        tf.Coupling(inertial_load="half")
