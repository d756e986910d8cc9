"""Structure on a free hub: momenta, energy, limits and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import tautflex as tf
from tautflex import AtRest, Coupling, InputError, Rayleigh
from tautflex.motion.rotations import matrix
from tautflex.solvers.transient.free_hub.equation import HubEquation
from tautflex.solvers.transient.implicit import Stepper
from tautflex.solvers.transient.probes import place_probes
from tautflex.solvers.transient.simulate import begin
from tautflex.structure.antenna import AntennaLayout, build_antenna

METHODS = [tf.Newmark(), tf.WilsonTheta(), tf.EnergyConserving(), tf.GeneralizedAlpha(0.8), tf.HHT(0.1), tf.Bathe()]
HUB = {"mass": 20.0, "inertia": (4.0, 5.0, 6.0), "center": (0.1, -0.05, 0.2)}


def throw(x, y):
    return 0.02 * np.cos(np.pi * x / 2) * np.cos(np.pi * y)


@pytest.fixture(scope="module")
def antenna():
    layout = AntennaLayout(2.0, 1.0, (4, 2), "alternating", 2.5, 1.5, 5, 3, "tributary", "corners")
    model = build_antenna(
        layout,
        tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4),
        tf.CableSection(tf.Material(133e9, 1440.0), 3.14e-6),
        tf.BeamSection(tf.Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=0.3,
        pretension_y=0.5,
    )
    return tf.solve_prestress(model)


def point_sums(state, hub, at):
    """Momenta and kinetic energy by summing over every mass point, in inertial axes."""
    system, axes = state.system, matrix(at.hub.attitude)
    q, v = system.full(at.q), system.full(at.v)
    masses, places, speeds = [], [], []
    for group, block in zip(system.model.groups, system.blocks, strict=True):
        dofs, points = system.model.element_dofs(group), block.inertia
        shape = np.broadcast_to(points.interpolation, (len(dofs), *points.interpolation.shape[1:]))
        masses.append(points.mass.ravel())
        places.append((points.position + np.einsum("npkd,nd->npk", shape, q[dofs])).reshape(-1, 3))
        speeds.append(np.einsum("npkd,nd->npk", shape, v[dofs]).reshape(-1, 3))
    mass, rho, rate = np.concatenate(masses), np.concatenate(places), np.concatenate(speeds)
    velocity = (at.hub.twist[:3] + np.cross(at.hub.twist[3:], rho) + rate) @ axes.T
    place = at.hub.position + rho @ axes.T
    center = np.asarray(hub.center)
    own = axes @ (at.hub.twist[:3] + np.cross(at.hub.twist[3:], center))
    spin = axes @ (hub.tensor @ at.hub.twist[3:])
    linear = mass @ velocity + hub.mass * own
    angular = np.cross(place, mass[:, None] * velocity).sum(axis=0)
    angular += hub.mass * np.cross(at.hub.position + axes @ center, own) + spin
    energy = 0.5 * float(mass @ np.sum(velocity**2, axis=1)) + 0.5 * hub.mass * float(own @ own)
    return linear, angular, energy + 0.5 * float(at.hub.twist[3:] @ hub.tensor @ at.hub.twist[3:])


def hub_equation(state, hub):
    return HubEquation(state, Rayleigh(), Coupling(), hub=hub, probes=place_probes(state.system, {}))


def states_of(state, hub, method, step, count, velocity=None):
    """States of a run, every step."""
    equation = hub_equation(state, hub)
    stepper = Stepper(equation, method, 1e-11)
    at, _ = begin(equation, hub, np.zeros(state.system.size) if velocity is None else velocity)
    states = [at]
    for _ in range(count):
        at, outcome = stepper.step(at, step, AtRest().segments()[0])
        assert outcome.converged
        states.append(at)
    return equation, states


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_free_flight_keeps_both_momenta(antenna, method, verification_row):
    """The momenta are summed over all mass points, independently of how the stepper balances them."""
    hub = tf.FreeHub(**HUB, angular_velocity=(0.3, 0.2, -0.1), velocity=(0.1, 0.0, 0.05))
    start = np.random.default_rng(1).normal(size=antenna.system.size) * 1e-3
    equation, states = states_of(antenna, hub, method, 2e-3, 40, start)
    sums = [point_sums(antenna, hub, at) for at in states]
    for index, name in ((0, "linear"), (1, "angular")):
        first = sums[0][index]
        drift = max(float(np.linalg.norm(found[index] - first)) for found in sums) / float(np.linalg.norm(first))
        assert drift < 1e-9
        verification_row(f"free flight, {method.name}: {name} momentum drift", 0, drift, "conservation")
    assert equation.kinetic_energy(states[-1]) == pytest.approx(sums[-1][2], rel=1e-12)
    moved = float(np.abs(states[-1].hub.twist[3:] - states[0].hub.twist[3:]).max())
    assert moved > 1e-6  # the structure does shake the hub


def test_work_of_torque_and_force_is_the_energy_gained(antenna, verification_row):
    hub = tf.FreeHub(**HUB, torque=(0.2, 0.05, 0.1), force=(0.1, 0.0, 0.3))
    errors = []
    for step in (2e-3, 1e-3):
        data = tf.simulate(antenna, hub, method=tf.Newmark(), time_step=step, end_time=0.2).data
        energy = (data.kinetic_energy + data.strain_energy).values
        errors.append(abs(float((energy[-1] - energy[0]) / data.work[-1]) - 1.0))
    assert errors[1] < 1e-8
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    verification_row("free hub: work - energy gained, relative, dt = 1 ms", 0, errors[1], "work = energy change")


def smooth_torque(time, state):
    return 0.5 * np.sin(np.pi * time / 0.4) ** 4 * np.array([1.0, 0.5, -0.7])


@pytest.mark.parametrize("method", [*METHODS, tf.GeneralizedAlpha(0.0)], ids=lambda m: m.name)
def test_hub_and_film_converge_at_second_order(antenna, method, verification_row):
    """A torque that stirs up no vibration the steps could not resolve, against a run with a step of an eighth."""
    hub = tf.FreeHub(20.0, (4.0, 5.0, 6.0), angular_velocity=(0.0, 0.0, 0.1), torque=smooth_torque)
    given = {"method": method, "end_time": 0.32, "probes": {"A": (0.7, 0.4)}, "tolerance": 1e-10}
    runs = [tf.simulate(antenna, hub, time_step=step, **given).data for step in (8e-3, 4e-3, 1e-3)]
    for name in ("w", "angular_velocity", "attitude"):
        last = [run[name].values[-1] for run in runs]
        coarse, fine = (float(np.abs(found - last[2]).max()) for found in last[:2])
        # The reference has an error of its own: (1 - 1/64) / (1/4 - 1/64).
        assert coarse / fine == pytest.approx(4.2, rel=0.18)
        verification_row(f"free hub, {method.name}: ratio of errors of {name}", 4.2, coarse / fine, "order 2")


def test_a_force_on_the_structure_moves_the_spacecraft(antenna, verification_row):
    """On all nodes, held ones too: momentum is the impulse whatever the film does, work the energy gained."""
    nodes, largest, end = len(antenna.model.nodes), 0.1, 0.2
    # The trapezoidal rule integrates a whole period of the squared sine exactly.
    push = tf.NodalForce(range(nodes), lambda t: (0.0, 0.0, largest / nodes * np.sin(np.pi * t / end) ** 2))
    gaps = []
    for step in (2e-3, 1e-3):
        given = {"method": tf.GeneralizedAlpha(0.8), "time_step": step, "end_time": end, "tolerance": 1e-10}
        data = tf.simulate(antenna, tf.FreeHub(20.0, (4.0, 5.0, 6.0)), inputs=[push], **given).data
        impulse = np.array([0.0, 0.0, 0.5 * largest * end])
        error = float(np.abs(data.linear_momentum.values[-1] - impulse).max() / impulse[2])
        assert error < 1e-12
        energy = (data.kinetic_energy + data.strain_energy).values
        gaps.append(abs(float((energy[-1] - energy[0]) / data.work[-1]) - 1.0))
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.05)
    verification_row("free hub, force on the film: momentum - impulse, relative", 0, error, "impulse")
    verification_row("free hub, force on the film: work - energy gained, dt = 1 ms", 0, gaps[1], "work = energy change")


def test_a_force_off_the_centre_turns_the_spacecraft(antenna, verification_row):
    """Constant forces in hub axes on a free and on a held node, small angles: angular momentum r x F t."""
    model = antenna.model
    held, free = model.supports[0].nodes[0], int(np.argmin(np.linalg.norm(model.nodes - (0.5, 0.25, 0.0), axis=1)))
    force, end = np.array([0.0, 0.0, 1e-3]), 0.05
    given = {"method": tf.GeneralizedAlpha(0.8), "time_step": 1e-3, "end_time": end}
    pushes = [tf.NodalForce([node], tuple(force)) for node in (held, free)]
    data = tf.simulate(antenna, tf.FreeHub(20.0, (4.0, 5.0, 6.0)), inputs=pushes, **given).data
    exact = np.cross(model.nodes[held] + model.nodes[free], force) * end
    error = float(np.linalg.norm(data.angular_momentum.values[-1] - exact) / np.linalg.norm(exact))
    assert error < 1e-7
    verification_row("free hub, force on a held and a free node: angular momentum - r x F t", 0, error, "impulse")


def test_tension_and_temperature_keep_the_momenta(antenna):
    """They are internal: structure and hub move otherwise, their momenta do not."""
    reel = tf.CableTension(lambda t: 0.2 * np.sin(40 * t))
    heat = tf.MembraneTemperature(lambda t: 0.02 * min(t / 0.02, 1.0), 2e-5)
    given = {"method": tf.HHT(0.05), "time_step": 1e-3, "end_time": 0.03, "initial_velocity": throw}
    still, driven = (tf.simulate(antenna, tf.FreeHub(**HUB), inputs=i, **given).data for i in ((), [reel, heat]))
    for name in ("linear_momentum", "angular_momentum"):
        values = driven[name].values
        assert np.abs(values - values[0]).max() <= 1e-13 * np.abs(values).max()
    resultants = [run.max_principal_resultant.values for run in (still, driven)]
    assert np.abs(resultants[1] - resultants[0]).max() > 0.01 * resultants[0].max()


@pytest.mark.slow
def test_adaptive_steps_follow_their_tolerance(antenna, verification_row):
    """Errors of film and hub fall with the tolerance; on a heavy hub the steps are those of a prescribed motion."""
    given = {"method": tf.GeneralizedAlpha(0.8), "time_step": 1e-2, "end_time": 0.06, "probes": {"A": (0.7, 0.4)}}
    given["initial_velocity"] = throw
    hub = tf.FreeHub(2.0, (0.4, 0.5, 0.6), angular_velocity=(0.0, 0.0, 0.1), torque=(0.05, 0.02, 0.0))
    runs = [tf.simulate(antenna, hub, adaptive=tf.Adaptive(tolerance), **given) for tolerance in (1e-1, 1e-2, 1e-3)]
    for name in ("w", "attitude", "hub_position"):
        values = [run.data[name].values for run in runs]
        coarse, fine = (
            float(np.abs(found - values[2]).max() / np.ptp(values[2], axis=0).max()) for found in values[:2]
        )
        assert fine < min(1e-2, coarse / 10)
        verification_row(f"free hub, adaptive steps: error of {name} at 1e-2, relative", 0, fine, "a tenth of it")
    assert runs[0].stats.steps < runs[1].stats.steps < runs[2].stats.steps
    heavy = tf.FreeHub(2e6, (4e6, 5e6, 6e6))
    still, held = (
        tf.simulate(antenna, motion, adaptive=tf.Adaptive(1e-2), tolerance=1e-9, **given) for motion in (None, heavy)
    )
    assert held.stats.steps == still.stats.steps
    assert np.abs(held.data.w - still.data.w).max() < 1e-4 * np.abs(still.data.w).max()


def test_heavy_hub_is_a_prescribed_motion(antenna, verification_row):
    """Difference from the prescribed stop falls as one over the inertia of the hub."""
    rate, duration = 0.2, 0.05
    given = {
        "method": tf.Newmark(),
        "time_step": 2e-3,
        "end_time": 0.12,
        "probes": {"A": (0.7, 0.4)},
        "tolerance": 1e-11,
    }
    wanted = tf.simulate(antenna, tf.Stop(rate, duration), **given).data
    gaps = []
    for heavy in (1e7, 1e9):
        hub = tf.FreeHub(
            heavy,
            (heavy, heavy, heavy),
            angular_velocity=(rate, 0.0, 0.0),
            torque=lambda time, state, heavy=heavy: (-rate / duration * heavy if time < duration else 0.0, 0.0, 0.0),
            breaks=(duration,),
        )
        found = tf.simulate(antenna, hub, **given).data
        gaps.append(float(np.abs(found.w - wanted.w).max() / np.abs(wanted.w).max()))
    assert gaps[1] < 1e-7
    assert gaps[0] / gaps[1] == pytest.approx(100.0, rel=0.1)
    verification_row("free hub, inertia 1e9 kg m2, against prescribed stop, relative", 0, gaps[1], "limit")


def test_string_on_a_free_hub(verification_row):
    """Symmetric modes of a string whose ends ride on a mass m: tan(kL/2) = -m k / (2 rho A)."""
    length, tension, mass, elements = 2.0, 10.0, 0.02, 40
    section = tf.CableSection(tf.Material(1e9, 1000.0), 1e-5)
    nodes = np.column_stack([np.linspace(-1.0, 1.0, elements + 1), np.zeros((elements + 1, 2))])
    model = tf.Model.from_mesh(
        nodes,
        cables=np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        cable=section,
        cable_tension=tension,
        supports=(tf.Support.pinned([0, elements]),),
    )
    state = tf.solve_prestress(model)
    hub = tf.FreeHub(mass, (1.0, 1.0, 1.0))
    line = section.mass_per_measure
    # R(0) and B(0) of hub plus string: the mass that the free hub leaves to the elastic motion.
    rigid, lever = hub_equation(state, hub).blocks(np.zeros(state.system.size))
    reduced = state.system.inertia.mass_matrix.toarray()
    reduced -= lever.T @ np.linalg.solve(rigid, lever)
    found = np.sqrt(eigh(state.system.matrix(state.tangent_entries).toarray(), reduced, eigvals_only=True))
    k = brentq(lambda k: np.sin(k * length / 2) + mass * k / (2 * line) * np.cos(k * length / 2), 1.6, 3.1)
    exact = k * np.sqrt(tension / line)
    nearest = float(found[np.argmin(np.abs(found - exact))])
    assert nearest == pytest.approx(exact, rel=1e-3)
    assert exact > 1.05 * np.pi / length * np.sqrt(tension / line)  # far from the fixed string
    verification_row("string on a free hub, symmetric mode [rad/s]", exact, nearest, "tan(kL/2) = -m k/(2 rho A)")


def test_heavy_symmetric_top_precesses(antenna, verification_row):
    """Euler: with J = (J1, J1, J3) the spin's transverse part turns at (J3 - J1)/J1 w3 in hub axes."""
    hub = tf.FreeHub(1e6, (1e6, 1e6, 2e6), angular_velocity=(0.2, 0.0, 1.0))
    data = tf.simulate(antenna, hub, method=tf.Newmark(), time_step=5e-3, end_time=0.5).data
    exact = 0.2 * np.cos(data.time.values)
    error = float(np.abs(data.angular_velocity.values[:, 0] - exact).max()) / 0.2
    assert error < 2e-5
    verification_row("heavy symmetric top, precession, relative error", 0, f"{error:.1e}", "Euler's equations")


def test_feedback_damps_the_spin(antenna):
    """Torque -c w on a heavy hub: the rate decays as exp(-c t / J)."""
    hub = tf.FreeHub(
        1e6,
        (1e6, 1e6, 1e6),
        angular_velocity=(0.1, 0.0, 0.0),
        torque=lambda time, state: -5e6 * state.angular_velocity,
    )
    data = tf.simulate(antenna, hub, method=tf.Newmark(), time_step=2e-3, end_time=0.2).data
    rate = data.angular_velocity.values[:, 0] / 0.1
    np.testing.assert_allclose(rate, np.exp(-5.0 * data.time.values), rtol=1e-4)
    assert np.abs(np.linalg.norm(data.attitude.values, axis=1) - 1.0).max() < 1e-14


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": 0.0}, "mass"),
        ({"inertia": (1.0, -1.0, 1.0)}, "positive definite"),
        ({"attitude": (1.0, 1.0, 0.0, 0.0)}, "unit quaternion"),
        ({"torque": (1.0, 2.0)}, "torque"),
    ],
)
def test_bad_hubs_are_named(change, words):
    with pytest.raises(InputError, match=words):
        tf.FreeHub(**{**HUB, **change})


def test_what_a_free_hub_refuses(antenna):
    hub = tf.FreeHub(**HUB)
    with pytest.raises(InputError, match="explicit"):
        tf.simulate(antenna, hub, method=tf.CentralDifference(), time_step=1e-6, end_time=2e-6)
    with pytest.raises(InputError, match="coupling"):
        tf.simulate(antenna, hub, coupling=Coupling(euler=False), time_step=1e-3, end_time=2e-3)
    wrong = tf.FreeHub(**HUB, torque=lambda time, state: (1.0, 2.0))
    with pytest.raises(InputError, match="torque"):
        tf.simulate(antenna, wrong, method=tf.Newmark(), time_step=1e-3, end_time=2e-3)
