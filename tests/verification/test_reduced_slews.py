"""Reduced antennas of 17 coordinates on their hubs against the full ones: slews, switched tension, tumbling."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case, template
from verification.test_reduced_hub import turned

pytestmark = pytest.mark.slow

DAMPING = tf.Rayleigh(1e-3, 1e-3)
PROBES = {"A": (0.7036, 0.4267), "B": (0.3, 0.1)}
PRETENSION = {"x": 0.058941, "y": 0.11}


@cache
def antenna():
    """Antenna M2 of 20 x 10 cells."""
    tensions = {f"pretension_{axis}": value for axis, value in PRETENSION.items()}
    cables = {"per_long_edge": 21, "per_short_edge": 11, "area": 1.57e-6, **tensions}
    case = parse_case(template("m2")).replaced(mesh={"divisions": [20, 10]}, cables=cables)
    return tf.solve_prestress(tf.build_model(case))


def differences(full, reduced):
    """Of the records at all probes, rms over rms, the worst; of the attitude [rad]."""
    off = np.sqrt(((full.w - reduced.w) ** 2).mean("time") / (full.w**2).mean("time"))
    return float(off.max()), float(turned(full.attitude.values, reduced.attitude.values).max())


def bang_bang(torque, half):
    """A torque about x that turns round after ``half`` seconds and ends after as many more."""
    return tf.FreeHub(
        20.0,
        (5.0, 5.0, 8.0),
        axes="x",
        breaks=(half, 2.0 * half),
        torque=lambda time, _: (torque * (time < half) - torque * (half <= time < 2.0 * half), 0.0, 0.0),
    )


@pytest.mark.parametrize("kind", ["bang-bang", "tumbling"])
def test_slews_and_tumbling_follow_the_full_model(kind, verification_row):
    """A bang-bang torque about x, and tumbling about all three axes, by a radian in 3 s."""
    tumble = tf.FreeHub(20.0, (5.0, 4.0, 8.0), (0.05, 0.02, 0.1), angular_velocity=(0.2, 0.3, 0.05))
    hub, most, directions = (bang_bang(1.0, 1.0), 0.05, ("rx",))
    if kind == "tumbling":
        hub, most, directions = tumble, 0.01, ("z", "rx", "ry")
    reduced = tf.reduce(antenna(), tf.ModalBasis(directions, count=16, candidates=80))
    given = {"time_step": 4e-3, "end_time": 3.0, "damping": DAMPING, "probes": PROBES}
    full = tf.simulate(antenna(), hub, method=tf.GeneralizedAlpha(0.8), **given).data
    turn = float(turned(full.attitude.values[:1], full.attitude.values[-1:])[0])
    for method in (tf.GeneralizedAlpha(0.8), tf.CentralDifference()):
        gap, error = differences(full, tf.simulate(reduced, hub, method=method, **given).data)
        assert error < 1e-5 * turn
        assert gap < most
        verification_row(f"reduced model, {kind}, {method.name}: attitude, relative", 0, error / turn, "full model")
        verification_row(f"reduced model, {kind}, {method.name}: rms of the record", 0, gap, "full model")


def switched_tensions(end):
    """Drives of all tensions, which jump between half and one and a half times theirs four times a second."""
    times = 0.25 * np.arange(1, round(4 * end))

    def switched(size):
        values = (0.0, *[0.5, -0.5] * round(2 * end))
        return lambda time: size * values[int(np.searchsorted(times, time, side="right"))]

    return [
        tf.TensionGroup(axis, switched(value), share="pretension", breaks=tuple(times))
        for axis, value in PRETENSION.items()
    ]


def test_a_slew_under_switched_tension_follows_the_full_model(verification_row):
    """By 0.09 rad, all tensions jumping between half and one and a half times theirs four times a second."""
    pulls = switched_tensions(2.0)
    state, hub = tf.equip(antenna(), pulls), bang_bang(0.67, 1.0)
    reduced = tf.reduce(state, tf.ModalBasis(directions=("rx",), count=16))
    assert reduced.size == 17
    given = {"time_step": 2.5e-3, "end_time": 2.0, "damping": DAMPING, "probes": PROBES, "method": tf.Bathe()}
    full, few = (tf.simulate(plant, hub, inputs=pulls, **given).data for plant in (state, reduced))
    plain = tf.simulate(reduced, hub, **given).data
    gap, error = differences(full, few)
    turn = float(turned(full.attitude.values[:1], full.attitude.values[-1:])[0])
    assert differences(full, plain)[0] > 0.1
    assert gap < 0.05
    assert error < 1e-5 * turn
    verification_row("reduced model, slew under switched tension: attitude, relative", 0, error / turn, "full model")
    verification_row("reduced model, slew under switched tension: rms of the record", 0, gap, "full model")


def test_proper_orthogonal_modes_of_a_rich_reduced_run_serve_where_the_film_is_pressed(verification_row):
    """By 0.3 rad: natural modes miss the waves, 17 modes of the run of a model of 60 coordinates have them.

    The full run trains nothing. The natural modes' guess of their sizes is poor there, so they keep weak fields.
    """
    pulls = switched_tensions(4.0)
    state, hub = tf.equip(antenna(), pulls), bang_bang(2.23, 1.0)
    given = {"time_step": 2.5e-3, "end_time": 4.0, "damping": DAMPING, "probes": PROBES, "method": tf.Bathe()}
    given |= {"inputs": pulls, "fields": "all", "every": 4}
    full = tf.simulate(state, hub, **given).data
    rich = tf.reduce(state, tf.ModalBasis(("rx",), count=60, candidates=260), weak_field=1e-8)
    training = tf.simulate(rich, hub, **given).data
    few = tf.reduce(state, tf.PodBasis(training, count=17))
    plain = tf.reduce(state, tf.ModalBasis(("rx",), count=16, candidates=130))
    assert few.size == plain.size == 17
    gap, error = differences(full, tf.simulate(few, hub, **given).data)
    turn = float(turned(full.attitude.values[:1], full.attitude.values[-1:])[0])
    assert differences(full, tf.simulate(plain, hub, **given).data)[0] > 0.06
    assert differences(full, training)[0] < 0.02
    assert gap < 0.05
    assert error < 1e-5 * turn
    verification_row("reduced model, pressed film, switched tension: attitude, relative", 0, error / turn, "full model")
    verification_row("reduced model, pressed film, switched tension: rms of the record", 0, gap, "full model")
