"""Sensors: what they read, and what noise, bias, delay and resolution make of it."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.case.sections.control import Controller, Sensor
from tautflex.control.sensors.sensor import noise_of
from tautflex.solvers.transient.probes import place_probes
from verification.dynamic_cases import small_antenna

INTERVAL = 0.01


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


def motion_of(state, seed=0):
    random = np.random.default_rng(seed)
    q, v = 1e-4 * random.standard_normal((2, state.system.size))
    return tf.SensedMotion(q, v, random.standard_normal(3), random.standard_normal(3), state.system.stress(q))


def readings(sensor, values, seed=1, name="film"):
    """What a sensor reads of exact values, one row a sample."""
    memory, found = sensor.start(values[0], INTERVAL, noise_of(seed, name)), []
    for exact in values:
        memory, reading = sensor.observe(memory, exact, INTERVAL)
        found.append(reading)
    return np.array(found)


def test_points_of_film_and_frame(state):
    motion, nodes = motion_of(state), state.model.nodes
    corner = int(np.argmax(nodes @ [1.0, 0.9, 0.0]))
    on_film = int(np.unique(state.model.triangles)[5])
    shape = state.system.translations(motion.q)
    places = [nodes[on_film].tolist(), nodes[corner].tolist()]
    for axis, component in enumerate("uvw"):
        read = tf.Displacement(places, component).prepare(state).read(motion)
        np.testing.assert_allclose(read, shape[[on_film, corner], axis], atol=1e-16)
    speed = tf.Velocity((0.3, 0.1)).prepare(state)
    assert (speed.size, speed.unit) == (1, "m/s")
    between = tf.Displacement((0.3, 0.1)).prepare(state).read(motion)
    probe = tf.simulate(state, time_step=1e-3, end_time=1e-3, probes={"A": (0.3, 0.1)}).data
    assert probe["w"].shape[1] == between.size
    for reading in ("interpolate", "nearest-node"):
        probes = place_probes(state.system, {"film": (0.3, 0.1), "frame": nodes[corner]}, reading)
        np.testing.assert_allclose(probes.read(motion.q)[1], shape[corner], atol=1e-16)
        np.testing.assert_array_equal(probes.positions[1], nodes[corner])
    with pytest.raises(tf.InputError, match=r"points.0: expected a point on the film"):
        tf.Displacement((9.0, 0.0)).prepare(state)
    with pytest.raises(tf.InputError, match=r"component: expected one of 'u', 'v', 'w'"):
        tf.Displacement((0.3, 0.1), "z")
    with pytest.raises(tf.InputError, match=r"points: expected a point \(x, y\)"):
        tf.Displacement(3.0)


def test_hub_modes_and_cables(state):
    motion = motion_of(state)
    np.testing.assert_array_equal(tf.Attitude().prepare(state).read(motion), motion.rotation)
    np.testing.assert_array_equal(tf.Rate().prepare(state).read(motion), motion.rate)
    modes = tf.ModalCoordinates(4).prepare(state)
    vectors = state.linear.modes(4)[1]
    still = motion._replace(q=vectors[1] * 3e-3, v=vectors[2] * 2e-3)
    expected = np.zeros(8)
    expected[[1, 6]] = 3e-3, 2e-3
    np.testing.assert_allclose(modes.read(still), expected, atol=1e-12)
    every = tf.CableTensionSensor().prepare(state)
    at_rest = motion._replace(stress=list(state.system.initial_stress))
    np.testing.assert_allclose(every.read(at_rest), state.cable_tension)
    two = tf.CableTensionSensor([3, 1]).prepare(state)
    np.testing.assert_allclose(two.read(motion), every.read(motion)[[3, 1]])
    assert [sensor.privileged for sensor in (tf.Rate(), tf.SurfaceRms(), tf.ModalCoordinates())] == [False, True, True]
    with pytest.raises(tf.InputError, match=r"cables: expected cable numbers in 0\.\."):
        tf.CableTensionSensor([999]).prepare(state)


def test_noise_bias_and_resolution():
    values = np.zeros((20_000, 2))
    read = readings(tf.Rate(noise=2e-3, bias=1e-2), values)
    np.testing.assert_allclose(read.mean(axis=0), 1e-2, atol=5.0 * 2e-3 / np.sqrt(len(values)))
    np.testing.assert_allclose(read.std(axis=0), 2e-3, rtol=0.03)
    np.testing.assert_array_equal(read, readings(tf.Rate(noise=2e-3, bias=1e-2), values))
    assert not np.array_equal(read, readings(tf.Rate(noise=2e-3, bias=1e-2), values, name="other"))
    # A ramp with resolution: steps of that size, never further off than half of one.
    ramp = np.linspace(0.0, 1e-2, 101)[:, None]
    stairs = readings(tf.Rate(resolution=1e-3), ramp)
    np.testing.assert_allclose(stairs / 1e-3, np.round(stairs / 1e-3), atol=1e-9)
    assert np.abs(stairs - ramp).max() <= 0.5001e-3


@pytest.mark.parametrize("delay", [0.0, 0.004, 0.01, 0.025, 0.03])
def test_delay_of_a_ramp_is_a_delay(delay):
    ramp = (np.arange(30) * INTERVAL)[:, None]
    read = readings(tf.Rate(delay=delay), ramp)
    np.testing.assert_allclose(read[5:, 0], ramp[5:, 0] - delay, atol=1e-12)
    assert read[0, 0] == 0.0


def test_sections_of_a_case_make_them():
    assert Sensor(kind="rate", noise=1e-5).build() == tf.Rate(noise=1e-5)
    assert Sensor(kind="displacement", points=[[0.7, 0.4]]).build().points == ((0.7, 0.4),)
    assert Controller(kind="pd", stiffness=3.0, damping=2.0).build() == tf.PD(3.0, 2.0)
    for keys, words in (
        ({"kind": "pid"}, "kind: expected one of 'pd', 'lqr'"),
        ({"kind": "pd", "stiffness": 1.0}, "damping"),
        ({"kind": "lqg", "tolerances": {}, "efforts": {"torque": 1.0}}, "tolerances: expected at least one number"),
    ):
        with pytest.raises(ValueError, match=words):
            Controller(**keys)
    with pytest.raises(ValueError, match="noise: expected a number >= 0"):
        Sensor(kind="rate", noise=-1.0)
