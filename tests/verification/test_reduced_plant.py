"""Plants of reduced models: the same runs, restarts, work and readings, compiled or not, and the full structure."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh

import tautflex as tf
from tautflex import InputError, NotConvergedError, UnsupportedError
from verification.dynamic_cases import small_antenna

pytestmark = pytest.mark.slow

PULL = {axis: tf.TensionGroup(axis, command="tension") for axis in "xy"}
TIP = tf.NodalForce([8], direction=(0.0, 0.0, 1.0))
DAMPING = tf.Rayleigh(0.01, 1e-4)
BODY = {"mass": 20.0, "inertia": (3.0, 4.0, 5.0)}
ABOUT_X = tf.FreeHub(**BODY, axes="x", angular_velocity=(0.1, 0.0, 0.0))
ACTUATORS = {
    "torque": tf.HubTorque("x", limit=5.0),
    **{name: tf.Actuator(each) for name, each in PULL.items()},
    "tip": TIP,
}
SENSORS = {
    "attitude": tf.Attitude(),
    "rate": tf.Rate(noise=1e-6, delay=0.015),
    "film": tf.Displacement([[0.3, 0.1], [0.2, 0.15]], bias=1e-6, resolution=1e-9),
    "speed": tf.Velocity([0.3, 0.1]),
    "rms": tf.SurfaceRms(),
    "tension": tf.CableTensionSensor(),
    "modes": tf.ModalCoordinates(3),
}
ASKED = {"interval": 0.01, "time_step": 1e-3, "damping": DAMPING}


@cache
def state():
    return tf.equip(tf.solve_prestress(small_antenna()), list(PULL.values()))


@cache
def rom():
    return tf.reduce(state(), tf.ModalBasis(count=8, candidates=80))


def commands(count: int, torque: float | None = None):
    """Torque [N m], tensions [N] and a force [N]."""
    n = np.arange(count)
    turn = 2.0 * np.sign(np.sin(n + 0.5)) if torque is None else np.full(count, torque)
    return np.column_stack([turn, 0.03 * np.cos(n), 0.03 * np.sin(1.7 * n), 2e-3 * np.cos(3.0 * n)])


def test_changed_commands_are_a_table_that_jumps():
    driven, table = tf.Plant(rom(), ABOUT_X, ACTUATORS, {}, probes={"A": (0.3, 0.1)}, **ASKED), commands(10, 0.5)
    table[0, 1:] = 0.0
    driven.reset()
    for row in table:
        driven.step(row)
    times = np.repeat(0.01 * np.arange(1, 10), 2)
    inputs = [
        effect.driven(tf.TimeTable(times, np.repeat(table[:, k], 2)[1:-1]))
        for k, effect in enumerate((*PULL.values(), TIP), 1)
    ]
    hub = tf.FreeHub(**BODY, axes="x", angular_velocity=(0.1, 0.0, 0.0), torque=(0.5, 0.0, 0.0))
    asked = {"method": tf.CentralDifference(), "damping": DAMPING, "probes": {"A": (0.3, 0.1)}, "every": 10}
    run = tf.simulate(rom(), hub, inputs=inputs, time_step=1e-3, end_time=0.1, **asked)
    for name in ("w", "attitude", "angular_velocity", "kinetic_energy"):
        one, other = driven.run.data[name].values, run.data[name].values
        np.testing.assert_allclose(one, other, atol=1e-9 * np.abs(other).max())


@pytest.mark.parametrize(
    ("hub", "left_out"),
    [
        (ABOUT_X, ()),
        (ABOUT_X, ("tension",)),
        (tf.FreeHub(**BODY, axes="x", attitude=(0.8, 0.0, 0.6, 0.0)), ()),
        (tf.FreeHub(**BODY, angular_velocity=(0.1, 0.2, 0.0)), ()),
    ],
    ids=["about x", "linear readings", "tilted", "free"],
)
def test_the_compiled_loop_is_the_same_loop(hub, left_out, verification_row):
    """Readings of every sensor and the work of every actuator, to round-off."""
    drive = {"lag": 0.03, "delay": 0.02, "rate": 5.0, "resolution": 1e-4}
    wheel = tf.HubTorque("x", limit=1.5, momentum=0.1, lag=0.01)
    actuators = {**ACTUATORS, "torque": wheel, "tip": tf.Actuator(TIP, **drive)}
    sensors = {name: each for name, each in SENSORS.items() if name not in left_out}
    plant = tf.Plant(rom(), hub, actuators, sensors, **ASKED)
    fast = tf.CompiledPlant(rom(), hub, actuators, sensors, **ASKED)
    table = commands(40)
    slow = np.array([plant.reset(seed=3), *(plant.step(row) for row in table)])
    quick = np.array([fast.reset(seed=3), *(fast.step(row).copy() for row in table)])
    # Of each sensor's largest reading: coordinates of modes that stay still are round-off.
    ends = np.cumsum([sensor.size for sensor in plant.outputs])[:-1]
    off = np.array([np.abs(own).max() for own in np.split(quick - slow, ends, 1)])
    off /= [np.abs(own).max() for own in np.split(slow, ends, 1)]
    assert off.max() < 1e-9
    work = np.array(list(plant.energy_by_source.values()))
    np.testing.assert_allclose(fast.work[0], work, rtol=1e-9)
    verification_row("compiled loop against a plant's, largest part of any reading", 0.0, float(off.max()), "same loop")


def test_plants_side_by_side_are_plants():
    """Row n with seed s is a plant alone with seed s + n; gains and offsets are its own; a reset moves no other."""
    many, one = (tf.CompiledPlant(rom(), ABOUT_X, ACTUATORS, SENSORS, count=n, **ASKED) for n in (3, 1))
    table = np.array([commands(6) * share for share in (1.0, 0.5, -1.0)])
    many.gain[1], many.offset[1, 1] = 0.8, 0.01
    found = [many.reset(seed=5), *(many.step(row).copy() for row in table.transpose(1, 0, 2))]
    for n in range(3):
        one.gain[0], one.offset[0] = many.gain[n], many.offset[n]
        alone = [one.reset(seed=5 + n), *(one.step(row).copy() for row in table[n])]
        np.testing.assert_array_equal(np.array(found)[:, n], alone)
    assert many.value[1, 1] == pytest.approx(0.8 * table[1, -1, 1] + 0.01)
    before = many.measurement.copy()
    many.reset(seed=6, row=1)
    np.testing.assert_array_equal(many.time, [0.06, 0.0, 0.06])
    np.testing.assert_array_equal(many.measurement[[0, 2]], before[[0, 2]])
    assert not many.failed.any()


def test_a_crowd_is_plants():
    """Rows of several blocks are plants alone to the bit; one that is too stiff fails, stays, and moves no other."""
    crowd, one = (tf.CompiledPlant(rom(), ABOUT_X, ACTUATORS, SENSORS, count=n, **ASKED) for n in (67, 1))
    table, shares = commands(8), np.linspace(-1.0, 1.0, 67)
    crowd.reset(seed=5)
    still = crowd.reset(seed=1, row=40, coordinates=1e4 * rom().basis.amplitude)
    found = np.array([crowd.step(shares[:, None] * row).copy() for row in table])
    for n in (0, 13, 63, 64, 66):
        one.reset(seed=5 + n)
        np.testing.assert_array_equal(found[:, n], [one.step(shares[n] * row).copy() for row in table])
    assert np.flatnonzero(crowd.failed).tolist() == [40]
    np.testing.assert_array_equal(found[-1, 40], still)
    assert crowd.time[40] == 0.0
    assert one.linearize(3) is one.linearize(3)


@pytest.mark.parametrize("free", [True, False], ids=["hub", "prescribed"])
@pytest.mark.parametrize("method", [None, tf.Newmark()], ids=["central difference", "Newmark"])
def test_restarts_to_the_bit(free, method):
    actuators = {name: each for name, each in ACTUATORS.items() if free or name != "torque"}
    more = {} if free else {"maneuver": tf.Stop(rate=0.3, duration=0.05)}
    plant = tf.Plant(rom(), ABOUT_X if free else None, actuators, SENSORS, method=method, **ASKED, **more)
    table = commands(10)[:, 0 if free else 1 :]
    plant.reset(seed=2)
    for row in table[:5]:
        plant.step(row)
    kept = plant.state
    later, balance = [plant.step(row) for row in table[5:]], plant.run.energy_balance
    np.testing.assert_array_equal(plant.reset(options={"state": kept}), kept.measurement)
    np.testing.assert_array_equal([plant.step(row) for row in table[5:]], later)
    assert plant.run.energy_balance == balance


@pytest.mark.parametrize("free", [True, False], ids=["hub", "prescribed"])
@pytest.mark.parametrize("method", [None, tf.Newmark()], ids=["central difference", "Newmark"])
def test_works_of_all_actuators_meet_the_balance_to_second_order(free, method, verification_row):
    """Tension works exactly where it jumps, by trapezoidal rule between: half the step, a quarter of the difference."""
    actuators = {name: each for name, each in ACTUATORS.items() if free or name != "torque"}
    more = {} if free else {"maneuver": tf.Stop(rate=0.3, duration=0.05)}
    off = []
    for step in (1e-3, 5e-4):
        asked = {**ASKED, "time_step": step, "method": method, **more}
        plant = tf.Plant(rom(), ABOUT_X if free else None, actuators, {}, **asked)
        plant.reset()
        for row in commands(10)[:, 0 if free else 1 :]:
            plant.step(row)
        run = plant.run
        found = json.loads(run.data.attrs["energy_by_source"])
        assert found == plant.energy_by_source
        off.append(sum(found.values()) - run.energy_balance["loads"])
    order = np.log2(off[0] / off[1])
    verification_row("work of actuators against energy balance, order in the step", 2.0, float(order), "second order")
    assert order == pytest.approx(2.0, abs=0.1)


def test_a_hub_run_that_was_cut_is_one_run():
    asked = {"time_step": 1e-3, "inputs": [TIP.driven(tf.TimeTable([0.0, 0.1], [0.0, 5e-3]))], "damping": DAMPING}
    for method in (tf.CentralDifference(), tf.GeneralizedAlpha(0.8), tf.Bathe()):
        for hub in (ABOUT_X, tf.FreeHub(**BODY, angular_velocity=(0.1, 0.2, 0.0))):
            whole = tf.simulate(rom(), hub, end_time=0.1, method=method, **asked)
            first = tf.simulate(rom(), hub, end_time=0.04, method=method, **asked)
            second = tf.simulate(rom(), hub, end_time=0.1, method=method, initial=first.final, **asked)
            np.testing.assert_array_equal(second.data.coordinate.values[-1], whole.data.coordinate.values[-1])
            np.testing.assert_array_equal(second.data.attitude.values[-1], whole.data.attitude.values[-1])
            assert second.energy_balance == whole.energy_balance


def test_tables_and_linear_laws_run_compiled():
    """A table is its steps; a linear law gives what it gives interval by interval; more intervals than one draw."""
    plants, one = (tf.CompiledPlant(rom(), ABOUT_X, ACTUATORS, SENSORS, count=n, **ASKED) for n in (2, 1))
    table = commands(600)
    measured, told = plants.run(table, seed=4)
    alone = [one.reset(seed=5), *(one.step(row).copy() for row in table)]
    np.testing.assert_array_equal(measured[:, 1], alone)
    np.testing.assert_array_equal(told[:, 0], table)
    actuators = {"torque": tf.HubTorque("x")}
    sensors = {"attitude": tf.Attitude(noise=1e-6), "rate": tf.Rate(noise=1e-6)}
    asked = {"interval": 0.02, "time_step": 2e-3, "damping": DAMPING}
    hub, slew = tf.FreeHub(**BODY, axes="x"), tf.Slew(angle=0.02, duration=0.5)
    for law in (tf.PD(stiffness=40.0, damping=20.0, inertia=3.0), tf.LQG({"attitude": 1e-3}, {"torque": 0.5}, modes=4)):
        fast = tf.CompiledPlant(rom(), hub, actuators, sensors, count=2, **asked)
        measured, told = fast.run(law, slew, end_time=1.0, seed=1)
        loop = tf.close_loop(tf.Plant(rom(), hub, actuators, sensors, **asked), law, slew, end_time=1.0, seed=2)
        np.testing.assert_allclose(measured[:, 1], loop.data.measurement.values, atol=1e-9)
        np.testing.assert_allclose(told[:, 1], loop.data.command.values[:-1], atol=1e-7)


@pytest.mark.parametrize("kind", ["full", "reduced", "compiled"])
def test_tension_that_pumps_is_switched_off(kind):
    """Stiffness high on the way out and low on the way back damps; the other way round it pumps."""
    period = 2.0 * np.pi / float(state().linear.modes(1)[0][0])
    interval = period / 40.0
    actuators = {
        "tip": TIP,
        "y": tf.Actuator(PULL["y"], limit=0.5, monitor=True),
        "x": tf.Actuator(PULL["x"], monitor=True),
    }
    sensors = {"place": tf.Displacement([0.3, 0.1]), "speed": tf.Velocity([0.3, 0.1])}
    asked = {"interval": interval, "time_step": interval / np.ceil(interval / 1e-3), "damping": tf.Rayleigh(0.0, 1e-5)}
    hub = tf.FreeHub(1e5, (1e5, 1e5, 1e5), axes="x")
    made = tf.CompiledPlant if kind == "compiled" else tf.Plant
    asked |= {"method": tf.Bathe(), "time_step": interval} if kind == "full" else {}
    plant = made(state() if kind == "full" else rom(), hub, actuators, sensors, **asked)
    for sign, expected in ((1.0, ()), (-1.0, ("y",))):
        y = plant.reset()
        for k in range(200):
            pull = 0.3 * sign * np.sign(y[0] * y[1]) if k >= 10 else 0.0
            y = plant.step([2e-3 if k < 10 else 0.0, pull, 0.0])
        off = plant.switched_off
        assert (tuple(np.array(["tip", "y", "x"])[off[0]]) if kind == "compiled" else off) == expected


def test_laws_close_the_loop_around_a_reduced_model():
    """A slew by a regulator with an estimator, and by a PD law."""
    actuators, slew = {"torque": tf.HubTorque("x")}, tf.Slew(angle=0.02, duration=0.5)
    sensors = {"attitude": tf.Attitude(noise=1e-6), "rate": tf.Rate(noise=1e-6)}
    hub = tf.FreeHub(**BODY, axes="x")
    for law in (
        tf.PD(stiffness=160.0, damping=40.0, inertia=3.0),
        tf.LQG({"attitude": 1e-3}, {"torque": 0.5}, modes=4),
    ):
        plant = tf.Plant(rom(), hub, actuators, sensors, interval=0.02, time_step=2e-3, damping=DAMPING)
        run = tf.close_loop(plant, law, slew, end_time=2.0)
        np.testing.assert_allclose(run.data.measurement.values[-1], [0.02, 0.0], atol=5e-4)


def test_reduced_and_full_plant_agree(verification_row):
    """Bang-bang torque with switched tension."""
    sensors = {"attitude": tf.Attitude(), "film": tf.Displacement([0.3, 0.1])}
    found = {}
    for name, plant in (("full", state()), ("reduced", rom())):
        driven = tf.Plant(plant, tf.FreeHub(**BODY, axes="x"), ACTUATORS, sensors, **ASKED)
        driven.reset()
        found[name] = np.array(
            [driven.step([2.0 * (-1) ** (k // 10), 0.5 * (-1) ** (k // 3), 0.0, 0.0]) for k in range(40)]
        )
    off = np.sqrt(np.mean((found["reduced"] - found["full"]) ** 2, axis=0) / np.mean(found["full"] ** 2, axis=0))
    assert off[0] < 1e-3
    assert off[1] < 0.05
    verification_row("reduced against full plant, attitude, rms", 0.0, float(off[0]), "full model")
    verification_row("reduced against full plant, film under switched tension, rms", 0.0, float(off[1]), "full model")


def test_answers_to_tension_are_two_coordinates_each(verification_row):
    """The frame answers slowly, the film fast: bang-bang torque and tension switched by a half, small motion.

    Where tension is prescribed the film does not wait for the frame, as it did with one coordinate for both.
    """
    effects = list(PULL.values())
    sensors, found = {"attitude": tf.Attitude(), "film": tf.Displacement([0.3, 0.1])}, []
    asked = {"interval": 0.01, "time_step": 5e-3, "damping": tf.Rayleigh(1e-3, 1e-3), "method": tf.Bathe()}
    answered = tf.reduce(state(), tf.ModalBasis(("rx",), count=12, candidates=80), inputs=effects)
    actuators = {"torque": tf.HubTorque("x"), **PULL}
    for body in (state(), answered):
        plant = tf.Plant(body, tf.FreeHub(**BODY, axes="x"), actuators, sensors, **asked)
        plant.reset()
        rows = ([0.1 * (-1) ** (k // 40), *[0.5 * (-1) ** (k // 10)] * 2] for k in range(80))
        found.append(np.array([plant.step(row) for row in rows]))
        # What stresses store at rest, which may be negative, is no energy of motion.
        assert not any("outside its basis" in text for text in plant.run.warnings)
    off = np.sqrt(np.mean((found[1] - found[0]) ** 2, axis=0) / np.mean(found[0] ** 2, axis=0))
    for name, value, most in zip(("attitude", "film"), off, (1e-6, 0.01), strict=True):
        verification_row(f"reduced plant, answers to switched tension, {name}, rms", 0.0, float(value), "full plant")
        assert value < most


@pytest.mark.parametrize("hub", [None, ABOUT_X], ids=["prescribed", "hub"])
@pytest.mark.parametrize("kind", [tf.Plant, tf.CompiledPlant])
def test_the_step_that_is_not_given_is_stable(kind, hub):
    """At most half of 2 / w, w the fastest of the coordinates; tensions that are switched keep it stable."""
    c = rom().coefficients
    fastest = np.sqrt(eigh(c.linear, c.mass, eigvals_only=True)[-1])
    assert 2.0 / fastest < 5e-3
    plant = kind(rom(), hub, PULL, {"rate": tf.Rate()}, interval=0.02, damping=DAMPING)
    assert plant.interval / plant._steps <= 1.0 / fastest
    plant.reset()
    for sign in np.tile([1.0, -1.0], 25):
        plant.step(np.array([0.05 * sign, -0.05 * sign]))
    assert kind is tf.Plant or not plant.failures.any()


def test_bad_plants_are_told():
    bare = tf.solve_prestress(small_antenna())
    with pytest.raises(InputError, match="use equip"):
        tf.Plant(tf.reduce(bare, tf.ModalBasis(count=3)), ABOUT_X, {"x": PULL["x"]})
    with pytest.raises(InputError, match="time_step: expected at most the stable step"):
        tf.Plant(rom(), ABOUT_X, ACTUATORS, {}, time_step=0.01).reset()
    with pytest.raises(InputError, match=r"actuators\.tip\.monitor: expected false where no stress is changed"):
        tf.Plant(rom(), ABOUT_X, {"tip": tf.Actuator(TIP, monitor=True)})
    with pytest.raises(UnsupportedError, match="rom: expected a reduced model"):
        tf.CompiledPlant(state(), ABOUT_X)
    with pytest.raises(UnsupportedError, match="hub: expected constant force and torque"):
        tf.CompiledPlant(rom(), tf.FreeHub(**BODY, axes="x", torque=lambda time, hub: (0.0, 0.0, 0.0)))
    with pytest.raises(InputError, match=r"torque\.axis: expected an axis that the hub turns about, 'x', got 'xyz'"):
        tf.CompiledPlant(rom(), ABOUT_X, {"torque": tf.HubTorque("xyz")})
    plants = tf.CompiledPlant(rom(), ABOUT_X, ACTUATORS, **ASKED)
    assert "torque [N m]" in repr(plants)
    for wrong, said in (
        (lambda: plants.step([1.0, 2.0]), r"command: expected shape \(1, 4\), got \(2,\)"),
        (lambda: plants.run(np.zeros((3, 5))), r"law: expected shape \(any, 1, 4\), got \(3, 5\)"),
        (lambda: plants.run(lambda time, y: np.zeros(4), end_time=0.0), "end_time: expected a number > 0"),
        (lambda: plants.reset(row=1), r"row: expected a number in \[0, 0\], got 1"),
    ):
        with pytest.raises(InputError, match=said):
            wrong()
    with pytest.raises(NotConvergedError, match=r"t = 0\.03 s: the law failed .ZeroDivisionError") as caught:
        plants.run(lambda time, y: 1.0 / 0.0 if time > 0.025 else np.zeros(4), end_time=0.1)
    assert [len(part) for part in caught.value.result] == [4, 3]
