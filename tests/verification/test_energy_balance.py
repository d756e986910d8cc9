"""Energy balance: it closes for every method and plant, and every term is what physics says."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.solvers.transient.accuracy.energy import frame_twist
from verification.dynamic_cases import oscillator, small_antenna, soft_film

METHODS = [
    tf.Newmark(),
    tf.Newmark(0.6, 0.3025),
    tf.WilsonTheta(),
    tf.GeneralizedAlpha(0.8),
    tf.HHT(0.1),
    tf.EnergyConserving(),
    tf.Bathe(),
]
DAMPING = tf.Rayleigh(0.5, 1e-3)


def bump(x, y):
    return 0.5 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8)


def pushed(time):
    return 0.0, 0.0, 0.5 * np.cos(25.0 * time) * (1.0 if time < 0.0513 else 2.0)


FORCE = tf.NodalForce([8], pushed, breaks=(0.0513,))
HUB = tf.FreeHub(
    20.0, (4.0, 5.0, 6.0), center=(0.1, -0.05, 0.2), angular_velocity=(0.3, 0.1, 0.2), torque=(2.0, 0.5, 1.0)
)


@pytest.fixture(scope="module")
def film():
    return soft_film()


@pytest.fixture(scope="module")
def reduced(film):
    return tf.reduce(film, tf.ModalBasis(count=4, directions=("rx",)))


def closes(run):
    """Whether the terms of a run leave nothing but round-off of the largest of them."""
    terms = run.energy_balance
    return abs(terms["residual"]) <= 1e-8 * max(map(abs, terms.values()))


@pytest.mark.parametrize("method", [*METHODS, tf.CentralDifference()], ids=lambda method: method.name)
@pytest.mark.parametrize("plant", ["film", "reduced"])
def test_method_takes_what_free_vibration_loses(method, plant, request):
    state, step = request.getfixturevalue(plant), 1e-3 if isinstance(method, tf.CentralDifference) else 5e-3
    run = tf.simulate(state, method=method, time_step=step, end_time=0.3, initial_velocity=bump, tolerance=1e-10)
    terms, first = run.energy_balance, run.data.isel(time=0)
    assert closes(run)
    assert terms["damping"] == terms["maneuver"] == terms["loads"] == 0.0
    assert terms["initial"] == pytest.approx(float(first.kinetic_energy + first.strain_energy), rel=1e-12)
    lost = terms["initial"] - terms["kinetic"] - terms["strain"]
    assert terms["method"] == pytest.approx(lost, abs=1e-8 * terms["initial"])


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
@pytest.mark.parametrize("plant", ["film", "reduced", "hub"])
def test_balance_of_loaded_damped_and_turning_structures_closes(method, plant, film, reduced):
    motion = HUB if plant == "hub" else tf.Stop(0.628, 0.0733, origin=(0.0, 0.2, 0.1))
    run = tf.simulate(
        reduced if plant == "reduced" else film,
        motion,
        method=method,
        time_step=5e-3,
        end_time=0.15,
        damping=DAMPING,
        inputs=[FORCE],
        initial_velocity=bump,
        tolerance=1e-10,
    )
    assert closes(run)
    assert run.energy_balance["damping"] > 0.0
    assert (run.energy_balance["maneuver"] == 0.0) == (plant == "hub")


def test_balance_of_adaptive_steps_and_changing_tension_closes(film):
    heat = tf.MembraneTemperature(
        lambda time: 5.0 * np.sin(30.0 * time) + (3.0 if time >= 0.0203 else 0.0), 2e-5, (0.0203,)
    )
    options = {"time_step": 5e-3, "end_time": 0.1, "damping": DAMPING, "initial_velocity": bump, "tolerance": 1e-10}
    for method in (tf.Newmark(), tf.GeneralizedAlpha(0.5), tf.WilsonTheta()):
        assert closes(tf.simulate(film, method=method, inputs=[heat], **options))
    assert closes(tf.simulate(film, method=tf.GeneralizedAlpha(), adaptive=tf.Adaptive(1e-3), **options))


@pytest.mark.parametrize("method", [tf.WilsonTheta(), tf.GeneralizedAlpha(0.5), tf.Newmark()], ids=lambda m: m.name)
def test_terms_are_of_second_order(method, film):
    found = []
    for step in (4e-3, 2e-3, 1e-3):
        run = tf.simulate(
            film,
            tf.Stop(0.628, 0.1033, origin=(0.0, 0.2, 0.1)),
            method=method,
            time_step=step,
            end_time=0.3,
            damping=DAMPING,
            initial_velocity=bump,
        )
        found.append([run.energy_balance[name] for name in ("damping", "maneuver")])
    first, second = np.diff(found, axis=0)
    np.testing.assert_allclose(np.log2(np.abs(first / second)), 2.0, atol=0.35)


def test_damping_of_an_oscillator_against_its_closed_form(verification_row):
    """What mass-proportional damping takes from an oscillator that starts in its middle."""
    state, rate, time = oscillator(1.0), 0.4, 2.0
    run = tf.simulate(
        state,
        method=tf.Newmark(),
        time_step=1e-3,
        end_time=time,
        damping=tf.Rayleigh(rate, 0.0),
        initial_velocity=lambda x, y: 1e-6 * np.ones_like(x),
    )
    # x' = v0 exp(-a t / 2) (cos wt - a/(2 w) sin wt): energy left after t.
    natural = 2.0 * np.pi
    w = np.sqrt(natural**2 - 0.25 * rate**2)
    decay, angle = np.exp(-0.5 * rate * time), w * time
    speed, place = decay * (np.cos(angle) - 0.5 * rate / w * np.sin(angle)), decay * np.sin(angle) / w
    taken = 1.0 - speed**2 - natural**2 * place**2
    found = run.energy_balance["damping"] / run.energy_balance["initial"]
    assert found == pytest.approx(taken, rel=1e-4)
    verification_row("energy that damping takes from an oscillator, of its first", taken, found, "closed form")


def test_damping_that_dies_inside_a_step_is_told(verification_row):
    """Overdamped, 50 times within a step: the sum of both parts is the energy that went, the split means nothing."""

    def run(step, end):
        return tf.simulate(
            oscillator(2.0),
            method=tf.Newmark(),
            time_step=step,
            end_time=end,
            damping=tf.Rayleigh(1e4, 0.0),
            initial_velocity=lambda x, y: 1e-6 + 0 * x,
            tolerance=1e-12,
        )

    lost = run(5e-3, 0.5)
    balance = lost.energy_balance
    assert balance["damping"] < -balance["initial"]
    told = [text for text in lost.warnings if "the damping of the steps put in" in text]
    assert len(told) == 1
    assert not any("the method took out" in text for text in lost.warnings)
    went = balance["initial"] - balance["kinetic"] - balance["strain"]
    assert balance["damping"] + balance["method"] == pytest.approx(went, rel=1e-9)
    fine = run(2e-6, 2e-3)
    assert not any("the damping of the steps" in text for text in fine.warnings)
    share = fine.energy_balance["damping"] / fine.energy_balance["initial"]
    assert share == pytest.approx(1.0, abs=1e-3)
    verification_row(
        "overdamped oscillator, a fiftieth of its decay time a step: energy that damping takes", 1.0, share, "all"
    )


def test_newmark_takes_what_its_energy_identity_says(film):
    """Energy that Newmark's recurrence of a linear oscillator loses, written out."""
    method, step, state = tf.Newmark(0.6, 0.3025), 5e-3, oscillator(2.0)
    run = tf.simulate(
        state, method=method, time_step=step, end_time=1.0, initial_velocity=lambda x, y: 1e-6 + 0 * x, tolerance=1e-12
    )
    system = state.system
    stiffness = float(state.tangent_entries[0])
    mass = float(system.inertia.mass_entries[0])
    q, v, a, lost = 0.0, 1e-6, 0.0, 0.0
    for _ in range(200):
        place = q + step * v + step**2 * (0.5 - method.beta) * a
        end = -stiffness * place / (mass + method.beta * step**2 * stiffness)
        before = 0.5 * mass * v**2 + 0.5 * stiffness * q**2
        q, v, a = place + method.beta * step**2 * end, v + step * ((1.0 - method.gamma) * a + method.gamma * end), end
        lost += before - 0.5 * mass * v**2 - 0.5 * stiffness * q**2
    assert run.energy_balance["method"] == pytest.approx(lost, rel=1e-6)


def test_maneuver_does_the_work_of_a_rigid_stop(verification_row):
    """A stiff antenna: the stop takes out J w^2 / 2 but for what is left in vibration."""
    state, rate = tf.solve_prestress(small_antenna()), 0.1
    run = tf.simulate(
        state,
        tf.Stop(rate, 1.0),
        method=tf.GeneralizedAlpha(),
        time_step=5e-3,
        end_time=1.0,
        damping=tf.Rayleigh(0.0, 1e-3),
    )
    second = state.system.inertia.second_moment
    rigid = 0.5 * (second[1, 1] + second[2, 2]) * rate**2
    found = -run.energy_balance["maneuver"]
    assert found == pytest.approx(rigid, rel=5e-3)
    verification_row("work that the stop of a stiff antenna takes out [J]", rigid, found, "J w^2 / 2")


def test_hub_and_prescribed_motion_agree(film):
    """A heavy hub that turns freely moves like a prescribed steady spin: the same energies, the same losses."""
    options = {
        "method": tf.GeneralizedAlpha(0.5),
        "time_step": 5e-3,
        "end_time": 0.2,
        "damping": DAMPING,
        "initial_velocity": bump,
    }
    heavy = tf.FreeHub(1e9, (1e9, 1e9, 1e9), angular_velocity=(0.3, 0.0, 0.0))
    free = tf.simulate(film, heavy, **options).energy_balance
    given = tf.simulate(film, tf.SpinUp(0.3, 1.0, initial_rate=0.3), **options).energy_balance
    for name in ("strain", "damping"):
        assert free[name] == pytest.approx(given[name], rel=1e-4)


def test_velocity_of_a_frame_that_turns_about_a_point():
    maneuver = tf.SpinUp(1.0, 2.0, origin=(0.0, 0.3, 0.1), initial_rate=0.2)
    for time in (0.0, 0.7, 3.0):
        twist = frame_twist(maneuver, maneuver.segments(), time)
        np.testing.assert_allclose(twist[:3], -np.cross(twist[3:], maneuver.origin), atol=1e-10)
