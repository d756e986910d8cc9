"""Reduced models on a free hub: momenta, energy, rigid limits, and the full model."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tautflex as tf
from tautflex.motion.rotations import matrix
from verification.dynamic_cases import small_antenna, soft_film
from verification.test_reduced_inputs import antenna as softened_antenna

pytestmark = pytest.mark.slow

METHODS = [
    tf.CentralDifference(), tf.Newmark(), tf.WilsonTheta(), tf.EnergyConserving(), tf.GeneralizedAlpha(0.8),
    tf.HHT(0.1), tf.Bathe(),
]  # fmt: skip
BODY = {"mass": 20.0, "inertia": (4.0, 5.0, 6.0)}
OFF_CENTER = {**BODY, "center": (0.1, -0.05, 0.2)}
FREE = tf.FreeHub(**OFF_CENTER, angular_velocity=(0.3, 0.2, -0.1), velocity=(0.1, 0.0, 0.05))
ABOUT_X = tf.FreeHub(**OFF_CENTER, angular_velocity=(0.3, 0.0, 0.0), axes="x")


def throw(x, y):
    return 0.02 * np.cos(np.pi * x / 2) * np.cos(np.pi * y)


def rise(time, state):
    """Torque that stirs up no vibration the steps could not resolve; its integral over 0.2 s is 0.0375 N m s."""
    return 0.5 * np.sin(np.pi * time / 0.2) ** 4 * np.array([1.0, 0.5, -0.7])


@cache
def antenna():
    return tf.solve_prestress(small_antenna())


@cache
def rom(count=8):
    return tf.reduce(antenna(), tf.ModalBasis(count=count, candidates=80))


def turned(first, second):
    """Angles between attitudes [rad], shape (n,)."""
    between = np.array([matrix(a).T @ matrix(b) for a, b in zip(first, second, strict=True)])
    return 0.5 * np.linalg.norm(between - between.transpose(0, 2, 1), axis=(1, 2)) / np.sqrt(2.0)


def drift(values):
    return float(np.abs(values - values[0]).max() / np.abs(values).max())


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_free_flight_keeps_both_momenta_and_the_balance_closes(method, verification_row):
    given = {"time_step": 5e-4, "end_time": 0.1, "initial_velocity": throw, "method": method}
    run = tf.simulate(rom(), FREE, **given)
    for name in ("linear_momentum", "angular_momentum"):
        found = drift(run.data[name].values)
        assert found < 1e-12
        verification_row(f"reduced model on a free hub, {method.name}: {name} drift", 0, found, "conservation")
    moving = float((run.data.kinetic_energy - run.data.kinetic_energy[0]).max() + run.data.strain_energy.max())
    assert abs(run.energy_balance["residual"]) < 1e-8 * moving
    assert float(np.abs(run.data.angular_velocity - run.data.angular_velocity[0]).max()) > 1e-6
    about = tf.simulate(rom(), ABOUT_X, **given)
    assert drift(about.data.angular_momentum.values[:, 0]) < 1e-12
    assert abs(about.energy_balance["residual"]) < 1e-8 * moving
    assert not about.data.hub_position.values.any()
    assert not about.data.angular_velocity.values[:, 1:].any()


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_momentum_is_the_impulse_of_the_torque(method, verification_row):
    """About one axis, where hub and inertial axes agree; the rule's own sum is what the steps take."""
    torque = 0.07
    hub = tf.FreeHub(**OFF_CENTER, axes="x", torque=(torque, 0.0, 0.0), angular_velocity=(0.1, 0.0, 0.0))
    data = tf.simulate(rom(), hub, method=method, time_step=1e-3, end_time=0.1, initial_velocity=throw).data
    momentum = data.angular_momentum.values[:, 0]
    error = float(np.abs(momentum - momentum[0] - torque * data.time.values).max() / momentum[-1])
    assert error < 1e-12
    verification_row(f"reduced model, hub about x, {method.name}: momentum - impulse", 0, error, "impulse")
    fed = tf.FreeHub(**OFF_CENTER, axes="x", torque=lambda time, state: (torque, 0.0, 0.0))
    assert drift(tf.simulate(rom(), fed, method=method, time_step=1e-3, end_time=0.01).data.work.values) > 0.0


@pytest.mark.parametrize("hub", [FREE, ABOUT_X], ids=["free", "about x"])
@pytest.mark.parametrize("method", [METHODS[0], METHODS[1], METHODS[3]], ids=lambda m: m.name)
def test_energy_is_kept_at_second_order(method, hub, verification_row):
    """About one axis the energy-conserving method keeps it to round-off."""
    lost, kept = [], 0.0
    for step in (1e-3, 5e-4):
        run = tf.simulate(rom(), hub, method=method, time_step=step, end_time=0.1, initial_velocity=throw)
        energy = (run.data.kinetic_energy + run.data.strain_energy).values
        lost.append(float(np.abs(energy - energy[0]).max()))
        kept = 1e-14 * float(energy[0])
    if hub is ABOUT_X and method == tf.EnergyConserving():
        assert max(lost) < kept
        return
    order = float(np.log2(lost[0] / lost[1]))
    assert order > 1.8
    kind = "free hub" if hub is FREE else "hub about x"
    verification_row(f"reduced model, {kind}, {method.name}: order of the energy's error", 2, order, "observed order")


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_hub_and_film_converge_at_second_order(method, verification_row):
    hub = tf.FreeHub(**BODY, angular_velocity=(0.0, 0.0, 0.1), torque=rise)
    given = {"method": method, "end_time": 0.16, "probes": {"A": (0.7, 0.4)}, "tolerance": 1e-11}
    runs = [tf.simulate(rom(), hub, time_step=step, **given).data for step in (2e-3, 1e-3, 2.5e-4)]
    for name in ("w", "angular_velocity", "attitude"):
        last = [run[name].values[-1] for run in runs]
        coarse, fine = (float(np.abs(found - last[2]).max()) for found in last[:2])
        assert coarse / fine == pytest.approx(4.2, rel=0.2)
        verification_row(
            f"reduced model, free hub, {method.name}: ratio of errors of {name}", 4.2, coarse / fine, "order 2"
        )


def test_a_body_turned_about_its_middle_axis_flips(verification_row):
    """Dzhanibekov's flip of a heavy hub against Euler's equations, by central differences."""
    moments, spin = np.array([1e6, 2e6, 3e6]), (0.1, 2.0, 0.05)
    hub = tf.FreeHub(1e6, moments, angular_velocity=spin)
    stiff = tf.reduce(tf.solve_prestress(small_antenna(scale=100.0)), tf.ModalBasis(count=4, derivatives="none"))
    given = {"method": tf.Newmark(), "time_step": 5e-3, "end_time": 10.0, "every": 10}
    data = tf.simulate(stiff, hub, **given).data
    time, found = data.time.values, data.angular_velocity.values

    def euler(_, w):
        return np.cross(moments * w, w) / moments

    exact = solve_ivp(euler, (0.0, time[-1]), spin, "DOP853", time, rtol=1e-12, atol=1e-14).y.T
    assert exact[:, 1].min() < -1.99
    error = float(np.abs(found - exact).max()) / 2.0
    assert error < 2e-3
    verification_row("reduced model, Dzhanibekov's flip, rates, relative", 0, error, "Euler's equations")
    assert drift(data.angular_momentum.values) < 1e-12


def test_a_symmetric_top_precesses(verification_row):
    """Torque-free: the spin about the axis stays, the rest turns with (C - A) / A times it in hub axes."""
    across, along, spin = 1e5, 1.6e5, (0.05, 0.0, 0.4)
    hub = tf.FreeHub(1e5, (across, across, along), angular_velocity=spin)
    data = tf.simulate(rom(), hub, method=tf.CentralDifference(), time_step=2e-3, end_time=4.0, every=20).data
    turn = (along - across) / across * spin[2] * data.time.values
    exact = np.stack([spin[0] * np.cos(turn), spin[0] * np.sin(turn), np.full_like(turn, spin[2])], axis=1)
    error = float(np.abs(data.angular_velocity.values - exact).max() / spin[0])
    assert error < 2e-3
    verification_row("reduced model, torque-free symmetric top, rates", 0, error, "precession (C - A) w / A")


def test_all_vectors_are_the_full_model(verification_row):
    """A hyper-reduced film with every vector and every element is the film: same motion on the same hub."""
    state = soft_film((3, 2))
    basis_run = tf.simulate(
        state, tf.FreeHub(3.0, (1.0, 1.2, 0.9)), time_step=1e-3, end_time=0.12, initial_velocity=everywhere(state),
        fields="all", method=tf.Newmark(),
    )  # fmt: skip
    whole = tf.hyper_reduce(state, basis_run.data, lost=(1e-26, 1e-26), tolerance=0.0)
    assert whole.size == state.system.size
    hub = tf.FreeHub(3.0, (1.0, 1.2, 0.9), (0.1, 0.0, 0.2), angular_velocity=(0.5, 0.3, -0.2), torque=rise)
    given = {
        "time_step": 1e-3, "end_time": 0.12, "probes": {"A": (0.1, 0.13)}, "tolerance": 1e-12,
        "initial_velocity": everywhere(state),
    }  # fmt: skip
    for method in (tf.Newmark(), tf.EnergyConserving(), tf.GeneralizedAlpha(0.8)):
        full, reduced = (tf.simulate(plant, hub, method=method, **given).data for plant in (state, whole))
        for name in (
            "w",
            "u",
            "angular_velocity",
            "attitude",
            "hub_position",
            "angular_momentum",
            "kinetic_energy",
            "work",
        ):
            scale = float(np.abs(full[name]).max())
            error = float(np.abs(full[name] - reduced[name]).max()) / scale
            assert error < 1e-8, (method.name, name)
    verification_row("film with all its vectors on a free hub: motion, relative", 0, error, "full model")


def everywhere(state):
    """Velocities of all free nodes in all directions [m/s]."""
    rows = np.random.default_rng(3).normal(size=(len(state.model.nodes), 3)) * [0.02, 0.02, 0.3]
    free = (state.system.place[state.model.translation_dofs] < state.system.size).any(axis=1)
    return rows * free[:, None]


@pytest.mark.parametrize("axes", ["free", "xyz", "x"])
def test_a_hub_that_is_held_is_the_full_one(axes, verification_row):
    """Slow motion under a smooth torque: what is left is what the basis leaves out."""
    torque = rise if axes != "x" else lambda time, state: rise(time, state) * [1.0, 0.0, 0.0]
    hub = tf.FreeHub(**BODY, axes=axes, torque=torque)
    given = {"method": tf.GeneralizedAlpha(0.8), "time_step": 1e-3, "end_time": 0.3, "probes": {"A": (0.7, 0.4)}}
    full, reduced = (tf.simulate(plant, hub, **given).data for plant in (antenna(), rom(16)))
    error = float(
        turned(full.attitude.values, reduced.attitude.values).max()
        / turned(full.attitude.values[:1], full.attitude.values[-1:])[0]
    )
    assert error < 2e-5
    verification_row(f"reduced model, hub with axes = {axes}: attitude, relative", 0, error, "full model")
    gap = float(np.sqrt(np.mean((full.w - reduced.w) ** 2) / np.mean(full.w**2)))
    assert gap < 1e-3


def test_a_force_on_the_structure_moves_the_spacecraft(verification_row):
    """On all nodes, held ones too: momentum is the impulse, work the energy gained, as for the full model."""
    nodes, end = len(antenna().model.nodes), 0.1
    push = tf.NodalForce(range(nodes), lambda t: (0.0, 0.0, 0.1 / nodes * np.sin(np.pi * t / end) ** 2))
    for method in (tf.CentralDifference(), tf.GeneralizedAlpha(0.8)):
        gaps = []
        for step in (1e-3, 5e-4):
            given = {"method": method, "time_step": step, "end_time": end, "inputs": [push]}
            run = tf.simulate(rom(), tf.FreeHub(**BODY), **given)
            impulse = 0.5 * 0.1 * end
            error = float(np.abs(run.data.linear_momentum.values[-1] - (0.0, 0.0, impulse)).max() / impulse)
            assert error < 1e-12
            energy = (run.data.kinetic_energy + run.data.strain_energy).values
            gaps.append(abs(float((energy[-1] - energy[0]) / run.data.work[-1]) - 1.0))
            assert abs(run.energy_balance["residual"]) < 1e-8 * float(run.data.work[-1])
        assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.2)
        verification_row(f"reduced model, force on the film, {method.name}: momentum - impulse", 0, error, "impulse")
    full, many = (tf.simulate(plant, tf.FreeHub(**BODY), **given).data for plant in (antenna(), rom(32)))
    gap = float(np.abs(full.hub_position - many.hub_position).max() / full.hub_position[-1, 2])
    assert gap < 2e-4
    verification_row("reduced model, force on the film: way of the hub, relative", 0, gap, "full model")


def test_feedback_damps_the_spin_as_on_the_full_model(verification_row):
    def law(time, state):
        return -4.0 * state.angular_velocity - 0.1 * state.probe_velocity[0]

    hub = tf.FreeHub(**BODY, angular_velocity=(0.1, 0.05, 0.0), torque=law)
    given = {"time_step": 2e-3, "end_time": 0.05, "probes": {"A": (0.5, 0.25)}}
    full = tf.simulate(antenna(), hub, method=tf.GeneralizedAlpha(0.8), **given).data
    for method in METHODS:
        data = tf.simulate(rom(), hub, method=method, **given).data
        error = float(np.abs(full.angular_velocity - data.angular_velocity).max() / 0.1)
        assert error < 2e-3
        momentum = data.angular_momentum.values
        assert np.linalg.norm(momentum[-1]) < np.linalg.norm(momentum[0])
    verification_row("reduced model, rate feedback: angular velocity, relative", 0, error, "full model")


def test_a_cut_torque_jumps():
    """A torque that stops at an instant between two steps: momentum is its impulse."""
    hub = tf.FreeHub(**BODY, axes="x", breaks=(0.0305,), torque=lambda time, _: (0.2 * (time < 0.0305), 0.0, 0.0))
    for method in METHODS:
        data = tf.simulate(rom(), hub, method=method, time_step=1e-3, end_time=0.06).data
        assert data.angular_momentum.values[-1, 0] == pytest.approx(0.2 * 0.0305, rel=1e-12)


@cache
def soft_rom():
    """Cables 1000 times softer, so that tension of theirs is tension of the film."""
    return tf.reduce(softened_antenna(1e3), tf.ModalBasis(count=8, candidates=80))


def tension(time):
    """Change of a cable tension [N] that jumps at 0.0305 s."""
    return -0.2 * np.sin(40.0 * time) if time < 0.0305 else 0.15 * np.cos(60.0 * time)


@pytest.mark.parametrize("hub", [FREE, ABOUT_X], ids=["free", "about x"])
@pytest.mark.parametrize("method", [METHODS[0], METHODS[1], METHODS[3]], ids=lambda m: m.name)
def test_tension_moves_no_momentum_and_the_balance_closes(method, hub, verification_row):
    pull = tf.CableTension(tension, breaks=(0.0305,))
    given = {"method": method, "time_step": 5e-4, "end_time": 0.1, "initial_velocity": throw, "inputs": [pull]}
    given |= {"probes": {"A": (0.5, 0.25)}}
    run, plain = tf.simulate(soft_rom(), hub, **given), tf.simulate(soft_rom(), hub, **{**given, "inputs": []})
    assert float(np.abs(run.data.w - plain.data.w).max() / np.abs(plain.data.w).max()) > 1e-3
    names = ("linear_momentum", "angular_momentum") if hub is FREE else ("angular_momentum",)
    for name in names:
        found = drift(run.data[name].values if hub is FREE else run.data[name].values[:, 0])
        assert found < 1e-12
        kind = "free hub" if hub is FREE else "hub about x"
        verification_row(f"reduced model under tension, {kind}, {method.name}: {name} drift", 0, found, "conservation")
    balance = run.energy_balance
    moving = float((run.data.kinetic_energy - run.data.kinetic_energy[0]).max() + run.data.strain_energy.max())
    assert abs(balance["loads"]) > 1e-2 * moving
    assert abs(balance["residual"]) < 1e-8 * moving
    # Tension is no force from outside.
    assert np.abs(run.data.work.values).max() < 1e-14 * moving


def test_tension_on_a_hub_is_the_full_model(verification_row):
    """A torque turns an antenna that slackens and tightens; what is left is what the basis leaves out."""
    state = softened_antenna(1e3)
    pull = tf.CableTension(lambda time: -0.2 * np.sin(20.0 * time) ** 2)
    hub = tf.FreeHub(**BODY, torque=lambda time, state: 0.5 * rise(time, state))
    given = {"time_step": 1e-3, "end_time": 0.3, "probes": {"A": (0.5, 0.25)}, "method": tf.GeneralizedAlpha(0.8)}
    many = tf.reduce(state, tf.ModalBasis(count=24, candidates=80))
    full, reduced = (tf.simulate(plant, hub, inputs=[pull], **given).data for plant in (state, many))
    plain = tf.simulate(state, hub, **given).data
    effect, gap = (float(np.sqrt(np.mean((full.w - each.w) ** 2) / np.mean(full.w**2))) for each in (plain, reduced))
    assert effect > 0.1
    assert gap < 1e-3
    turn = turned(full.attitude.values[:1], full.attitude.values[-1:])[0]
    assert turned(full.attitude.values, reduced.attitude.values).max() < 1e-4 * turn
    verification_row("reduced model on a free hub under tension: rms of the record", 0, gap, "full model")


@pytest.mark.parametrize("method", [METHODS[0], METHODS[1], METHODS[3]], ids=lambda m: m.name)
def test_a_stay_cable_moves_no_momentum(method, verification_row):
    stay = tf.StayCable((0.5, 0.25), (0.3, 0.1, 0.4), lambda time: 0.02 * np.sin(np.pi * time / 0.1) ** 2)
    given = {"method": method, "time_step": 5e-4, "end_time": 0.1, "initial_velocity": throw, "inputs": [stay]}
    run = tf.simulate(rom(), FREE, **given)
    for name in ("linear_momentum", "angular_momentum"):
        found = drift(run.data[name].values)
        assert found < 1e-12
        verification_row(f"reduced model, stay cable, {method.name}: {name} drift", 0, found, "conservation")
    moving = float((run.data.kinetic_energy - run.data.kinetic_energy[0]).max() + run.data.strain_energy.max())
    assert abs(run.energy_balance["residual"]) < 1e-8 * moving
    assert float(np.abs(run.data.work).max()) > 1e-3 * moving


def test_all_vectors_under_changing_stress_are_the_full_model(verification_row):
    """Stresses in the elements of a film with every vector, over a jump: motion, energy and balance are the film's."""
    state = soft_film((3, 2))
    given = {"time_step": 1e-3, "end_time": 0.06, "initial_velocity": everywhere(state)}
    basis_run = tf.simulate(state, tf.FreeHub(3.0, (1.0, 1.2, 0.9)), fields="all", method=tf.Newmark(), **given)
    whole = tf.hyper_reduce(state, basis_run.data, lost=(1e-26, 1e-26), tolerance=0.0)
    assert whole.size == state.system.size
    heat = tf.MembraneTemperature(lambda t: 1e-3 if t < 0.0305 else -1e-3 * np.cos(20.0 * t), 1.0, (0.0305,))
    hub = tf.FreeHub(3.0, (1.0, 1.2, 0.9), (0.1, 0.0, 0.2), angular_velocity=(0.5, 0.3, -0.2))
    given |= {"probes": {"A": (0.1, 0.13)}, "tolerance": 1e-12, "inputs": [heat], "method": tf.Newmark()}
    full, reduced = (tf.simulate(plant, hub, **given) for plant in (state, whole))
    plain = tf.simulate(whole, hub, **{**given, "inputs": []})
    assert float(np.abs(plain.data.w - full.data.w).max() / np.abs(full.data.w).max()) > 1e-3
    for name in ("w", "angular_velocity", "angular_momentum", "kinetic_energy", "strain_energy"):
        error = float(np.abs(full.data[name] - reduced.data[name]).max() / np.abs(full.data[name]).max())
        assert error < 1e-8, name
    verification_row("film with all its vectors under heat on a free hub: energy, relative", 0, error, "full model")
    total = max(abs(value) for value in full.energy_balance.values())
    for name, value in full.energy_balance.items():
        assert reduced.energy_balance[name] == pytest.approx(value, abs=1e-3 * total), name
    assert abs(reduced.energy_balance["residual"]) < 1e-8 * total
    assert drift(reduced.data.angular_momentum.values) < 1e-12


@pytest.mark.parametrize("hub", [FREE, ABOUT_X], ids=["free", "about x"])
def test_a_cut_run_goes_on_from_its_motion(hub):
    given = {"time_step": 1e-3, "method": tf.Newmark(), "probes": {"A": (0.5, 0.25)}}
    pull = {"inputs": [tf.CableTension(tension, breaks=(0.0305,))]}
    whole = tf.simulate(soft_rom(), hub, end_time=0.06, initial_velocity=throw, **given, **pull)
    first = tf.simulate(soft_rom(), hub, end_time=0.031, every=10, initial_velocity=throw, **given, **pull)
    assert "as if never cut" in repr(first.final)
    second = tf.simulate(soft_rom(), hub, end_time=0.06, initial=first.final, **given, **pull)
    for name in ("attitude", "angular_velocity", "hub_position", "angular_momentum", "w"):
        wanted, found = whole.data[name].sel(time=second.data.time), second.data[name]
        assert float(np.abs(wanted - found).max()) < 1e-3 * max(float(np.abs(wanted).max()), 1e-9), name
    if hub is FREE:
        with pytest.raises(tf.InputError, match="initial: expected a hub that does not move where axes = 'x'"):
            tf.simulate(soft_rom(), ABOUT_X, end_time=0.06, initial=first.final, **given)


def test_what_hubs_and_reduced_models_refuse():
    for change, words in (
        ({"axes": "xy"}, "axes"),
        ({"axes": "x", "angular_velocity": (0.1, 0.2, 0.0)}, "angular_velocity"),
        ({"axes": "xyz", "velocity": (0.1, 0.0, 0.0)}, "velocity"),
        ({"axes": "z", "force": (1.0, 0.0, 0.0)}, "force"),
    ):
        with pytest.raises(tf.InputError, match=words):
            tf.FreeHub(**BODY, **change)
    given = {"time_step": 1e-3, "end_time": 2e-3}
    with pytest.raises(tf.InputError, match="coupling"):
        tf.simulate(rom(), FREE, coupling=tf.Coupling(euler=False), **given)
    with pytest.raises(tf.InputError, match="stable step"):
        tf.simulate(rom(), FREE, method=tf.CentralDifference(), time_step=0.5, end_time=1.0)
