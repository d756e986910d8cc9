"""Arms of rigid links that carry forces: they turn with the body, in prestress, in spin and in runs [theory.md 16]."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tautflex as tf
from tautflex import PointMass, RigidLink, Spring, Support

ROPE = tf.CableSection(tf.Material(1e11, 1500.0), 1e-6, strain="green-lagrange")
NO_WEIGHT = tf.CableSection(tf.Material(1e9, 1e-9), 1e-6, strain="green-lagrange")
PULL = 20.0


def tube(stiffer: float = 1.0, density: float = 2700.0) -> tf.BeamSection:
    material = tf.Material(7e10 * stiffer, density, 0.33)
    return tf.BeamSection(material, 1e-4, 8.33e-10, 8.33e-10, 1.4e-9, strain="green-lagrange")


def bow(stiffer: float | None = None, through: bool = False) -> tf.Model:
    """Free boom with a taut string between two arms: rigid ones (None), also of two links each, or stiff beams."""
    line = np.column_stack([np.linspace(0.0, 1.0, 6), np.zeros((6, 2))])
    nodes = np.vstack([line, [[0.1, 0.2, 0.05], [0.9, 0.25, -0.1], [-0.1, 0.05, 0.2]]])
    beams, sections = [(k, k + 1) for k in range(5)], [tube()] * 5
    given: dict[str, Any] = {"links": [RigidLink(8, [6]), RigidLink(0, [8]), RigidLink(5, [7])]}
    if not through:
        nodes, given["links"] = nodes[:8], [RigidLink(0, [6]), RigidLink(5, [7])]
    if stiffer is not None:
        beams, sections, given = [*beams, (0, 6), (5, 7)], [*sections, *[tube(stiffer, 1e-3)] * 2], {}
    given |= {"cables": [(6, 7)], "cable": ROPE, "cable_tension": PULL, "prestress_mode": "equilibrium"}
    masses = [PointMass(6, 0.05), PointMass(7, 0.1)]
    return tf.Model.from_mesh(nodes, beams=beams, beam=sections, masses=masses, **given)


def clamped_bow() -> tf.PrestressedState:
    free = bow()
    held = (Support.clamped([2]),)
    return tf.solve_prestress(
        tf.Model(free.nodes, free.groups, held, "equilibrium", masses=free.masses, links=free.links)
    )


def test_pendulum_under_tension(verification_row: Any) -> None:
    """Mass at the end of a hinged arm, pulled along it: w² = T (1/arm + 1/cable)/m, both ways."""
    arm, length, mass = 0.4, 1.5, 0.3
    nodes = np.array([[0.0, 0.0, 0.0], [arm, 0.0, 0.0], [arm + length, 0.0, 0.0]])
    model = tf.Model.from_mesh(
        nodes,
        cables=[(1, 2)],
        cable=NO_WEIGHT,
        cable_tension=PULL,
        masses=[PointMass(1, mass, 1e-9)],
        links=[RigidLink(0, [1])],
        supports=[Support.pinned([0, 2])],
        springs=[Spring((0,), (0.0, 0.0, 0.0, 1.0, 0.0, 0.0))],
        prestress_mode="equilibrium",
    )
    exact = np.sqrt(PULL * (1.0 / arm + 1.0 / length) / mass) / (2.0 * np.pi)
    found = tf.solve_modes(tf.solve_prestress(model), n=2).frequencies
    assert found == pytest.approx([exact, exact], rel=1e-7)
    verification_row("mass on a hinged rigid arm under tension: frequency [Hz]", exact, found[0], "T (1/a + 1/l)/m")


@pytest.mark.parametrize("through", [False, True])
def test_free_bow_has_six_free_motions_and_that_of_stiff_arms(through: bool, verification_row: Any) -> None:
    state = tf.solve_prestress(bow(through=through))
    assert not state.warnings
    found = tf.solve_modes(state, n=10).frequencies
    assert np.abs(found[:6]).max() < 1e-3
    # Twice as stiff arms leave half of the difference.
    soft, stiff = (tf.solve_modes(tf.solve_prestress(bow(k)), n=10).frequencies[6:] for k in (60.0, 120.0))
    limit = 2.0 * stiff - soft
    assert found[6:] == pytest.approx(limit, rel=1e-4)
    verification_row(
        f"free bow on rigid arms{' in two parts' * through}: largest of six rigid motions [Hz]",
        0,
        float(np.abs(found[:6]).max()),
        "invariance",
    )
    if not through:
        verification_row("free bow on rigid arms: first bending [Hz]", limit[0], found[6], "arms as stiff beams")


def test_arms_follow_any_small_turn_to_third_order() -> None:
    """Energy of the bow turned as a whole: what the second order leaves is of the fourth, and of third order forces."""
    state = tf.solve_prestress(bow())
    model, motions = state.model, state.model.rigid_motions
    energies = []
    for size in (0.02, 0.01):
        turn = size * np.array([0.5, -0.7, 0.4])
        q = motions[:, 3:] @ turn
        places = model.translation_dofs
        q[places] += 0.5 * np.cross(turn, np.cross(turn, model.nodes))
        energies.append(abs(state.system.force(q[model.free_dofs])[1]))
    assert energies[0] < 1e-2 * PULL * 0.02**2
    assert 6.0 < energies[0] / energies[1] < 20.0


@pytest.mark.parametrize("how", ["link", "offset"])
def test_blade_on_hinges_in_spin(how: str, verification_row: Any) -> None:
    """Blade of a rotor at e from the axis, c long: lag by m W² e c, flap by m W² (e + c) c, beside its spring."""
    e, c, spin, spring, inertia, mass = 2.0, 0.5, 1.3, 0.8, 1e-2, 2.0
    nodes = np.array([[e, 0.0, 0.0], [e + c, 0.0, 0.0], [e, 1.0, 0.0], [e, 0.5, 0.0]])
    body = PointMass(1, mass, inertia) if how == "link" else PointMass(0, mass, inertia, (c, 0.0, 0.0))
    model = tf.Model.from_mesh(
        nodes,
        cables=[(0, 3), (3, 2)],
        cable=tf.CableSection(tf.Material(1e9, 1e3), 1e-6),
        cable_tension=10.0,
        links=[RigidLink(0, [1])],
        masses=[body],
        supports=[Support.pinned([0, 2])],
        springs=[Spring((0,), (0.0, 0.0, 0.0, 1e6, spring, spring))],
        prestress_mode="uniform",
    )
    state = tf.solve_prestress(model)
    assert not state.warnings
    found = 2.0 * np.pi * tf.solve_spinning_modes(state, (0.0, 0.0, spin), n=2).frequencies
    about = mass * c**2 + inertia
    exact = np.sqrt([(spring + mass * spin**2 * arm * c) / about for arm in (e, e + c)])
    assert found == pytest.approx(exact, rel=1e-8)
    for name, one, other in zip(("lag", "flap"), exact, found, strict=True):
        verification_row(f"blade on hinges, {how}: {name} [rad/s]", one, other, "m W² e c")


def test_free_tumble_keeps_momentum_and_energy(verification_row: Any) -> None:
    """The bow on a hub of a gram, thrown into a tumble."""
    state = clamped_bow()
    hub = tf.FreeHub(1e-3, (1e-4, 1e-4, 1e-4), center=(0.5, 0.0, 0.0), angular_velocity=(0.9, 0.4, -0.6))
    run = tf.simulate(state, hub, method=tf.EnergyConserving(), time_step=1e-3, end_time=0.2, tolerance=1e-10)
    balance = run.energy_balance
    assert abs(balance["residual"]) < 1e-8 * balance["initial"]
    verification_row("tumbling bow: energy balance", 0, abs(balance["residual"]) / balance["initial"], "energy")


def test_reduced_bow_in_spin_is_the_full_one() -> None:
    """Second orders of arms and bodies are in the polynomial and in the moments of a reduced model too."""
    state = clamped_bow()
    rom = tf.reduce(state, tf.ModalBasis(directions=("x", "y", "z", "rx", "ry", "rz"), count=20))
    given = {"time_step": 1e-3, "end_time": 5e-3, "probes": {"tip": state.model.nodes[7]}}
    spun = tf.Stop(4.0, 1.0, axis=(0.0, 0.0, 1.0))
    full, small = (tf.simulate(one, spun, **given).data for one in (state, rom))
    for name in ("u", "v", "w"):
        scale = float(np.abs(full[name]).max())
        assert np.abs(full[name].values - small[name].values).max() < 2e-3 * scale
