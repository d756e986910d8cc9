"""Every effect that a batch takes, one per run, against single runs with that effect alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import tautflex as tf
from verification.dynamic_cases import small_antenna

pytestmark = [pytest.mark.jax, pytest.mark.slow]
HUB = tf.FreeHub(mass=20.0, inertia=(4.0, 5.0, 6.0), center=(0.1, -0.05, 0.2), axes="x", torque=(0.3, 0.0, 0.0))
OPTIONS = {"time_step": 1e-3, "end_time": 0.02, "probes": {"A": (0.6, 0.3)}, "damping": tf.Rayleigh(0.1, 1e-3)}


def table(size):
    return tf.TimeTable([0.0, 0.005, 0.0131, 0.0131, 0.02], [0.0, size, 0.5 * size, 0.0, size])


EFFECTS = {
    "force": tf.NodalForce([12], table(0.05), direction=(0.0, 0.3, 1.0)),
    "force on an edge": tf.EdgeForce([0, 1], table(0.5), direction=(0.0, 0.0, 1.0)),
    "stay cable": tf.StayCable((0.3, 0.1), (0.2, 0.1, 0.3), table(0.05)),
    "patches": tf.PiezoPair([0, 1], table(2.0)),
    "tension": tf.CableTension(table(0.2), [0]),
    "commanded tension": tf.TensionGroup("y", table(0.2)),
    "warm film": tf.MembraneTemperature(table(1.0), 1e-5),
    "warm cables": tf.CableTemperature(table(2.0), 1e-5),
    "warm frame": tf.FrameTemperature(table(5.0), 2e-5),
    "sunlight": tf.SolarPressure((0.0, 0.3, -1.0), table(1.0), pressure=5.0),
    "piezoelectric film": tf.PiezoFilm(2e-11, table(1e5)),
    "pressure": tf.Pressure(table(0.05)),
}


def throw(x, y):
    return 0.02 * np.cos(np.pi * x / 2) * np.cos(np.pi * y)


@cache
def state():
    return tf.equip(tf.solve_prestress(small_antenna()), list(EFFECTS.values()))


def worst_of(plant, maneuver, names, asked, verification_row, label):
    """Run k has effect k alone; each must matter."""
    effects = [EFFECTS[name] for name in names]
    alone = {f"inputs.{k + 1}": row for k, row in enumerate(np.eye(len(effects)))}
    data = tf.Batch(plant).simulate(alone, maneuver, inputs=effects, store=("displacement",), **asked)
    still = tf.simulate(plant, maneuver, **asked).data[["u", "v", "w"]].to_array()
    for run, effect in enumerate(effects):
        one = tf.simulate(plant, maneuver, inputs=[effect], **asked).data[["u", "v", "w"]].to_array()
        found = data.isel(run=run)[["u", "v", "w"]].to_array()
        largest = float(np.abs(one).max())
        assert float(np.abs(one - still).max()) > 1e-5 * largest, names[run]
        worst = float(np.abs(found.values - one.values).max()) / largest
        verification_row(f"batch {label}, {names[run]}", 0, worst, "single run")
        assert worst < 1e-9, names[run]


def test_every_effect_on_a_hub(verification_row):
    rom = tf.reduce(state(), tf.ModalBasis(directions=("rx", "z"), count=6), weak_field=0.0)
    asked = {**OPTIONS, "method": tf.CentralDifference(), "initial_velocity": throw}
    worst_of(rom, HUB, list(EFFECTS), asked, verification_row, "on a hub about x")


def test_every_effect_but_pressure_on_the_full_model(verification_row):
    """The average constant acceleration takes whole jumps, as batches do."""
    asked = {**OPTIONS, "end_time": 0.014, "method": tf.Newmark(), "tolerance": 1e-12, "initial_velocity": throw}
    names = [name for name in EFFECTS if name != "pressure"]
    worst_of(state(), tf.Stop(0.6, 0.0105), names, asked, verification_row, "of the full model")
    with pytest.raises(tf.UnsupportedError, match="got Pressure; reduce"):
        tf.Batch(state()).simulate({}, inputs=[EFFECTS["pressure"]], **asked)
    moved = tf.SupportMotion([15], (0.0, 0.0, 1.0), tf.TimeTable([0.0, 0.01, 0.02], [0.0, 1e-4, 0.0]))
    with pytest.raises(tf.UnsupportedError) as refused:
        tf.Batch(state()).simulate({}, inputs=[moved], **asked)
    assert "\n" not in str(refused.value)
