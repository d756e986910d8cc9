"""Stretches of adaptive steps give, to the bit, what steps taken one by one do."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.solvers.transient.march.adaptive_stretch import AdaptiveMarch
from tautflex.solvers.transient.march.stretch import March
from verification.dynamic_cases import small_antenna
from verification.test_march import FORCED, MODAL, PULLED, assert_same

STOP = tf.Stop(rate=2.0, duration=0.03)
STRUCK = {"initial_velocity": lambda x, y: 2.0 * np.cos(2.0 * x)}
RUNS = {
    "generalized-alpha": (STOP, {"method": tf.GeneralizedAlpha(0.8)}),
    "wilson-theta, forces in time": (STOP, {"method": tf.WilsonTheta(), "inputs": FORCED, "every": 3}),
    "bathe, fields": (STOP, {"method": tf.Bathe(), "fields": [0.01, 0.06], "damping": MODAL}),
    "newmark, tension in time": (STOP, {"method": tf.Newmark(), "inputs": PULLED, "fields": [0.05]}),
    "energy-conserving, struck": (None, {"method": tf.EnergyConserving(), **STRUCK}),
    "steps far below the grid": (STOP, {"adaptive": tf.Adaptive(1e-3, max_step=4e-4), "time_step": 2e-3}),
    "beyond the tolerance": (None, {"adaptive": tf.Adaptive(1e-6, min_step=1e-3), **STRUCK}),
}


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(small_antenna())


def answer(state, name, **more):
    maneuver, question = RUNS[name]
    asked = {
        "time_step": 1e-3, "end_time": 0.1, "damping": tf.Rayleigh(0.1, 1e-4), "probes": {"A": (0.3, 0.2)},
        "adaptive": tf.Adaptive(1e-3),
    }  # fmt: skip
    return tf.simulate(state, maneuver, **(asked | question | more))


@pytest.fixture
def taken(monkeypatch):
    """Steps of every stretch."""
    found, take = [], AdaptiveMarch.take

    def counted(march, at, number, last, segment):
        before = march._equation.statistics.steps
        reached = take(march, at, number, last, segment)
        found.append(march._equation.statistics.steps - before)
        return reached

    monkeypatch.setattr(AdaptiveMarch, "take", counted)
    return found


@pytest.mark.parametrize("name", RUNS)
def test_stretches_have_the_numbers_of_single_steps(state, monkeypatch, taken, name):
    together = answer(state, name)
    assert sum(taken) > 0.6 * together.stats.steps
    monkeypatch.setattr(March, "serves", staticmethod(lambda *parts: False))
    alone = answer(state, name)
    assert_same(together, alone)
    for name in ("rejected", "beyond_tolerance"):
        assert getattr(together.stats, name) == getattr(alone.stats, name)


def test_steps_that_fail_within_a_stretch_are_the_drivers(state, monkeypatch, taken):
    """A blow in the middle of a stretch that neither tolerance nor iteration bears at this size."""

    def blow(time):
        return [0.0, 0.0, 0.5 if 0.0503 < time < 0.0507 else 0.0]

    inputs, control = [tf.NodalForce([7], blow)], tf.Adaptive(1e-2)
    together = answer(state, "generalized-alpha", inputs=inputs, adaptive=control)
    assert together.stats.rejected + together.stats.halvings > 0
    assert sum(taken) > 0.5 * together.stats.steps
    monkeypatch.setattr(March, "serves", staticmethod(lambda *parts: False))
    assert_same(together, answer(state, "generalized-alpha", inputs=inputs, adaptive=control))


@pytest.mark.parametrize("name", ["generalized-alpha", "newmark, tension in time", "steps far below the grid"])
def test_a_run_that_is_cut_goes_on_in_stretches(state, name):
    whole = answer(state, name, fields=())
    for cut in (0.014, 0.068):
        first = answer(state, name, fields=(), end_time=cut)
        second = answer(state, name, fields=(), initial=first.final)
        np.testing.assert_array_equal(second.data["w"], whole.data["w"][-second.data.sizes["time"] :])
        assert second.error == whole.error
