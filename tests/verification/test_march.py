"""Stretches of steps in one compiled call give, to the bit, what steps taken one by one do."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import tautflex as tf
from tautflex import checks
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.march.stretch import March
from tautflex.solvers.transient.status import Status
from tautflex.solvers.transient.step_kernel import recalled
from verification.dynamic_cases import small_antenna

STOP, SPIN = tf.Stop(rate=2.0, duration=0.03), tf.SpinUp(rate=3.0, duration=0.04)
MODAL = tf.Modal(0.02, modes=3)
HUB = tf.FreeHub(20.0, (4.0, 5.0, 6.0), torque=(0.2, 0.05, 0.1), force=(0.1, 0.0, 0.3))
FREE = tf.FreeHub(20.0, (4.0, 5.0, 6.0), angular_velocity=(0.3, 0.2, -0.1), velocity=(0.1, 0.0, 0.05))
LINE = tf.FreeHub(20.0, (4.0, 5.0, 6.0), torque=(0.2, 0.0, 0.0), axes="x")
TABLE = tf.TimeTable([0.0, 0.06], [[0.0, 0.0, 0.0], [0.0, 0.001, 0.001]])


def push(time):
    """Force [N] that jumps at 0.06 s."""
    return [0.0, 0.0, 0.001 * np.sin(60.0 * time) if time < 0.06 else 0.0]


FORCED = [tf.NodalForce([7], push, breaks=(0.06,)), tf.NodalForce([0, 8], [0.0, 0.001, 0.001])]


def turning(time, hub):
    """Torque [N m] in time alone."""
    return [0.2 * np.sin(40.0 * hub.time), 0.05 if time < 0.05 else 0.1, 0.1]


def pull(time):
    """Tension [N] that jumps at 0.06 s."""
    return 0.05 * np.sin(60.0 * time) if time < 0.06 else 0.02


PULLED = [tf.CableTension(pull, breaks=(0.06,)), FORCED[1]]
WARMED = [tf.MembraneTemperature(tf.TimeTable([0.0, 0.03, 0.07], [0.0, 2.0, 2.0]), 1e-6), FORCED[0]]
DRIVEN = tf.FreeHub(20.0, (4.0, 5.0, 6.0), torque=turning, force=(0.1, 0.0, 0.3), breaks=(0.05,))
RUNS = {
    "wilson-theta": (STOP, {"method": tf.WilsonTheta()}),
    "newmark, every third": (SPIN, {"method": tf.Newmark(), "every": 3}),
    "generalized-alpha, fields": (STOP, {"method": tf.GeneralizedAlpha(0.6), "fields": [0.02, 0.05]}),
    "no maneuver, no estimate": (None, {"initial_velocity": lambda x, y: 0.3 * np.cos(x) * y, "time_error": False}),
    "forces in time": (STOP, {"inputs": [tf.NodalForce([7], push, breaks=(0.06,)), tf.NodalForce([8], TABLE)]}),
    "constant force, modal damping": (SPIN, {"inputs": [tf.NodalForce([7], [0.0, 0.0, 0.001])], "damping": MODAL}),
    "generalized-alpha, force, modal damping": (
        STOP,
        {"method": tf.GeneralizedAlpha(0.6), "inputs": [tf.NodalForce([7], push, breaks=(0.06,))], "damping": MODAL},
    ),
    "free hub, a torque": (HUB, {"method": tf.Newmark()}),
    "free hub, wilson-theta, every third": (FREE, {"method": tf.WilsonTheta(), "every": 3}),
    "free hub, a torque and forces in time": (DRIVEN, {"method": tf.Newmark(), "inputs": FORCED}),
    "free hub, the same, wilson-theta": (DRIVEN, {"method": tf.WilsonTheta(), "inputs": FORCED}),
    "free hub, the same, generalized-alpha": (DRIVEN, {"method": tf.GeneralizedAlpha(0.6), "inputs": FORCED}),
    "bathe, forces in time": (STOP, {"method": tf.Bathe(), "inputs": FORCED, "every": 3, "damping": MODAL}),
    "bathe, free hub": (DRIVEN, {"method": tf.Bathe(), "inputs": FORCED}),
    "energy-conserving": (STOP, {"method": tf.EnergyConserving(), "inputs": FORCED}),
    "energy-conserving, free hub": (DRIVEN, {"method": tf.EnergyConserving()}),
    "hub about a line, generalized-alpha": (LINE, {"method": tf.GeneralizedAlpha(0.6), "damping": MODAL}),
    "tension in time, every third": (STOP, {"method": tf.WilsonTheta(), "inputs": PULLED, "every": 3}),
    "tension that stays": (STOP, {"method": tf.Newmark(), "inputs": [tf.CableTension(0.03)]}),
    "bathe, temperature that rises and stays": (STOP, {"method": tf.Bathe(), "inputs": WARMED, "fields": [0.02, 0.08]}),
    "energy-conserving, tension in time": (STOP, {"method": tf.EnergyConserving(), "inputs": PULLED}),
    "free hub, tension in time": (DRIVEN, {"method": tf.GeneralizedAlpha(0.6), "inputs": [*PULLED, *WARMED]}),
    "turn about another line": (
        tf.Slew(0.2, 0.06, origin=(0.0, 0.3, 0.0)),
        {"coupling": tf.Coupling(inertial_load=0.5)},
    ),
    "bathe, large motion, hard steps": (
        None,
        {"initial_velocity": lambda x, y: 4.0 * np.cos(2.0 * x), "time_step": 2e-3, "method": tf.Bathe()},
    ),
    "large motion, hard steps": (None, {"initial_velocity": lambda x, y: 4.0 * np.cos(2.0 * x), "time_step": 2e-3}),
}


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


@pytest.fixture
def one_by_one(monkeypatch):
    """Switch stretches off."""

    def switch_off():
        monkeypatch.setattr(March, "serves", staticmethod(lambda *parts: False))

    return switch_off


def answer(state, name, **more):
    maneuver, question = RUNS[name]
    asked = {"time_step": 1e-3, "end_time": 0.1, "damping": tf.Rayleigh(0.1, 1e-4), "probes": {"A": (0.3, 0.2)}}
    return tf.simulate(state, maneuver, **(asked | question | more))


def assert_same(one, other):
    for name, values in one.data.items():
        np.testing.assert_array_equal(values, other.data[name], err_msg=name)
    assert one.energy_balance == other.energy_balance
    assert one.warnings == other.warnings
    assert one.error == other.error or (np.isnan(one.error) and np.isnan(other.error))
    for name, values in one.final.memory.items():
        np.testing.assert_array_equal(values, other.final.memory[name], err_msg=name)
    for name in ("steps", "iterations", "factorizations", "back_substitutions", "force_evaluations", "halvings"):
        assert getattr(one.stats, name) == getattr(other.stats, name), name


@pytest.mark.parametrize("name", RUNS)
def test_stretches_have_the_numbers_of_single_steps(state, one_by_one, monkeypatch, name):
    taken, take = [], March.take

    def counted(march, at, number, last, segment):
        reached, end = take(march, at, number, last, segment)
        taken.append(reached - number)
        return reached, end

    monkeypatch.setattr(March, "take", counted)
    together = answer(state, name)
    assert sum(taken) > (0.1 if "hard" in name else 0.8) * together.stats.steps
    one_by_one()
    assert_same(together, answer(state, name))


@pytest.mark.parametrize("name", ["large motion, hard steps", "newmark, every third"])
def test_stretches_begin_with_a_new_tangent(state, monkeypatch, name):
    driven, advance = [], GridDriver.advance

    def counted(driver, at, target):
        driven.append(target)
        return advance(driver, at, target)

    monkeypatch.setattr(GridDriver, "advance", counted)
    monkeypatch.setattr("tautflex.solvers.transient.implicit._REFRESH_COST", 4)
    run = answer(state, name)
    assert run.stats.factorizations > len(driven) + 3


def test_a_tangent_that_cannot_be_factorized_is_the_drivers(state, monkeypatch):
    factorize, seen = SymmetricFactorization.factorize_upper, []

    def failing(factor, upper):
        seen.append(len(upper))
        if len(seen) in {6, 7}:  # once in a stretch, and again in the step that the driver takes
            raise np.linalg.LinAlgError("singular")
        factorize(factor, upper)

    monkeypatch.setattr("tautflex.solvers.transient.implicit._REFRESH_COST", 4)
    monkeypatch.setattr(SymmetricFactorization, "factorize_upper", failing)
    together = answer(state, "large motion, hard steps")
    assert together.stats.halvings > 0
    assert together.status is Status.COMPLETED


@pytest.mark.parametrize("cost", [2, 4])
def test_a_tangent_that_grows_old_between_stages_leaves_the_step_to_the_driver(state, one_by_one, monkeypatch, cost):
    monkeypatch.setattr("tautflex.solvers.transient.implicit._REFRESH_COST", cost)
    together = answer(state, "bathe, large motion, hard steps")
    assert together.stats.factorizations > 5
    one_by_one()
    assert_same(together, answer(state, "bathe, large motion, hard steps"))


@pytest.mark.parametrize("end", [0.0, 0.03, 1.0])
def test_a_torque_that_looks_at_the_motion_is_the_drivers(state, one_by_one, monkeypatch, end):
    """From 0.03 s on, or always, or never within the run."""

    def torque(time, hub):
        return [0.2 - (0.5 * hub.angular_velocity[0] if time >= end else 0.0), 0.05, 0.1]

    taken, take = [], March.take

    def counted(march, at, number, last, segment):
        reached, there = take(march, at, number, last, segment)
        taken.append(reached - number)
        return reached, there

    monkeypatch.setattr(March, "take", counted)
    hub = tf.FreeHub(20.0, (4.0, 5.0, 6.0), torque=torque)
    asked = {"method": tf.Newmark(), "time_step": 1e-3, "end_time": 0.06}
    together = tf.simulate(state, hub, **asked)
    assert sum(taken) == pytest.approx(min(60, round(end / 1e-3)), abs=3)
    one_by_one()
    assert_same(together, tf.simulate(state, hub, **asked))


def test_a_torque_that_fails_ahead_fails_where_it_is_met(state):
    def torque(time, hub):
        return [0.2, 0.05, 0.1] if time < 0.0405 else [0.2, 0.05]

    with pytest.raises(tf.NotConvergedError, match="torque") as failed:
        tf.simulate(state, tf.FreeHub(20.0, (4.0, 5.0, 6.0), torque=torque), time_step=1e-3, end_time=0.06)
    assert failed.value.result.reached == pytest.approx(0.04)


def test_a_torque_may_fill_one_array_again_and_again(state):
    room, motion = np.zeros(3), {"time_step": 1e-3, "end_time": 0.04}

    def refilled(time, hub):
        room[:] = turning(time, SimpleNamespace(time=time))
        return room

    runs = [
        tf.simulate(state, tf.FreeHub(20.0, (4.0, 5.0, 6.0), torque=torque), **motion)
        for torque in (turning, lambda time, hub: tuple(turning(time, hub)), refilled)
    ]
    for other in runs[1:]:
        assert_same(runs[0], other)


WRONG = [
    (0.0, 1.0),
    1.0,
    ("0", "1", "2"),
    (0.0, np.nan, 1.0),
    (1j, 0.0, 0.0),
    None,
    [[0.0], [1.0], [2.0]],
    (10**400, 0, 0),
]


@pytest.mark.parametrize("wrong", WRONG, ids=repr)
def test_values_ahead_count_up_to_the_first_that_is_wrong(wrong):
    right = [(0.0, 1.0, 2.0), [True, 1, 2.5], np.arange(3, dtype=np.float32)]
    np.testing.assert_array_equal(checks.vectors3("torque", right), [checks.vector3("torque", one) for one in right])
    assert checks.vectors3("torque", []).shape == (0, 3)
    for place in range(4):
        found = checks.vectors3("torque", [*right[:place], wrong, *right[place:]])
        np.testing.assert_array_equal(found, np.array(right)[:place].reshape(-1, 3))
    with pytest.raises(tf.InputError, match="torque"):
        checks.vector3("torque", wrong)


def test_what_a_stage_recalls():
    states = np.random.default_rng(0).standard_normal((2, 3, 5))
    stage = tf.Bathe(0.4).stages(0.1)[1]
    passed = [SimpleNamespace(q=q, v=v, a=a) for q, v, a in states]
    np.testing.assert_allclose(recalled(stage.factors, states), stage.recalled(passed), rtol=1e-14)


@pytest.mark.parametrize(
    "name", ["wilson-theta", "hub about a line, generalized-alpha", "bathe, free hub", "energy-conserving"]
)
def test_a_run_that_is_cut_goes_on_in_stretches(state, name):
    whole = answer(state, name)
    for cut in (0.013, 0.0301, 0.067):
        first = answer(state, name, end_time=cut)
        second = answer(state, name, initial=first.final)
        np.testing.assert_array_equal(second.data["w"], whole.data["w"][-second.data.sizes["time"] :])
        assert second.error == whole.error


def test_progress_and_its_interruption_are_met(state):
    seen = []

    def progress(share, message):
        seen.append(share)
        if share > 0.4:
            raise KeyboardInterrupt

    run = answer(state, "wilson-theta", end_time=0.5, progress=progress)
    assert run.status is Status.INTERRUPTED
    assert 0.4 < seen[-1] < 0.8
    assert seen == pytest.approx(seen[0] * np.arange(1, len(seen) + 1))
    assert run.reached == pytest.approx(0.5 * seen[-1])
    assert run.data["time"].values[-1] == run.reached
