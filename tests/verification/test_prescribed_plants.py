"""Compiled plants whose motion is prescribed about one axis: the runs of `Plant`, row by row."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError, UnsupportedError
from verification.dynamic_cases import small_antenna

pytestmark = pytest.mark.slow

PULL = {axis: tf.TensionGroup(axis, command="tension") for axis in "xy"}
ACTUATORS = {**PULL, "tip": tf.NodalForce([8], direction=(0.0, 0.0, 1.0))}
SENSORS = {
    "attitude": tf.Attitude(),
    "rate": tf.Rate(noise=1e-6, delay=0.015),
    "film": tf.Displacement([[0.3, 0.1], [0.2, 0.15]], bias=1e-6),
    "speed": tf.Velocity([0.3, 0.1]),
    "rms": tf.SurfaceRms(),
    "tension": tf.CableTensionSensor(),
    "modes": tf.ModalCoordinates(3),
}
ASKED = {"interval": 0.01, "time_step": 1e-3, "damping": tf.Rayleigh(0.01, 1e-4)}
# Gentle ones: the round-off of a film that is thrown about grows without limit.
MANEUVERS = {
    "rest": None,
    "stop": tf.Stop(rate=0.1, duration=0.2),
    "spin-up": tf.SpinUp(rate=-0.2, duration=0.25, axis=(0.0, -1.0, 0.0), initial_rate=0.1),
    "slew": tf.Slew(angle=0.01, duration=0.4, profile="bang-bang", axis=(0.0, 0.0, 1.0)),
}


@cache
def rom(curved: bool = False):
    """Flat, so that a steady spin about an axis in its plane bends nothing, or curved."""
    model = small_antenna()
    if curved:
        nodes = model.nodes.copy()
        nodes[:, 2] = 0.05 * (nodes[:, 0] ** 2 + 0.5 * nodes[:, 1])
        model = replace(model, nodes=nodes)
    state = tf.equip(tf.solve_prestress(model, check=False), list(PULL.values()))
    return tf.reduce(state, tf.ModalBasis(count=8, candidates=80))


def commands(count: int):
    """Tensions [N] and a force [N]."""
    n = np.arange(count)
    return np.column_stack([0.03 * np.cos(n), 0.03 * np.sin(1.7 * n), 2e-3 * np.cos(3.0 * n)])


@pytest.mark.parametrize("curved", [False, True], ids=["flat", "curved"])
@pytest.mark.parametrize("left_out", [(), ("tension",)], ids=["all readings", "linear readings"])
@pytest.mark.parametrize("name", MANEUVERS)
def test_a_compiled_plant_is_prescribed_as_a_plant_is(name, left_out, curved, verification_row):
    """Readings of every sensor and the work of every actuator, through edges of the motion."""
    sensors = {key: each for key, each in SENSORS.items() if key not in left_out}
    plant, fast = (
        made(rom(curved), None, ACTUATORS, sensors, maneuver=MANEUVERS[name], **ASKED)
        for made in (tf.Plant, tf.CompiledPlant)
    )
    table = commands(45)
    slow = np.array([plant.reset(seed=3), *(plant.step(row) for row in table)])
    quick = np.array([fast.reset(seed=3), *(fast.step(row).copy() for row in table)])
    ends = np.cumsum([sensor.size for sensor in plant.outputs])[:-1]
    off = np.array([np.abs(own).max() for own in np.split(quick - slow, ends, 1)])
    off /= [max(np.abs(own).max(), 1e-300) for own in np.split(slow, ends, 1)]
    assert off.max() < 1e-9
    np.testing.assert_allclose(fast.work[0], list(plant.energy_by_source.values()), rtol=1e-8)
    if not left_out:
        said = f"prescribed compiled plant, {'curved' if curved else 'flat'} antenna, {name}: largest part of a reading"
        verification_row(said, 0.0, float(off.max()), "Plant")
    np.testing.assert_allclose(fast.linearize(3).A, plant.linearize(3).A, rtol=1e-12)


def test_a_film_that_curves_starts_bent_and_feels_the_coriolis_force():
    """What the comparison above is about on a curved film: neither is round-off."""
    plant = tf.CompiledPlant(rom(True), None, ACTUATORS, {}, maneuver=tf.Stop(0.5, 0.2), **ASKED)
    plant.reset()
    assert np.abs(plant.coordinates() / rom(True).basis.amplitude).max() > 1e-6
    assert plant.constants[0].spin.size
    assert not tf.CompiledPlant(rom(), None, ACTUATORS, {}, **ASKED).constants[0].spin.size


def test_angles_are_those_of_the_maneuver():
    """By Gauss points: a versine in closed form, beyond the first 512 intervals, of which noise is drawn at once."""
    turn, rate, duration = tf.SpinUp(rate=0.3, duration=6.0), 0.3, 6.0
    plant = tf.CompiledPlant(rom(), None, {}, {"a": tf.Attitude(), "w": tf.Rate()}, maneuver=turn, **ASKED)
    y, _ = plant.run(np.zeros((700, 0)))
    s = np.minimum(np.arange(701) * 0.01 / duration, 1.0)
    angle = rate * duration * (s * s / 2.0 + (np.cos(2.0 * np.pi * s) - 1.0) / (4.0 * np.pi**2))
    angle += rate * np.maximum(np.arange(701) * 0.01 - duration, 0.0)
    np.testing.assert_allclose(y[:, 0, 0], angle, atol=1e-12)
    np.testing.assert_allclose(y[:, 0, 3], rate * (s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi)), atol=1e-12)
    assert not y[:, 0, [1, 2, 4, 5]].any()


def test_every_row_has_its_own_maneuver():
    """Rows of two blocks are plants alone to the bit, whenever and along whatever they began."""
    crowd, one = (
        tf.CompiledPlant(rom(), None, ACTUATORS, SENSORS, maneuver=MANEUVERS["stop"], count=count, **ASKED)
        for count in (66, 1)
    )
    crowd.reset(seed=5)
    for row in commands(3):
        crowd.step(np.tile(row, (66, 1)))
    other = tf.Sequence((tf.Slew(0.01, 0.05), tf.Slew(-0.02, 0.1, "bang-bang")), holds=(0.03,))
    begun = crowd.reset(seed=8, row=65, maneuver=other)
    found = [begun, *(crowd.step(np.tile(row, (66, 1)))[65].copy() for row in commands(30))]
    alone = [one.reset(seed=8, maneuver=other), *(one.step(row).copy() for row in commands(30))]
    np.testing.assert_array_equal(found, alone)
    again = [one.reset(seed=5 + 64), *(one.step(row).copy() for row in [*commands(3), *commands(30)])]
    np.testing.assert_array_equal(crowd.measurement[64], again[-1])
    measured, _ = one.run(lambda time, y: np.zeros(3), other, end_time=0.1)
    np.testing.assert_allclose(measured[-1, 0, 0], 0.01 - 0.02 * (2.0 * 0.02**2 / 0.1**2), rtol=1e-12)


def test_motions_that_are_none_of_it_are_told():
    def plant(maneuver, hub=None):
        return tf.CompiledPlant(rom(), hub, {}, {}, maneuver=maneuver, **ASKED)

    for maneuver in (
        tf.Stop(0.1, 0.2, axis=(1.0, 1.0, 0.0)),
        tf.Stop(0.1, 0.2, origin=(0.0, 1.0, 0.0)),
        tf.Sequence((tf.Slew(0.1, 0.2), tf.Slew(0.1, 0.2, axis=(0.0, 1.0, 0.0)))),
    ):
        with pytest.raises(UnsupportedError, match=r"maneuver: expected a turn about one of the axes .*; use Plant"):
            plant(maneuver)
    with pytest.raises(UnsupportedError, match=r"maneuver: expected a maneuver about x, .*; use Plant"):
        plant(tf.Stop(0.1, 0.2)).reset(maneuver=tf.Stop(0.1, 0.2, axis=(0.0, 1.0, 0.0)))
    with pytest.raises(
        InputError, match=r"maneuver: expected one that jumps at whole steps of 0\.001 s.* at 0\.2005 s"
    ):
        plant(None).reset(maneuver=tf.Stop(0.1, 0.2005))
    with pytest.raises(InputError, match="maneuver: expected a maneuver, or None, got 3"):
        plant(3)
    hub = tf.FreeHub(20.0, (3.0, 4.0, 5.0), axes="x")
    with pytest.raises(InputError, match=r"maneuver: expected none on a free hub, got Stop\("):
        plant(tf.Stop(0.1, 0.2), hub)
    with pytest.raises(InputError, match="maneuver: expected none on a free hub"):
        plant(None, hub).reset(maneuver=tf.Stop(0.1, 0.2))
    with pytest.raises(InputError, match=r"torque: expected a free hub"):
        tf.CompiledPlant(rom(), None, {"torque": tf.HubTorque("x")}, {}, **ASKED)
    assert "Stop(rate=0.1" in repr(plant(tf.Stop(0.1, 0.2)))
