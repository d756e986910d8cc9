"""One question for every plant: its keywords are written once, its checks are the same for all."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass, fields
from inspect import signature

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError, UnsupportedError
from verification.dynamic_cases import small_antenna, soft_film

GRID = {"time_step": 1e-3, "end_time": 0.01}


@pytest.fixture(scope="module")
def film():
    return soft_film()


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def plants(antenna):
    """Everything that answers: the full model, a reduced one, and batches of both."""
    rom = tf.reduce(antenna, tf.ModalBasis(directions=("rx",), count=2))

    def single(plant):
        return lambda maneuver=None, **question: tf.simulate(plant, maneuver, **question)

    return [single(antenna), single(rom), tf.Batch(antenna).response, tf.Batch(rom).response]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"time_step": 0.0}, "time_step: expected a number > 0"),
        ({"end_time": 1e-4}, "end_time: expected at least one time_step"),
        ({"tolerance": -1.0}, "tolerance: expected a number > 0"),
        ({"damping": 0.1}, "damping: expected an object such as Rayleigh"),
        ({"coupling": "all"}, "coupling: expected an object such as Coupling"),
        ({"method": "newmark"}, "method: expected an object such as WilsonTheta"),
        ({"maneuver": 0.6}, "maneuver: expected an object such as Stop"),
        ({"probes": [(0.0, 0.0)]}, "probes: expected a mapping"),
        ({"probe_reading": "average"}, "probe_reading: expected one of"),
        ({"initial_velocity": [1.0]}, "initial_velocity: expected shape"),
        ({"timestep": 1e-3}, "timestep: expected one of the keywords time_step, end_time, method"),
        ({"end_time": None, "time_step": None}, "time_step: expected a finite number, got None"),
    ],
)
def test_every_plant_refuses_in_the_same_words(plants, change, words):
    for ask in plants:
        with pytest.raises(InputError, match=words):
            ask(**{**GRID, **change})


def test_what_has_to_be_given_is_asked_for(antenna):
    with pytest.raises(InputError, match=r"end_time: expected a number of seconds, got nothing; give end_time="):
        tf.simulate(antenna, time_step=1e-3)
    with pytest.raises(InputError, match=r"state: expected a prestressed state.*got Model; solve_prestress\(model\)"):
        tf.simulate(antenna.model, **GRID)


@pytest.mark.parametrize("name", ["adaptive", "every", "fields", "max_halvings"])
def test_batches_say_which_keywords_they_have_no_answer_to(plants, name):
    with pytest.raises(UnsupportedError, match=f"{name}: expected no such keyword in a batch"):
        plants[2](**GRID, **{name: None})


def test_keywords_are_the_fields_of_the_problem():
    shown = signature(tf.simulate).parameters
    asked = {item.name for item in fields(tf.TransientProblem)} - {"plant"}
    assert set(shown) == asked | {"state", "progress", "throw"}
    assert shown["max_halvings"].default == 8
    assert all(
        f"{name}\n" in tf.TransientProblem.__doc__ or f"{name}, " in tf.TransientProblem.__doc__
        for name in asked - {"end_time"}
    )


def test_a_problem_is_frozen_and_none_is_the_default(film):
    problem = tf.TransientProblem(film, None, method=None, damping=None, coupling=None, **GRID)
    assert (problem.maneuver, problem.method, problem.damping) == (tf.AtRest(), tf.WilsonTheta(), tf.Rayleigh())
    assert problem.count == 10
    with pytest.raises(FrozenInstanceError):
        problem.time_step = 1.0


@dataclass(frozen=True)
class MidPoint(tf.Method):
    """A user's method: mid-point rule as two stages, a half step there and an extrapolation of as much again."""

    name = "mid-point"

    def stages(self, step):
        half = 0.5 * step
        there = tf.Combination(1.0 / half, 0.0, 0.0)
        change = tf.Combination(1.0 / half**2, -1.0 / half, 0.0)
        twice = tf.Combination(2.0, 0.0, 0.0), tf.Combination(2.0 / half, -1.0, 0.0)
        return (tf.Stage(tf.StepScheme(0.5, 1.0, change, there, *twice, change)),)


class Shaking(tf.Maneuver):
    """A user's maneuver: the two methods of its base."""

    def start(self):
        return tf.AtRest().start()

    def segments(self):
        def motion(time):
            return tf.RigidMotion(np.zeros(3), np.zeros(3), np.array([0.0, 0.0, 3.0 * np.cos(9.0 * time)]))

        return (tf.Segment(0.0, np.inf, motion),)


@pytest.mark.jax
def test_methods_and_maneuvers_from_outside_work_in_every_plant(antenna):
    """The mid-point rule is the trapezoidal one for linear motion, to second order in the load's curvature."""
    rom = tf.reduce(antenna, tf.ModalBasis(directions=("z",), count=2))
    asked = {"time_step": 1e-3, "end_time": 0.2, "probes": {"A": (0.1, 0.1)}, "tolerance": 1e-9}
    for plant in (antenna, rom):
        w, reference = (
            tf.simulate(plant, Shaking(), method=m, **asked).data.w.values for m in (MidPoint(), tf.Newmark())
        )
        assert np.abs(w - reference).max() < 1e-2 * np.abs(reference).max()
    batch = tf.Batch(rom).simulate({"tension_x": [1.0]}, tf.Stop(0.6, 0.05), method=MidPoint(), **asked)
    single = tf.simulate(rom, tf.Stop(0.6, 0.05), method=MidPoint(), **asked).data
    assert np.abs(batch.w[0] - single.w).max() < 1e-6 * np.abs(single.w).max()


@pytest.mark.parametrize(
    ("stages", "words"),
    [
        ((), "shares are positive and add up to 1, got \\[\\]"),
        ((0.5, 0.6), "add up to 1, got \\[0.5, 0.6\\]"),
        ((-0.5, 1.5), "add up to 1"),
    ],
)
def test_stages_that_make_no_step_are_refused(film, stages, words):
    @dataclass(frozen=True)
    class Wrong(tf.Method):
        name = "wrong"

        def stages(self, step):
            return tuple(tf.Stage(tf.Newmark().scheme(share * step), share) for share in stages)

    with pytest.raises(InputError, match=words):
        tf.simulate(film, method=Wrong(), **GRID)


def test_memory_must_fit_the_states_passed(film):
    class Wrong(tf.Bathe):
        def stages(self, step):
            first, second = super().stages(step)
            return first, tf.Stage(second.scheme, second.share, second.velocity[:1], second.acceleration)

    with pytest.raises(InputError, match=r"factors of 2 states \(or none\) for V and A of stage 2, got 1 and 2"):
        tf.simulate(film, method=Wrong(), **GRID)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: tf.WilsonTheta("soft"), "theta: expected a finite number, got 'soft'; 1.4 is the usual choice"),
        (lambda: tf.WilsonTheta(3.5), r"theta: expected a number in \[1, 3\], got 3.5; 1.4 is the usual choice"),
        (lambda: tf.Newmark(gamma=None), "gamma: expected a finite number, got None; 0.5 is second order"),
        (lambda: tf.Newmark(beta="soft"), "beta: expected a finite number, got 'soft'"),
        (lambda: tf.Newmark(beta=0.0), r"beta: expected a number in \(0, 1\], got 0.0"),
    ],
)
def test_methods_say_in_words_what_their_options_are_not(make, message):
    with pytest.raises(tf.InputError, match=message):
        make()
