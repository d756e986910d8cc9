"""Maneuvers that a user writes: segments for single runs, or a formula that serves batches too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import tautflex as tf
from tautflex.motion.profiles import library_of
from verification.dynamic_cases import small_antenna

OPTIONS = {"time_step": 2e-3, "end_time": 0.06, "probes": {"A": (0.6, 0.3)}, "tolerance": 1e-11, "method": tf.Newmark()}


@dataclass(frozen=True)
class Nodding(tf.Maneuver):
    """The frame nods about x for ever: angle = amplitude (1 - cos(w t))."""

    amplitude: float
    w: float

    def _motion(self, time: float) -> tf.RigidMotion:
        x = np.array([1.0, 0.0, 0.0])
        rate = self.amplitude * self.w * np.sin(self.w * time)
        return tf.RigidMotion(rate * x, self.amplitude * self.w**2 * np.cos(self.w * time) * x, np.zeros(3))

    def start(self) -> tf.RigidMotion:
        return tf.AtRest().start()

    def segments(self) -> tuple[tf.Segment, ...]:
        return (tf.Segment(0.0, np.inf, self._motion),)


@dataclass(frozen=True)
class EasedStop(tf.FixedAxis):
    """Stop along half a cosine: w = rate (1 + cos(pi t/duration))/2."""

    rate: float
    duration: float
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def formula(self, numbers):
        turn = np.pi / numbers["duration"]

        def values(time):
            xp = library_of(turn * time)
            return (
                0.5 - 0.5 * xp.cos(turn * time),
                0.5 * turn * xp.sin(turn * time),
                0.5 * turn**2 * xp.cos(turn * time),
            )

        step = tf.UnitStep((tf.Stretch(0.0, numbers["duration"], values),))
        return tf.RateFormula(numbers["rate"], -numbers["rate"], step)


@pytest.fixture(scope="module")
def rom():
    state = tf.solve_prestress(small_antenna())
    return tf.reduce(state, tf.ModalBasis(directions=("rx",)), weak_field=0.0)


def _difference(one, other) -> float:
    return float(np.abs(one["w"] - other["w"]).max() / np.abs(other["w"]).max())


def test_a_maneuver_of_segments_runs_in_full_and_reduced_models(rom):
    nodding = Nodding(1e-3, 40.0)
    full, reduced = (tf.simulate(plant, nodding, **OPTIONS).data for plant in (rom.state, rom))
    assert _difference(reduced, full) < 1e-3
    assert nodding.end == 0.0
    with pytest.raises(
        tf.UnsupportedError, match=r"maneuver: expected Stop.* another FixedAxis.*, got Nodding"
    ) as raised:
        tf.Batch(rom).simulate({"damping.beta": [1e-3]}, nodding, **OPTIONS)
    assert "\n" not in str(raised.value)


@pytest.mark.jax
def test_a_formula_runs_in_batches_too(rom):
    stop, rates = EasedStop(0.5, 0.0312), np.array([0.5, 0.3])
    first, last = stop.segments()
    points, weights = np.polynomial.legendre.leggauss(24)
    turned = 0.0156 * sum(
        weight * first.motion(0.0156 * (1.0 + point)).angular_velocity[0]
        for point, weight in zip(points, weights, strict=True)
    )
    assert turned == pytest.approx(0.5 * 0.5 * 0.0312, rel=1e-13)
    assert (first.end, last.motion(1.0).angular_velocity[0]) == (stop.end, 0.0)
    data = tf.Batch(rom).simulate({"maneuver.rate": rates}, stop, **OPTIONS)
    for run, rate in enumerate(rates):
        single = tf.simulate(rom, EasedStop(rate, 0.0312), **OPTIONS).data
        assert _difference(data.isel(run=run), single) < 1e-9
