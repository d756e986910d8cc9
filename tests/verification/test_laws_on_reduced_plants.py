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
    off = np.abs(measured[:, 0] - found).max(axis=0)
    assert np.all(off < 1e-6 * np.abs(found).max(axis=0) + 1e-14)  # modes that a turn about x leaves at rest read 1e-13


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


NODES = [int(np.argmin(np.linalg.norm(state().model.nodes - [x, 0.0, 0.0], axis=1))) for x in (0.5, -0.5)]
PUSH = {name: tf.NodalForce([node], direction=(0, 0, 1)) for name, node in zip("ab", NODES, strict=True)}
PLACES = state().model.nodes[NODES, :2].tolist()


def _pushed(time, y):
    return [1e-4, 0.0] if time < 0.195 else [0.0, 0.0]


@pytest.mark.parametrize(
    "law",
    [
        tf.PositivePositionFeedback(0.9, 1.35, "w[0]", "a", damping_ratio=0.3),
        tf.IndependentModalControl("w", "dw", 2, effort=1.0),
    ],
    ids=["PPF", "IMSC"],
)
def test_laws_of_a_prescribed_hub_damp_a_reduced_film_as_the_full_one(law, verification_row):
    """Forces at two points of a film whose frame stands still, and displacements of the same."""
    sensors = {"w": tf.Displacement(PLACES), "dw": tf.Velocity(PLACES)}
    asked = {"interval": 0.01, "time_step": 5e-3, "damping": tf.Rayleigh(0.0, 1e-5), "method": tf.Newmark()}
    reduced = tf.reduce(state(), tf.ModalBasis(count=16, candidates=60), inputs=list(PUSH.values()))
    found = []
    for body, each in ((state(), law + _pushed), (reduced, law + _pushed), (reduced, _pushed)):
        run = tf.close_loop(tf.Plant(body, None, PUSH, sensors, **asked), each, end_time=2.0)
        assert run.warnings == []
        found.append(run.data.measurement.values[:, 0])
    off = float(np.sqrt(np.mean((found[1] - found[0]) ** 2) / np.mean(found[0] ** 2)))
    verification_row(f"{type(law).__name__} on a reduced plant: rms of the record at its point", 0.0, off, "full plant")
    assert off < 0.05
    left, free = (np.abs(w[-60:]).max() for w in found[1:])
    assert left < 0.7 * free


def test_a_hyper_reduced_plant_is_the_full_one(verification_row):
    """A slew by PD with switched tension, on vectors of a run with switched tension."""
    times = np.repeat(0.1 * np.arange(1, 10), 2)
    switched = PULL["y"].driven(tf.TimeTable(times, np.repeat(0.3 * (-1.0) ** np.arange(10), 2)[1:-1]))
    trained = tf.simulate(
        state(), tf.Stop(rate=0.3, duration=0.2), time_step=5e-3, end_time=1.0, fields="all", every=4,
        damping=DAMPING, inputs=[switched], method=tf.Bathe(),
    )  # fmt: skip
    few, told, hyper = (
        tf.hyper_reduce(state(), trained, tolerance=tolerance, inputs=inputs)
        for tolerance, inputs in ((1e-2, []), (1e-2, [PULL["y"]]), (0.0, []))
    )
    bound = PULL["y"].prepare(state().system)
    assert few.missed(bound.columns)[0] > 0.05  # which runs tell: elements are chosen without the stress
    assert told.missed(bound.columns)[0] < 0.02
    assert told.weights.chosen < len(told.weights.values)
    assert hyper.missed(bound.columns)[0] == 0.0
    plant = tf.Plant(few, HUB, {"y": PULL["y"]}, {}, **ASKED | {"method": tf.Bathe()})
    plant.reset()
    assert any("the chosen elements miss" in text for text in plant.run.warnings)
    law = tf.PD(stiffness=160.0, damping=40.0, inertia=3.0) + (lambda time, y: [0.0, 0.3 if time % 0.2 < 0.1 else -0.3])
    slew, found = tf.Slew(angle=0.02, duration=0.5), []
    for body in (state(), hyper):
        plant = tf.Plant(
            body, HUB, {"torque": tf.HubTorque("x"), "y": PULL["y"]}, SENSORS, **ASKED | {"method": tf.Bathe()}
        )
        found.append(tf.close_loop(plant, law, slew, end_time=1.0, seed=1).data.measurement.values)
    off = np.sqrt(np.mean((found[1] - found[0]) ** 2, axis=0) / np.mean(found[0] ** 2, axis=0))
    for name, value, most in (("attitude", off[0], 1e-3), ("film", off[2], 0.05)):
        verification_row(f"hyper-reduced plant under a law and tension, {name}, rms", 0.0, float(value), "full plant")
        assert value < most
