"""Loads on the structure of a free spacecraft: their impulse, their work, and the motion without any."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tautflex as tf
from tautflex.motion.rotations import matrix
from verification.dynamic_cases import small_antenna

END = 0.2
HUB = tf.FreeHub(20.0, (4.0, 5.0, 6.0), (0.1, -0.05, 0.2), angular_velocity=(0.0, 0.0, 0.1))


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


def pulse(time):
    """Force that stirs up no vibration the steps could not resolve."""
    return np.sin(np.pi * time / END) ** 4 * np.array([2e-3, 0.0, 1e-2])


def edge_of(model):
    """Nodes of the film along its edge y = -0.5, and the length that each stands for."""
    film = np.unique(model.triangles)
    edge = film[np.abs(model.nodes[film, 1] + 0.5) < 1e-9]
    edge = edge[np.argsort(model.nodes[edge, 0])]
    piece = np.diff(model.nodes[edge, 0])
    return edge, 0.5 * (np.append(piece, 0.0) + np.append(0.0, piece))


def load_of(model, name):
    """An input, the nodes it acts on, and the share of `pulse` that each gets."""
    if name == "edge":
        nodes, share = edge_of(model)
        return tf.EdgeForce(nodes.tolist(), pulse), nodes, share
    inside = int(np.argmin(np.linalg.norm(model.nodes - (0.5, 0.25, 0.0), axis=1)))
    nodes = [model.supports[0].nodes[0]] if name == "held node" else [inside]
    return tf.NodalForce(nodes, pulse), np.array(nodes), np.ones(1)


def run_with(state, push, step, **more):
    given = {"method": tf.EnergyConserving(), "time_step": step, "end_time": END, "tolerance": 1e-11, **more}
    return tf.simulate(state, HUB, inputs=[push], **given).data


@pytest.mark.parametrize("name", ["held node", "node", "edge"])
def test_impulse_of_a_load_is_the_momentum_gained(antenna, name, verification_row):
    """Forces and arms from the record alone, in inertial axes about the inertial origin; the hub turns as well."""
    push, nodes, share = load_of(antenna.model, name)
    data = run_with(antenna, push, 2e-3, fields="all")
    axes = np.array([matrix(attitude) for attitude in data.attitude.values])
    force = np.array([pulse(time) for time in data.time.values])
    forces = np.einsum("tij,n,tj->tni", axes, share, force)
    places = antenna.model.nodes[nodes] + data.displacement.values[:, nodes]
    arms = data.hub_position.values[:, None] + np.einsum("tij,tnj->tni", axes, places)
    for kind, rate in (("linear", forces), ("angular", np.cross(arms, forces))):
        momentum = data[f"{kind}_momentum"].values
        impulse = np.trapezoid(rate.sum(axis=1), data.time.values, axis=0)
        error = float(np.abs(momentum[-1] - momentum[0] - impulse).max() / np.abs(impulse).max())
        assert np.abs(impulse).max() > 1e-4
        assert error < 1e-10
        verification_row(f"free hub, force on {name}: {kind} momentum - impulse, relative", 0, error, "impulse")


@pytest.mark.parametrize("name", ["held node", "node", "edge"])
def test_work_of_a_load_is_the_energy_gained(antenna, name, verification_row):
    """Both are of second order in the step; what is left of their difference at step zero is round-off."""
    push, gaps = load_of(antenna.model, name)[0], []
    for step in (1e-3, 5e-4):
        data = run_with(antenna, push, step, every=10)
        energy = (data.kinetic_energy + data.strain_energy).values
        gaps.append(float((energy[-1] - energy[0]) / data.work.values[-1]) - 1.0)
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.02)
    left = abs(4.0 * gaps[1] - gaps[0]) / 3.0
    assert left < 1e-8
    verification_row(f"free hub, force on {name}: work - energy gained, relative, step to 0", 0, left, "conservation")


def test_a_constant_push_for_a_second(antenna, verification_row):
    """0.5 N along z through the centre of mass of hub and structure: momentum F t and the path F t^2 / 2 m."""
    film = np.unique(antenna.model.triangles)
    push = tf.NodalForce(film.tolist(), (0.0, 0.0, 0.5 / len(film)))
    hub = tf.FreeHub(0.8, (0.4, 0.5, 0.6))
    data = tf.simulate(antenna, hub, inputs=[push], method=tf.GeneralizedAlpha(0.8), time_step=5e-3, end_time=1.0).data
    momentum = data.linear_momentum.values[-1, 2]
    assert momentum == pytest.approx(0.5, rel=1e-12)
    mass = hub.mass + antenna.system.inertia.mass
    path = 0.25 / mass
    moved = float(data.hub_position.values[-1, 2])
    # The film runs ahead of the hub by what it bends.
    assert moved == pytest.approx(path, rel=0.02)
    verification_row("free hub, 0.5 N on the film for 1 s: way of the hub [m]", path, moved, "F t^2 / 2 m")


@pytest.mark.slow
def test_a_body_turned_about_its_middle_axis_flips(antenna, verification_row):
    """Dzhanibekov's flip of a heavy hub against Euler's equations of a rigid body."""
    moments, spin = np.array([1e6, 2e6, 3e6]), (0.1, 2.0, 0.05)
    hub = tf.FreeHub(1e6, moments, angular_velocity=spin)
    data = tf.simulate(antenna, hub, method=tf.Newmark(), time_step=5e-3, end_time=10.0, tolerance=1e-9).data
    time, found = data.time.values, data.angular_velocity.values

    def euler(_, w):
        return np.cross(moments * w, w) / moments

    exact = solve_ivp(euler, (0.0, time[-1]), spin, "DOP853", time, rtol=1e-12, atol=1e-14).y.T
    assert exact[:, 1].min() < -1.99
    error = float(np.abs(found - exact).max()) / 2.0
    assert error < 2e-3
    momentum = data.angular_momentum.values
    drift = float(np.abs(momentum - momentum[0]).max() / np.abs(momentum[0]).max())
    assert drift < 1e-12
    verification_row("Dzhanibekov's flip of a heavy hub, rates, relative", 0, error, "Euler's equations")
    verification_row("Dzhanibekov's flip of a heavy hub, angular momentum, relative", 0, drift, "conservation")


def test_damping_is_a_sink_of_energy_and_not_of_momentum(antenna, verification_row):
    """A light hub nutates and shakes its antenna: energy falls at every step, angular momentum stays."""
    hub = tf.FreeHub(0.5, (0.05, 0.06, 0.07), angular_velocity=(0.5, 0.3, 0.4))
    given = {"method": tf.EnergyConserving(), "time_step": 2e-3, "end_time": 0.4, "tolerance": 1e-11}
    free, damped = (
        tf.simulate(antenna, hub, damping=damping, **given).data for damping in (None, tf.Rayleigh(0.0, 2e-2))
    )
    momentum = damped.angular_momentum.values
    drift = float(np.abs(momentum - momentum[0]).max() / np.abs(momentum[0]).max())
    assert drift < 1e-12
    energies = [(run.kinetic_energy + run.strain_energy).values for run in (free, damped)]
    lost = [1.0 - energy[-1] / energy[0] for energy in energies]
    assert (np.diff(energies[1]) < 0.0).all()
    assert lost[1] > 20.0 * abs(lost[0])
    verification_row("energy sink on a free hub: angular momentum, relative", 0, drift, "conservation")


def test_a_force_that_a_prescribed_support_takes_up_is_told(antenna):
    """It moves a free hub, but nothing whose motion is prescribed; forces that reach the film are silent."""
    given = {"time_step": 2e-3, "end_time": 2e-2}
    held, inside = (load_of(antenna.model, name)[0] for name in ("held node", "node"))
    rom = tf.reduce(antenna, tf.ModalBasis(("z",), count=2, derivatives="none"))

    def told(plant, maneuver, *inputs):
        run = tf.simulate(plant, maneuver, inputs=inputs, **given)
        return [text for text in run.data.attrs["warnings"] if "inputs" in text]

    for plant, maneuver in ((antenna, None), (antenna, tf.Stop(0.1, 0.01)), (rom, None)):
        (text,) = told(plant, maneuver, inside, held)
        assert "NodalForce number 2 acts on supported directions alone" in text
        assert told(plant, maneuver, inside, load_of(antenna.model, "edge")[0]) == []
    assert told(antenna, HUB, held) == []
