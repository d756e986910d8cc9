"""Dampers between nodes: closed forms, and one damper in every kind of run [theory.md 16]."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tautflex as tf
from tautflex import Damper, MeshError, PointMass, RigidLink, Spring, Support
from verification.test_links import CHAIN, LINE, frequencies, mast

TIP = Damper((10,), (0.0, 0.0, 0.4))


@pytest.fixture(scope="module")
def state() -> tf.PrestressedState:
    return tf.solve_prestress(mast(dampers=[TIP], masses=[PointMass(10, 1.0)]))


def oscillators(**given: Any) -> tf.PrestressedState:
    """Two masses of 2 kg on springs of 50 N/m to the frame along z, 0.5 m apart."""
    nodes = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    rope = tf.CableSection(tf.Material(1e6, 1e-9), 1e-9)
    model = tf.Model.from_mesh(
        nodes,
        cables=[(0, 1)],
        cable=rope,
        cable_tension=1e-6,
        masses=[PointMass(0, 2.0), PointMass(1, 2.0)],
        springs=[Spring((k,), (50.0, 50.0, 50.0)) for k in (0, 1)],
        supports=[Support((0, 1), ("x", "y"))],
        prestress_mode="uniform",
        **given,
    )
    return tf.solve_prestress(model)


@pytest.mark.parametrize("method", [tf.Newmark(), tf.CentralDifference()])
def test_ratios_and_decay_of_two_masses(method: Any, verification_row: Any) -> None:
    """c between both damps the motion against each other by c/sqrt(k m), that along each other not at all."""
    damper, mass, stiffness = 1.5, 2.0, 50.0
    found = oscillators(dampers=[Damper((0, 1), (0.0, 0.0, damper))])
    modes = tf.solve_modes(found, n=1), tf.solve_spinning_modes(found, (0.0, 0.0, 0.0), n=2)
    ratio = damper / np.sqrt(stiffness * mass)
    assert np.sort(modes[1].damping_ratios) == pytest.approx([0.0, ratio], abs=1e-7)
    thrown = np.array([[0.0, 0.0, 0.05], [0.0, 0.0, -0.05]])
    given = {"time_step": 2e-3, "end_time": 1.0, "probes": {"A": (0.5, 0.0)}, "method": method}
    run = tf.simulate(found, initial_velocity=thrown, **given)
    natural = np.sqrt(stiffness / mass)
    own, time = natural * np.sqrt(1.0 - ratio**2), run.data.time.values
    exact = -0.05 / own * np.exp(-ratio * natural * time) * np.sin(own * time)
    assert run.data.w.values[:, 0] == pytest.approx(exact, abs=5e-6)
    balance = run.energy_balance
    lost = mass * 0.05**2 - float((run.data.strain_energy + run.data.kinetic_energy).values[-1])
    assert lost > 0.5 * mass * 0.05**2
    assert balance["damping"] == pytest.approx(lost, rel=1e-4)
    verification_row("damper between two masses: ratio", ratio, modes[1].damping_ratios.max(), "c/sqrt(k m)")


def test_damper_on_arms_leaves_rigid_motions_alone() -> None:
    """With a place its rates are those of a point in between: a body that turns as a whole feels nothing."""
    model = mast(held=(), dampers=[Damper((0, 10), (1.0, 2.0, 3.0, 0.1, 0.1, 0.1), place=0.3), Damper((2, 7), 4.0)])
    vectors, values = tf.solve_prestress(model).system.dampers
    assert len(values) == 7
    assert np.abs(vectors @ model.rigid_motions[model.free_dofs]).max() < 1e-12


def test_linked_ends_lead_to_what_leads_them() -> None:
    nodes = np.vstack([LINE, [1.5, 0.0, 0.0]])
    model = mast(nodes, CHAIN, links=[RigidLink(10, [11])], dampers=[Damper((11,), (0.0, 0.0, 1.0))])
    vectors, _ = tf.solve_prestress(model).system.dampers
    tip = model.dof_offset[10]
    own = model.free_places[[tip + 2, tip + 4]]
    assert vectors[0, own] == pytest.approx([1.0, -0.5])
    assert np.count_nonzero(vectors) == 2


def run_of(plant: Any, **given: Any) -> Any:
    given = {"time_step": 2e-3, "end_time": 0.2, "probes": {"tip": LINE[10]}, "method": tf.Newmark()} | given
    return tf.simulate(plant, tf.Stop(0.1, 0.1, axis=(0.0, 1.0, 0.0)), **given)


def test_full_and_reduced_runs_and_linear_views(state: Any) -> None:
    full, without = (
        run_of(one).data.w.values for one in (state, tf.solve_prestress(mast(masses=[PointMass(10, 1.0)])))
    )
    scale = np.abs(full).max()
    assert np.abs(full - without).max() > 0.01 * scale
    rom = tf.reduce(state, tf.ModalBasis(directions=("z", "ry"), count=4))
    assert np.abs(run_of(rom).data.w.values - full).max() < 2e-3 * scale
    alike = run_of(state, method=tf.EnergyConserving())
    assert np.abs(alike.data.w.values - full).max() < 5e-3 * scale
    assert abs(alike.energy_balance["residual"]) < 1e-8 * alike.energy_balance["damping"]
    push = {"push": tf.NodalForce([10], direction=(0.0, 0.0, 1.0)).prepare(state.system)}
    plant = tf.linearize(state, push, {"tip": tf.Displacement([LINE[10]])}, modes=4)
    slow = np.linalg.eigvals(plant.A)
    spun = tf.solve_spinning_modes(state, (0.0, 0.0, 0.0), n=2)
    ratio = -slow.real / np.abs(slow)
    assert ratio.max() == pytest.approx(spun.damping_ratios.max(), rel=2e-2)


def test_runs_on_a_free_hub(state: Any) -> None:
    """A damper to the frame takes energy and leaves all momentum in the spacecraft."""
    hub = tf.FreeHub(2.0, (0.2, 0.2, 0.2), angular_velocity=(0.0, 0.3, 0.0))
    thrown = np.zeros((11, 3))
    thrown[:, 2] = 0.1 * LINE[:, 0] ** 2
    given = {"time_step": 2e-3, "end_time": 0.1, "method": tf.EnergyConserving(), "initial_velocity": thrown}
    run = tf.simulate(state, hub, tolerance=1e-10, **given)
    balance = run.energy_balance
    assert balance["damping"] > 1e-3 * balance["initial"]
    assert abs(balance["residual"]) < 1e-6 * balance["damping"]
    for name in ("linear_momentum", "angular_momentum"):
        momentum = run.data[name].values
        assert np.abs(momentum - momentum[0]).max() < 1e-10 * np.abs(momentum).max()


@pytest.mark.jax
def test_batches(state: Any) -> None:
    for damping, table in (
        (tf.Rayleigh(0.1, 0.0), {"damping.alpha": np.array([0.1])}),
        (tf.Modal(0.02, modes=2), {"damping.ratio": np.array([0.02])}),
    ):
        given = {"time_step": 2e-3, "end_time": 0.04, "probes": {"tip": LINE[10]}, "method": tf.Newmark()}
        spin = tf.Stop(1.0, 0.1, axis=(0.0, 1.0, 0.0))
        many = tf.Batch(state).simulate(table, spin, damping=damping, **given)
        one = tf.simulate(state, spin, damping=damping, **given).data
        assert np.abs(many.w[0].values - one.w.values).max() < 1e-7 * np.abs(one.w.values).max()


@pytest.mark.parametrize(
    ("damper", "message"),
    [
        (Damper((5, 12), 1.0), r"dampers\[0\]: expected node numbers"),
        (Damper((11,), (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)), r"dampers\[0\]: expected nodes that turn, got node 11"),
    ],
)
def test_refused_by_name(damper: Damper, message: str) -> None:
    rope = tf.CableSection(tf.Material(1e9, 1440.0), 1e-6)
    nodes = np.vstack([LINE, [1.5, 0.0, 0.0]])
    with pytest.raises(MeshError, match=message):
        mast(nodes, cables=[(10, 11)], cable=rope, cable_tension=1.0, dampers=[damper])


def test_frequencies_stay(state: Any) -> None:
    assert tf.solve_modes(state, n=3).frequencies == pytest.approx(
        frequencies(mast(masses=[PointMass(10, 1.0)])), rel=1e-12
    )
