"""What maneuvers refuse, and how they say so."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError

TURN = [[1.0, 0.0, 0.0, 0.0], [0.9, 0.1, 0.0, 0.0], [0.8, 0.3, 0.0, 0.0]]

# call, and the words of the message: argument, expectation, value or remedy
BAD = {
    "slew angle": (lambda: tf.Slew(np.nan, 1.0), ["angle", "finite"]),
    "slew duration": (lambda: tf.Slew(1.0, 0.0), ["duration", "> 0"]),
    "slew profile": (lambda: tf.Slew(1.0, 1.0, "trapezoid"), ["profile", "'versine'", "'trapezoid'"]),
    "slew axis": (lambda: tf.Slew(1.0, 1.0, axis=(0.0, 0.0, 0.0)), ["axis", "direction", "[1, 0, 0]"]),
    "slew origin": (lambda: tf.Slew(1.0, 1.0, origin=(0.0, 0.0)), ["origin", "(3)", "(2,)"]),
    "shaping without a mode": (lambda: tf.Slew(1.0, 1.0, "input-shaped"), ["frequency: missing", "solve_modes"]),
    "mode without shaping": (lambda: tf.Slew(1.0, 1.0, frequency=1.0), ["frequency", "'versine'", "'input-shaped'"]),
    "shaper too long": (
        lambda: tf.Slew(1.0, 1.0, "input-shaped", frequency=0.9),
        ["duration", "1.11111 s", "ZVD", "0.9 Hz", "got 1 s", "'ZV'"],
    ),
    "shaper": (lambda: tf.Slew(1.0, 9.0, "input-shaped", frequency=1.0, shaper="EI"), ["shaper", "'ZVD'", "'EI'"]),
    "shaped base": (lambda: tf.Slew(1.0, 9.0, "input-shaped", frequency=1.0, base="step"), ["base", "'bang-bang'"]),
    "shaped frequency": (lambda: tf.Slew(1.0, 9.0, "input-shaped", frequency=-1.0), ["frequency", "> 0"]),
    "shaped damping": (
        lambda: tf.Slew(1.0, 9.0, "input-shaped", frequency=1.0, damping_ratio=1.0),
        ["damping_ratio", "[0, 1)", "1.0"],
    ),
    "spin-up rate": (lambda: tf.SpinUp(np.inf, 1.0), ["rate", "finite"]),
    "spin-up profile": (lambda: tf.SpinUp(1.0, 1.0, "bang-bang"), ["profile", "'linear'", "'bang-bang'"]),
    "spin-up initial rate": (lambda: tf.SpinUp(1.0, 1.0, initial_rate=np.nan), ["initial_rate", "finite"]),
    "acceleration": (lambda: tf.BaseAcceleration(np.nan), ["acceleration", "finite"]),
    "pulse without length": (lambda: tf.BaseAcceleration(1.0, None, "half-sine"), ["duration: missing", "half-sine"]),
    "cut-off with length": (lambda: tf.BaseAcceleration(1.0, 2.0, "cut-off"), ["duration", "no value", "2.0"]),
    "base profile": (lambda: tf.BaseAcceleration(1.0, 2.0, "ramp"), ["profile", "'cut-off'", "'ramp'"]),
    "empty table": (lambda: tf.Tabulated([0.0, 1.0]), ["rates: missing", "quaternions or accelerations"]),
    "one row": (lambda: tf.Tabulated([0.0], [1.0]), ["times", "at least 2", "got 1"]),
    "late table": (lambda: tf.Tabulated([1.0, 2.0], [1.0, 0.0]), ["times", "begin at 0", "got 1 s"]),
    "falling times": (lambda: tf.Tabulated([0.0, 2.0, 1.0], [1.0, 0.0, 0.0]), ["times", "1 s after 2 s", "sort"]),
    "times thrice": (lambda: tf.Tabulated([0, 1, 1, 1, 2], np.zeros(5)), ["times", "at most twice", "got 1 s"]),
    "first time twice": (lambda: tf.Tabulated([0, 0, 1], np.zeros(3)), ["times", "first and last one once", "0 s"]),
    "last time twice": (lambda: tf.Tabulated([0, 1, 1], np.zeros(3)), ["times", "first and last one once", "1 s"]),
    "rates too few": (lambda: tf.Tabulated([0.0, 1.0, 2.0], [1.0, 0.0]), ["rates", "3 rows", "got 2"]),
    "rates of two columns": (lambda: tf.Tabulated([0.0, 1.0], [[1.0, 0.0]] * 2), ["rates", "(any, 3)", "(2, 2)"]),
    "rates not finite": (lambda: tf.Tabulated([0.0, 1.0], [1.0, np.nan]), ["rates", "finite", "nan at index (1,)"]),
    "rates that jump": (lambda: tf.Tabulated([0, 1, 1, 2], [0, 1, 2, 0]), ["rates", "at 1 s", "[2.0, 0.0, 0.0]"]),
    "rates and attitude": (
        lambda: tf.Tabulated([0, 1, 2], [0, 1, 2], quaternions=TURN),
        ["quaternions", "beside rates", "remove one"],
    ),
    "attitude of zeros": (
        lambda: tf.Tabulated([0, 1], quaternions=[[1, 0, 0, 0], [0, 0, 0, 0]]),
        ["quaternions", "zeros in row 1", "(1, 0, 0, 0)"],
    ),
    "half a turn": (
        lambda: tf.Tabulated([0, 1], quaternions=[[1, 0, 0, 0], [0, 1, 0, 0]]),
        ["quaternions", "half a turn", "row 0", "more rows"],
    ),
    "attitude twice": (
        lambda: tf.Tabulated([0, 1, 1, 2], quaternions=[*TURN, TURN[2]]),
        ["times", "once with quaternions", "1 s twice"],
    ),
    "rates at rest": (lambda: tf.Tabulated([0, 1], [0, 1], ends="rest"), ["ends", "'free'", "'rest'"]),
    "ends": (lambda: tf.Tabulated([0, 1], [0, 1], ends="clamped"), ["ends", "'rest'", "'clamped'"]),
    "no steps": (lambda: tf.Sequence(()), ["steps", "at least one", "Slew"]),
    "steps of no kind": (lambda: tf.Sequence((1.0,)), ["steps", "Slew", "1.0"]),
    "holds": (lambda: tf.Sequence((tf.AtRest(), tf.AtRest()), (1.0, 2.0)), ["holds", "1 durations", "got 2"]),
    "hold": (lambda: tf.Sequence((tf.AtRest(), tf.AtRest()), (-1.0,)), ["holds", ">= 0"]),
    "jump": (
        lambda: tf.Sequence((tf.SpinUp(0.5, 1.0), tf.Stop(0.6, 1.0))),
        ["steps", "step 2", "[0.5, 0.0, 0.0] rad/s", "step 1", "[0.6, 0.0, 0.0]", "SpinUp"],
    ),
    "attitude times": (lambda: tf.attitude(tf.Slew(0.1, 1.0), [1.0, 0.5]), ["times", "rising"]),
    "attitude before": (lambda: tf.attitude(tf.Slew(0.1, 1.0), [-1.0]), ["times", ">= 0"]),
    "attitude start": (lambda: tf.attitude(tf.Slew(0.1, 1.0), [1.0], (0, 0, 0, 0)), ["initial", "zeros"]),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arguments_are_named(name):
    call, words = BAD[name]
    with pytest.raises(InputError) as caught:
        call()
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


def test_attitude_of_a_table_that_cannot_be_followed():
    """Rates that reverse within round-off of each other: a clear failure instead of an endless refinement."""
    rough = np.random.default_rng(0).standard_normal(3000) * 1e6
    with pytest.raises(tf.NotConvergedError, match="too rough"):
        tf.attitude(tf.Tabulated(np.linspace(0.0, 1.0, 3000), np.column_stack([rough, rough[::-1], rough])), [1.0])


@pytest.mark.parametrize(
    "maneuver",
    [
        tf.Slew(0.3, 4.0, "input-shaped", frequency=1.0),
        tf.Tabulated([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0]),
        tf.Sequence((tf.SpinUp(1.0, 2.0), tf.Stop(1.0, 0.5)), (3.0,)),
        tf.BaseAcceleration(1.0, 2.0),
    ],
)
def test_maneuvers_travel_between_processes_and_say_what_they_are(maneuver):
    maneuver.segments()
    twin = pickle.loads(pickle.dumps(maneuver))
    for one, other in zip(twin.segments(), maneuver.segments(), strict=True):
        assert (one.start, one.end) == (other.start, other.end)
        np.testing.assert_array_equal(one.motion(1.5).angular_velocity, other.motion(1.5).angular_velocity)
    assert repr(twin) == repr(maneuver)
    assert repr(maneuver).startswith(type(maneuver).__name__)
    assert len(repr(maneuver)) < 500


def test_tables_are_copied_and_frozen():
    times, rates = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.5])
    table = tf.Tabulated(times, rates)
    rates[1] = 9.0
    assert table.segments()[0].motion(1.0).angular_velocity[0] == pytest.approx(1.0)
    with pytest.raises(ValueError, match="read-only"):
        table.rates[0] = 1.0


def test_holds_may_be_left_out():
    first = tf.Sequence([tf.Slew(0.1, 1.0), tf.Slew(-0.1, 1.0)])
    assert [part.start for part in first.segments()] == [0.0, 1.0, 2.0]
    assert tf.attitude(first, [])[..., 0].shape == (0,)
