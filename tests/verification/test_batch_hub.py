"""Batches with inputs in time and on a free hub, against single runs."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tautflex as tf
from verification.batch_cases import changed_rom, changed_state
from verification.dynamic_cases import small_antenna
from verification.test_reduced_inputs import cables_along

pytestmark = [pytest.mark.jax, pytest.mark.slow]

TIMES, ROWS = [0.0, 0.01, 0.0171, 0.0171, 0.03], np.array([0.0, 1.0, 0.5, -0.3, 0.2])
HUB = tf.FreeHub(
    mass=20.0, inertia=(4.0, 5.0, 6.0), center=(0.1, -0.05, 0.2), attitude=(0.6, 0.0, 0.8, 0.0), axes="x",
    torque=(0.3, 0.0, 0.0), angular_velocity=(0.05, 0.0, 0.0),
)  # fmt: skip
OPTIONS = {"time_step": 1e-3, "end_time": 0.04, "probes": {"A": (0.6, 0.3)}}
VARIABLES = ("u", "v", "w", "w_velocity", "kinetic_energy", "strain_energy")


def throw(x, y):
    return 0.02 * np.cos(np.pi * x / 2) * np.cos(np.pi * y)


@cache
def state():
    return tf.solve_prestress(small_antenna())


@cache
def rom():
    return tf.reduce(state(), tf.ModalBasis(directions=("rx",), count=3), weak_field=0.0)


def wave(time):
    return 0.2 * jnp.sin(300.0 * time)


def inputs(factor=1.0, rows=ROWS, tension=1.0):
    """A force, a tension and a temperature: a table, a function, a number."""
    node = int(np.argmin(np.linalg.norm(state().model.nodes - [0.5, 0.2, 0.0], axis=1)))
    return [
        tf.NodalForce([node], tf.TimeTable(TIMES, factor * rows), direction=(0.0, 0.3, 1.0)),
        tf.CableTension(lambda time: tension * wave(time), cables_along(state(), 0)),
        tf.MembraneTemperature(1.0, 1e-5),
    ]


def difference(data, one, names=VARIABLES):
    return max(float(np.abs(data[name] - one[name]).max() / np.abs(one[name]).max()) for name in names)


def test_hub_and_inputs_of_a_reduced_model_are_the_single_runs(verification_row):
    """The film's density changes what the hub feels."""
    table = {
        "hub.torque": [0.3, -0.2],
        "hub.angular_velocity": [0.05, 0.1],
        "hub.inertia": [4.9, 6.0],
        "inputs.1": [1.0, 2.0],
        "inputs.1.values": np.stack([ROWS, ROWS[::-1]]),
        "inputs.2": [1.0, -0.5],
        "density.membrane": [1.0, 1.2],
    }
    asked = {**OPTIONS, "method": tf.CentralDifference(), "initial_velocity": throw, "damping": tf.Rayleigh(0.1, 1e-3)}
    data = tf.Batch(rom()).simulate(table, HUB, inputs=inputs(), **asked)
    offset = np.asarray(HUB.center)[1:] @ np.asarray(HUB.center)[1:] * HUB.mass
    worst = 0.0
    for run in range(2):
        row = {name: values[run] for name, values in table.items()}
        hub = replace(
            HUB, torque=(row["hub.torque"], 0.0, 0.0), angular_velocity=(row["hub.angular_velocity"], 0.0, 0.0),
            inertia=(row["hub.inertia"] - offset, 5.0, 6.0),
        )  # fmt: skip
        given = inputs(row["inputs.1"], row["inputs.1.values"], row["inputs.2"])
        heavy = {"density.membrane": row["density.membrane"]}
        changed = replace(changed_rom(rom(), heavy), state=changed_state(state(), heavy))
        one = tf.simulate(changed, hub, inputs=given, **asked).data
        worst = max(worst, difference(data.isel(run=run), one, (*VARIABLES, "attitude", "angular_velocity")))
    assert worst < 1e-9
    verification_row("batch on a hub about x with three inputs, 2 runs, central differences", 0, worst, "single runs")
    assert np.abs(data.angle[:, -1]).min() > 1e-3


def test_inputs_under_a_maneuver_are_the_single_runs(verification_row):
    """The maneuver ends between instants of the grid."""
    asked = {**OPTIONS, "method": tf.Newmark(), "tolerance": 1e-11, "damping": tf.Rayleigh(0.1, 1e-3)}
    table = {"maneuver.duration": [0.0205, 0.025], "inputs.1": [1.0, 3.0]}
    data = tf.Batch(rom()).simulate(table, tf.Stop(0.6, 0.02), inputs=inputs(), **asked)
    worst = 0.0
    for run in range(2):
        stop = tf.Stop(0.6, table["maneuver.duration"][run])
        one = tf.simulate(rom(), stop, inputs=inputs(table["inputs.1"][run]), **asked).data
        worst = max(worst, difference(data.isel(run=run), one))
    assert worst < 1e-9
    verification_row("batch of a reduced model with three inputs, 2 runs, Newmark", 0, worst, "single runs")


def test_inputs_on_the_full_model_are_the_single_run(verification_row):
    """Stresses begin at zero: of those that jump a single run by generalized-alpha takes up what its steps resolve."""
    asked = {**OPTIONS, "end_time": 0.02, "method": tf.GeneralizedAlpha(0.8), "tolerance": 1e-11}
    warming = tf.MembraneTemperature(tf.TimeTable([0.0, 0.02], [0.0, 1.0]), 1e-5)
    one, many = ([*inputs(factor)[:2], warming] for factor in (2.0, 1.0))
    data = tf.Batch(state()).simulate({"inputs.1": 2.0}, tf.Stop(0.6, 0.0105), inputs=many, **asked)
    worst = difference(data.isel(run=0), tf.simulate(state(), tf.Stop(0.6, 0.0105), inputs=one, **asked).data)
    assert worst < 1e-8
    verification_row("batch of the full model with three inputs, generalized-alpha", 0, worst, "single run")


def test_derivatives_of_a_run_on_a_hub(verification_row):
    """The hub's last angle after its torque and the table of a force, against central differences of the same."""
    asked = {"time_step": 1e-3, "end_time": 0.012, "method": tf.CentralDifference(), "initial_velocity": throw}
    respond = tf.Batch(rom()).response(HUB, inputs=inputs(), store=("displacement",), probes={"A": (0.6, 0.3)}, **asked)

    def reached(numbers):
        found = respond(numbers)
        return found.hub[-1, 0] + found.displacement[-1, 0, 2]

    at = {"hub.torque": 0.3, "inputs.1": 1.0}
    slope = jax.jit(jax.grad(reached))(at)
    value = jax.jit(reached)
    for name, step in (("hub.torque", 1e-2), ("inputs.1", 1e-3)):
        ends = [float(value({**at, name: at[name] + sign * step})) for sign in (1.0, -1.0)]
        expected = (ends[0] - ends[1]) / (2.0 * step)
        assert float(slope[name]) == pytest.approx(expected, rel=1e-6)
        verification_row(f"derivative of a run on a hub after {name}", expected, float(slope[name]), "differences")
