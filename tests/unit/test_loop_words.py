"""What a closed loop says: names that a law misses, and of what it cannot settle."""

from __future__ import annotations

import pytest

import tautflex as tf
from tautflex.case import parse_case
from tautflex.case.build import build_state
from tautflex.case.loop import loop_summary
from tautflex.control.runs.timing import doubts_about_steps
from unit.test_loop_case import HELD
from verification.builders import FILM_CASE

HUB = """
[hub]
mass = 20.0
inertia = [4.0, 5.0, 6.0]
attitude = [0.9950041652780258, 0.0, 0.0, 0.09983341664682815]
"""
# A force that damps the film.
PUSH = "\n[actuators.push]" + HELD.partition("[actuators.push]")[2]
TURN = """
[actuators.wheels]
kind = "hub-torque"
axis = "z"
[sensors.star]
kind = "attitude"
[sensors.gyro]
kind = "rate"
[controller]
kind = "pd"
stiffness = 1.0
damping = 1.0
"""
NAMED = TURN + 'attitude = "star[2]"\nrate = "gyro[2]"\ntorque = "wheels"\n'


def loop(text):
    return parse_case(FILM_CASE + text).replaced(solver={"end_time": 0.05})


def settled(text):
    case = loop(text)
    return loop_summary(case, tf.control_case(case))["settling_time"]


@pytest.mark.slow
def test_attitude_is_judged_where_a_law_turns_a_hub():
    """Nothing settles an attitude that no law commands a torque on: it is left out, not told as failed."""
    assert set(settled(PUSH)) == {"surface"}
    assert set(settled(HUB + PUSH)) == {"surface"}
    assert settled(HUB + NAMED)["attitude"] is None


def test_all_names_that_a_law_misses_are_told_at_once():
    """Its default names where sensors and actuators have others."""
    with pytest.raises(tf.InputError) as caught:
        tf.control_case(loop(HUB + TURN))
    told = [text.partition(":")[0] for text in caught.value.problems]
    assert told == ["controller.attitude", "controller.rate", "controller.torque"]
    assert all("try" in text for text in caught.value.problems)


def test_all_names_that_stand_twice_are_told_at_once():
    state, torque = build_state(loop(PUSH)), tf.HubTorque()
    hub = tf.FreeHub(20.0, (4.0, 5.0, 6.0))
    with pytest.raises(tf.InputError) as caught:
        tf.Plant(state, hub, {"a": torque, "b": torque}, {"a": tf.Attitude(), "b": tf.Rate()})
    assert [text.partition(":")[0] for text in caught.value.problems] == ["sensors.a", "sensors.b"]


def test_many_steps_of_an_interval_are_told_once():
    """34 short steps where two long ones do: how many, why, and what to write in Python and in a case."""
    (told,) = doubts_about_steps(tf.CentralDifference(), 0.01, 34)
    for words in ("34 steps of 0.000294 s", "every interval of 0.01 s", "method=GeneralizedAlpha()", "time_step=0.005"):
        assert words in told
    assert "solver.method = 'generalized-alpha' and solver.time_step = 0.005" in told
    assert doubts_about_steps(tf.CentralDifference(), 0.01, 10) == []
    assert doubts_about_steps(tf.GeneralizedAlpha(), 0.01, 34) == []


@pytest.mark.slow
@pytest.mark.parametrize(("method", "count"), [(None, 1), (tf.GeneralizedAlpha(), 0)])
def test_a_plant_of_many_short_steps_tells_of_them(method, count):
    """A loop has it among its warnings."""
    pull = tf.NodalForce([7], direction=(1.0, 0.0, 0.0))
    rom = tf.reduce(build_state(loop(PUSH)), tf.ModalBasis(count=2), inputs=[pull])
    plant = tf.Plant(rom, actuators={"pull": pull}, interval=0.01, time_step=1e-4, method=method)
    run = tf.close_loop(plant, lambda time, measurement: [0.0], end_time=0.01)
    assert len([text for text in run.data.attrs["warnings"] if "steps of" in text]) == count
