"""Plants that are commanded step by step: the same runs, momentum, work, restarts, drives, and bad input."""

from __future__ import annotations

import json

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError, NotConvergedError
from tautflex.control.actuators.drive import Drive
from verification.dynamic_cases import small_antenna

pytestmark = pytest.mark.slow

TIP = tf.NodalForce([8], direction=(0.0, 0.0, 1.0))
DAMPING = tf.Rayleigh(0.01, 1e-4)
PROBES = {"A": (0.3, 0.1)}


def hub(**more) -> tf.FreeHub:
    return tf.FreeHub(mass=20.0, inertia=(3.0, 4.0, 5.0), **more)


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


def plant(state, actuators, sensors=None, free=True, **more) -> tf.Plant:
    sensors = {"attitude": tf.Attitude(), "rate": tf.Rate()} if sensors is None else sensors
    asked = {"damping": DAMPING, "probes": PROBES} | more
    return tf.Plant(state, hub() if free else None, actuators, sensors, **asked)


@pytest.mark.parametrize("free", [True, False], ids=["hub", "prescribed"])
def test_constant_commands_are_constant_inputs(state, free, verification_row):
    """To the bit: a command that does not change makes no jump, and the first one balances as a start does."""
    actuators = {"tip": TIP, **({"torque": tf.HubTorque("x")} if free else {})}
    stop = tf.Stop(rate=0.3, duration=0.05)
    driven = plant(state, actuators, {}, free, maneuver=None if free else stop)
    driven.reset()
    for _ in range(10):
        driven.step([0.003, 0.1] if free else 0.003)
    motion = hub(torque=(0.1, 0.0, 0.0)) if free else stop
    asked = {"method": tf.GeneralizedAlpha(), "damping": DAMPING, "probes": PROBES, "every": 2}
    run = tf.simulate(state, motion, inputs=[TIP.driven(0.003)], time_step=5e-3, end_time=0.1, **asked)
    off = np.abs(driven.run.data.w.values - run.data.w.values).max() / np.abs(run.data.w.values).max()
    assert off < 1e-12
    verification_row(f"plant under a constant command, {'hub' if free else 'prescribed'}", 0.0, off, "simulate")


def test_changed_commands_are_a_table_that_jumps(state):
    """A sampled force is a staircase."""
    driven, staircase = plant(state, {"tip": TIP}, {}, False), np.array([2e-3, -1e-3, 0.0, 4e-3])
    driven.reset()
    for value in staircase:
        driven.step(value)
    times = 0.01 * np.arange(1, 4)
    table = tf.TimeTable(np.repeat(times, 2), np.repeat(staircase, 2)[1:-1])
    asked = {"method": tf.GeneralizedAlpha(), "damping": DAMPING, "probes": PROBES, "every": 2}
    run = tf.simulate(state, inputs=[TIP.driven(table)], time_step=5e-3, end_time=0.04, **asked)
    scale = np.abs(run.data.w.values).max()
    np.testing.assert_allclose(driven.run.data.w.values, run.data.w.values, atol=1e-10 * scale)


def test_wheels_take_what_the_spacecraft_gets(state, verification_row):
    """Momentum of spacecraft and wheels about three axes, of a structure that vibrates."""
    driven = plant(state, {"torque": tf.HubTorque("xyz")})
    driven.reset()
    for k in range(30):
        driven.step([0.4 * np.sin(0.7 * k), 0.3 * np.cos(0.4 * k), -0.2])
    momentum = driven.run.data.angular_momentum.values[-1]
    (wheels,) = driven.wheel_momentum.values()
    off = float(np.abs(momentum + wheels).max() / np.abs(momentum).max())
    assert off < 1e-12
    verification_row("momentum of spacecraft and wheels", 0.0, off, "conserved")


def test_work_of_every_actuator(state, verification_row):
    """Their sum is what the energy balance calls loads."""
    tension = tf.TensionGroup("x", command="length", stiffness=1e3)
    actuators = {"torque": tf.HubTorque("x"), "tip": TIP, "tension": tf.Actuator(tension, limit=1e-4)}
    for free in (True, False):
        used = {name: each for name, each in actuators.items() if free or name != "torque"}
        driven = plant(state, used, free=free, maneuver=None if free else tf.Stop(rate=0.3, duration=0.05))
        driven.reset()
        for k in range(20):
            numbers = {"torque": 0.2 * np.sin(k), "tip": 5e-3 * np.cos(k), "tension": 5e-5 * np.sin(2.0 * k)}
            driven.step([numbers[name] for name in used])
        run = driven.run
        found, work = json.loads(run.data.attrs["energy_by_source"]), run.energy_balance["loads"]
        assert set(found) == set(used)
        assert all(value != 0.0 for value in found.values())
        assert sum(found.values()) == pytest.approx(work, rel=1e-8)
        assert abs(run.energy_balance["residual"]) < 1e-8 * max(map(abs, run.energy_balance.values()))
    verification_row("sum of the work of actuators [J]", work, sum(found.values()), "energy balance")


def test_work_of_actuators_is_the_energy_gained(state, verification_row):
    """Where the method neither takes nor gives, a held base and no damping: kinetic and strain energy, nothing else."""
    tension = tf.TensionGroup("x", command="tension")
    used = {"tip": TIP, "tension": tf.Actuator(tension, limit=0.05)}
    driven = plant(state, used, {}, free=False, damping=None, method=tf.EnergyConserving())
    driven.reset()
    for k in range(40):
        driven.step([5e-3 * np.cos(k), 0.03 * np.sin(2.0 * k)])
    done, terms = driven.energy_by_source, driven.run.energy_balance
    off = abs(terms["kinetic"] + terms["strain"] - terms["initial"] - sum(done.values()))
    size = sum(map(abs, done.values()))
    assert min(map(abs, done.values())) > 1e-3 * size
    verification_row("energy gained less work of force and tension, relative", 0.0, off / size, "conservation")
    assert off < 1e-8 * size


def test_stresses_that_jump_leave_no_waves_that_no_step_resolves(state, verification_row):
    """Tension that jumps in every interval of 10 ms: what the film does by steps of 5 ms against steps of 50 us."""
    table, off = 0.04 * np.random.default_rng(1).uniform(-1.0, 1.0, (12, 1)), []
    sensors = {"film": tf.Displacement([[0.3, 0.1], [-0.2, 0.2]])}
    used = {"tension": tf.TensionGroup("x", command="tension"), "tip": TIP}
    found = []
    for step, method in ((5e-5, tf.Bathe()), (5e-3, None)):
        driven = plant(state, used, sensors, time_step=step, method=method)
        found.append([driven.reset(), *(driven.step([*row, 2e-3]) for row in table)])
    off = float(np.abs(np.subtract(*found)).max() / np.abs(found[0]).max())
    verification_row("film under tension that jumps, steps of 5 ms against 50 us", 0.0, off, "finer steps")
    assert off < 0.05
    assert driven.run.stats.iterations < 6 * driven.run.stats.steps


def test_a_pd_loop_turns_the_hub(state):
    """With the whole inertia as feedforward the reference is followed, and what went through the loop is kept."""
    slew = tf.Slew(angle=0.1, duration=1.0)
    law = tf.PD(stiffness=40.0, damping=20.0, inertia=5.0)
    driven = plant(state, {"torque": tf.HubTorque("xyz", limit=5.0)}, interval=0.02, time_step=0.01)
    run = tf.close_loop(driven, law, slew, end_time=2.0)
    assert run.data.measurement.values[-1, 0] == pytest.approx(0.1, abs=2e-3)
    assert run.data.measurement.shape == (101, 6)
    assert run.data.command.shape == (101, 3)
    assert np.isnan(run.data.command.values[-1]).all()
    assert run.data.reference.values[-1, 0, 0] == pytest.approx(0.1)
    np.testing.assert_array_equal(run.data.time.values, run.data.sample_time.values)


def test_laws_that_need_a_model_get_that_of_the_plant(state):
    """A regulator with an estimator turns a hub and stops it there."""
    sensors = {"attitude": tf.Attitude(noise=1e-6), "rate": tf.Rate(noise=1e-6)}
    driven = plant(state, {"torque": tf.HubTorque("xyz")}, sensors, interval=0.02, time_step=0.01)
    law = tf.LQG(tolerances={"attitude": 1e-3}, efforts={"torque": 0.5}, modes=4)
    run = tf.close_loop(driven, law, tf.Slew(angle=0.01, duration=1.0), end_time=4.0)
    np.testing.assert_allclose(run.data.measurement.values[-1], [0.01, 0.0, 0.0, 0.0, 0.0, 0.0], atol=2e-4)


def test_linear_view_has_drives_and_late_sensors(state, verification_row):
    """Small commands through lags and delays: the sampled linear plant against the nonlinear one."""
    drive = {"lag": 0.03, "delay": 0.02}
    actuators = {"torque": tf.HubTorque("x", limit=1.0, **drive), "tip": tf.Actuator(TIP, **drive)}
    sensors = {"rate": tf.Rate(delay=0.015), "film": tf.Displacement([[0.3, 0.1]], delay=0.01)}
    driven = plant(state, actuators, sensors, time_step=1e-3)
    view = driven.linearize().discretize(0.01)
    assert view.remarks["torque"] == "without the limit of its drive"
    measured, z, found = [driven.reset()], np.zeros(len(view.A)), [np.zeros(4)]
    for k in range(60):
        command = np.array([1e-4 * np.sin(0.3 * k), 1e-6 * np.cos(0.2 * k)])
        measured.append(driven.step(command))
        z = view.A @ z + view.B @ command
        found.append(view.C @ z + view.D @ command)
    measured, found = np.array(measured), np.array(found)
    for name, column, most in (("rate", 0, 1e-3), ("film", 3, 1e-2)):
        off = np.abs(found - measured)[:, column].max() / np.abs(measured[:, column]).max()
        verification_row(f"Linear view with drives and late sensors, {name}", 0.0, off, "nonlinear plant, relative")
        assert off < most


@pytest.mark.parametrize("axes", ["xyz", "free"])
def test_matrices_of_a_hub_of_three_axes_are_its_small_motion(state, axes, verification_row):
    """Torques about all axes and a force on the film: python-control's answer against the nonlinear plant."""
    control = pytest.importorskip("control")
    sensors = {"attitude": tf.Attitude(), "rate": tf.Rate(), "A": tf.Displacement([0.3, 0.1])}
    body = tf.FreeHub(20.0, (3.0, 4.0, 5.0), center=(0.1, -0.05, 0.2), axes=axes)
    driven = tf.Plant(
        state, body, {"torque": tf.HubTorque("xyz"), "tip": TIP}, sensors, interval=0.02, time_step=2e-3,
        method=tf.GeneralizedAlpha(1.0), damping=DAMPING,
    )  # fmt: skip
    n = np.arange(40)
    commands = 1e-4 * np.column_stack([np.sin(0.3 * n), np.cos(0.2 * n), np.sign(np.sin(0.25 * n + 0.1)), 3e-3 * n])
    measured = np.array([driven.reset(), *(driven.step(row) for row in commands)])[1:-1]
    system = driven.linearize().discretize(0.02).to_control()
    outputs = control.forced_response(system, U=commands.T).outputs.T
    # What follows a command at once shows under the last one: y(k) = C x(k) + D u(k - 1).
    found = outputs[1:] + (commands[:-1] - commands[1:]) @ system.D.T
    names = [*(f"attitude about {axis}" for axis in "xyz"), *(f"rate about {axis}" for axis in "xyz"), "A"]
    for name, one, other in zip(names, found.T, measured.T, strict=True):
        off = float(np.abs(one - other).max() / np.abs(other).max())
        verification_row(f"Matrices of a hub with axes {axes!r}, {name}", 0.0, off, "nonlinear plant, relative")
        assert off < (1e-3 if "attitude" in name else 0.01)


def test_restarts_and_seeds(state):
    sensors = {"rate": tf.Rate(noise=1e-5, delay=0.015), "film": tf.Displacement([[0.3, 0.1]], noise=1e-7)}
    drive = {"lag": 0.03, "delay": 0.02, "rate": 5.0}
    driven = plant(state, {"torque": tf.HubTorque("x", **drive), "tip": tf.Actuator(TIP, **drive)}, sensors)

    def act(number: int):
        return driven.step([0.2 * np.sin(number), 1e-3 * np.cos(number)])

    def episode(seed: int):
        return np.array([driven.reset(seed=seed), *(act(k) for k in range(6))])

    first = episode(3)
    np.testing.assert_array_equal(first, episode(3))
    assert np.abs(first - episode(4)).max() > 0.0
    kept = driven.state
    later, record = np.array([act(k) for k in range(6, 12)]), driven.run.data
    there = driven.reset(options={"state": kept})
    np.testing.assert_array_equal(there, kept.measurement)
    np.testing.assert_array_equal(np.array([act(k) for k in range(6, 12)]), later)
    np.testing.assert_array_equal(driven.run.data.w.values, record.w.values[7:])
    assert driven.run.energy_balance["loads"] == pytest.approx(sum(driven.energy_by_source.values()), rel=1e-8)


def test_long_episodes_are_one_record(state, monkeypatch):
    """Samples are reserved a part at a time; where one part ends nothing is to be seen."""
    whole = plant(state, {"torque": tf.HubTorque("x")})
    monkeypatch.setattr("tautflex.control.plant._RESERVED", 4)
    parts = plant(state, {"torque": tf.HubTorque("x")})
    for each in (whole, parts):
        monkeypatch.setattr("tautflex.control.plant._RESERVED", 1024 if each is whole else 4)
        each.reset()
        for k in range(11):
            each.step(0.1 * np.sin(k))
    one, other = whole.run, parts.run
    for name in ("time", "w", "attitude", "kinetic_energy", "angular_momentum"):
        np.testing.assert_array_equal(one.data[name].values, other.data[name].values)
    assert one.energy_balance == other.energy_balance
    assert one.stats.steps == other.stats.steps


def test_drives_in_closed_form():
    interval = 0.1
    lag = Drive(lag=0.25)
    memory, impulse = lag.start(1, interval), 0.0
    for k in range(1, 20):
        memory, acts = lag.act(memory, np.array([2.0]), interval)
        impulse += interval * float(acts[0])
        decayed = np.exp(-k * interval / 0.25)
        assert memory.output[0] == pytest.approx(2.0 * (1.0 - decayed), rel=1e-12)
        assert impulse == pytest.approx(2.0 * (k * interval - 0.25 * (1.0 - decayed)), rel=1e-12)
    for drive, expected in (
        (Drive(limit=0.5), [0.5, 0.5, -0.5]),
        (Drive(rate=3.0), [0.3, 0.6, 0.3]),
        (Drive(delay=0.2), [0.0, 0.0, 0.9]),
        (Drive(resolution=0.4), [0.8, 0.8, -2.0]),
    ):
        memory, found = drive.start(1, interval), []
        for command in (0.9, 0.9, -2.0):
            memory, acts = drive.act(memory, np.array([command]), interval)
            found.append(float(acts[0]))
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_full_wheels_give_no_more(state):
    driven = plant(state, {"torque": tf.HubTorque("x", momentum=0.02)})
    driven.reset()
    for _ in range(10):
        driven.step(0.5)
    assert driven.wheel_momentum["torque"][0] == pytest.approx(-0.02, rel=1e-12)
    driven.step(-0.5)
    assert driven.wheel_momentum["torque"][0] == pytest.approx(-0.015, rel=1e-12)


def test_laws_that_fail_leave_what_was_done(state):
    driven = plant(state, {"torque": tf.HubTorque("x")})

    def breaks(time, measurement):
        if time > 0.045:
            raise ZeroDivisionError("no more")
        return 0.1

    for law, said in ((breaks, "ZeroDivisionError"), (lambda t, y: np.nan if t > 0.045 else 0.1, "the law failed")):
        with pytest.raises(NotConvergedError, match=r"t = 0\.05 s: .*") as caught:
            tf.close_loop(driven, law, end_time=0.2)
        assert said in str(caught.value)
        data = caught.value.result.data
        assert data.time.values[-1] == pytest.approx(0.05)
        assert data.measurement.sizes["sample_time"] == 6


def test_bad_plants_are_told(state):
    torque = {"torque": tf.HubTorque("x")}
    for more, message in (
        ({"time_step": 3e-3}, r"time_step: expected a whole part of the interval \(0.01 s\), got 0.003; set for"),
        ({"sensors": {"torque": tf.Rate()}}, "sensors.torque: expected a name of its own"),
        ({"sensors": {"rate": tf.Rate}}, "sensors.rate: expected a sensor such as"),
        ({"actuators": {"torque": 3.0}}, r"actuators.torque: expected HubTorque\(...\), or an effect"),
        ({"actuators": {"tip": TIP.driven(1.0)}}, "actuators.tip: expected an effect without a signal"),
        ({"actuators": {"torque": tf.HubTorque(delay=0.015)}}, "actuators.torque.delay: expected whole intervals of"),
        ({"method": tf.CentralDifference()}, "method: expected an implicit method"),
        ({"interval": 0.0}, "interval: expected"),
        ({"actuators": {"t": tf.TensionGroup([999])}}, r"actuators\.t\.cables: expected cable numbers in"),
    ):
        with pytest.raises(InputError, match=message):
            plant(state, **({"actuators": torque} | more))
    with pytest.raises(InputError, match="expected a free hub"):
        plant(state, torque, free=False)
    about_x = {"hub": hub(axes="x"), "actuators": {"torque": tf.HubTorque("y")}}
    with pytest.raises(InputError, match=r"torque\.axis: expected an axis that the hub turns about, 'x', got 'y'"):
        tf.Plant(state, **about_x)
    for limit in (0.0, [], [1.0, -1.0]):
        with pytest.raises(InputError, match="limit: expected"):
            tf.HubTorque("x", limit=limit)
    for made, key in ((tf.HubTorque, "limit"), (tf.HubTorque, "rate"), (tf.Rate, "noise"), (tf.Rate, "bias")):
        with pytest.raises(
            InputError, match=f"^{key}: expected a finite number, got '0.5'; write it without quotes: 0.5$"
        ):
            made(**{key: "0.5"})
    made = plant(state, torque)
    with pytest.raises(InputError, match="expected reset before this"):
        made.step(0.0)
    made.reset()
    for command in ([0.0, 1.0], np.nan, [[0.0]]):
        with pytest.raises(InputError, match="command: expected"):
            made.step(command)
    with pytest.raises(InputError, match="options: expected 'state', 'maneuver', 'frames' or 'runs', got 'sate'"):
        made.reset(options={"sate": None})
    assert [(each.name, each.unit) for each in made.inputs] == [("torque", "N m")]
    assert "torque [N m]" in repr(made)
