"""Every law around a reduced model: interval by interval and compiled, and monitored tension."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from verification.test_reduced_plant import BODY, DAMPING, PULL, TIP, rom, state

pytestmark = pytest.mark.slow

POINT = [0.3, 0.1]
HUB = tf.FreeHub(**BODY, axes="x")
SENSORS = {
    "attitude": tf.Attitude(noise=1e-6),
    "rate": tf.Rate(noise=1e-6),
    "film": tf.Displacement([POINT, [0.2, 0.15]], noise=1e-6),
}
ASKED = {"interval": 0.01, "time_step": 2e-3, "damping": DAMPING}
COST = {"tolerances": {"attitude": 1e-3}, "efforts": {"torque": 0.5}}
MODAL = {"modes": tf.ModalCoordinates(3)}


@pytest.mark.parametrize(
    ("law", "more"),
    [
        (tf.PD(stiffness=160.0, damping=40.0, inertia=3.0), {}),
        (tf.LQR(**COST, modes=3), MODAL),
        (tf.LQG(**COST, modes=4), {}),
        (tf.MPC(**COST, modes=4, limits={"torque": 3.0}, horizon=20), {}),
        (tf.ShapedReference(tf.LQG(**COST, modes=4), "ZVD", (8.0,)), {}),
    ],
    ids=["PD", "LQR", "LQG", "MPC", "shaped LQG"],
)
@pytest.mark.parametrize("lag", [0.0, 0.02], ids=["prompt", "late"])
def test_laws_turn_a_hub_and_compiled_loops_are_the_same(law, more, lag):
    """Behind a lag and a delay the laws that know them know them in both."""
    late = {"lag": lag, "delay": 0.01} if lag else {}
    actuators, sensors = {"torque": tf.HubTorque("x", **late)}, SENSORS | more
    slew = tf.Slew(angle=0.02, duration=0.5)
    run = tf.close_loop(tf.Plant(rom(), HUB, actuators, sensors, **ASKED), law, slew, end_time=1.5, seed=1)
    found = run.data.measurement.values
    np.testing.assert_allclose(found[-1, :2], [0.02, 0.0], atol=1e-3)
    measured, _ = tf.CompiledPlant(rom(), HUB, actuators, sensors, **ASKED).run(law, slew, end_time=1.5, seed=1)
    off = np.abs(measured[:, 0] - found).max(axis=0) / np.abs(found).max(axis=0)
    assert off.max() < 1e-6


@pytest.mark.parametrize("law", [tf.TensionDamping, tf.StiffnessSwitching])
def test_laws_of_tension_damp_and_no_monitor_switches_them_off(law):
    """A film that was pushed: tension takes energy out until its law fades."""
    period = 2.0 * np.pi / float(state().linear.modes(1)[0][0])
    interval = period / 40.0
    actuators = {"tip": TIP, "y": tf.Actuator(PULL["y"], limit=0.5, monitor=True)}
    sensors = {"attitude": tf.Attitude(), "rate": tf.Rate(), "modes": tf.ModalCoordinates(3)}
    asked = {"interval": interval, "time_step": interval / np.ceil(interval / 1e-3), "damping": tf.Rayleigh(0.0, 1e-5)}
    hub = tf.FreeHub(1e5, (1e5, 1e5, 1e5), axes="x")
    floor, end = 1e-9, 200 * interval

    def push(time, y):
        return [2e-3 if time < 9.5 * interval else 0.0, 0.0]

    energies = []
    for each in (push, law(("y",), 0.3, modes=3, floor=floor) + push):
        plant = tf.Plant(rom(), hub, actuators, sensors, **asked)
        run = tf.close_loop(plant, each, end_time=end)
        assert plant.switched_off == ()
        energies.append(run.energy_balance["kinetic"] + run.energy_balance["strain"])
        fast = tf.CompiledPlant(rom(), hub, actuators, sensors, **asked)
        if isinstance(each, tf.ControlLaw):
            measured, _ = fast.run(each, end_time=end)
            assert not fast.switched_off.any()
            found = run.data.measurement.values
            assert np.abs(measured[:, 0] - found).max() < 1e-9 * np.abs(found).max()
    assert plant.energy_by_source["y"] < 0.0
    assert energies[1] < 0.3 * energies[0]
