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


def taut_frame(strain: str, *supports: Support) -> tf.Model:
    """Square frame that carries a taut film by its corners on arms and by cables, with bodies on both."""
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    ring = np.vstack([np.linspace(corners[k], corners[k - 3], 4, endpoint=False) for k in range(4)])
    inner = np.linspace(-0.8, 0.8, 4)
    film = np.array([(x, y, 0.0) for x in inner for y in inner])
    first = [16 + 4 * i + j for i in range(3) for j in range(3)]
    cables = [(1, 20), (2, 24), (5, 29), (6, 30), (9, 27), (10, 23), (13, 18), (14, 17)]
    turn = np.arange(16)
    return tf.Model.from_mesh(
        np.vstack([ring, film]),
        triangles=[t for k in first for t in ((k, k + 4, k + 5), (k, k + 5, k + 1))],
        membrane=tf.MembraneSection(tf.Material(3e9, 1500.0, 0.3), 5e-5, strain="green-lagrange"),
        membrane_stress=(5e4, 5e4, 0.0),
        beams=np.column_stack([turn, np.roll(turn, -1)]),
        beam=tf.BeamSection(tf.Material(7e10, 2700.0, 0.33), 1e-4, 8.33e-10, 8.33e-10, 1.4e-9, strain=strain),
        cables=cables,
        cable=ROPE,
        cable_tension=3.0,
        masses=[PointMass(2, 0.3, 0.01, (0.0, 0.0, 0.1)), PointMass(28, 0.05)],
        links=[RigidLink(corner, [end]) for corner, end in zip((0, 4, 8, 12), (16, 28, 31, 19), strict=True)],
        supports=supports,
        prestress_mode="equilibrium",
    )


@pytest.mark.parametrize("strain", ["green-lagrange", "corotational"])
def test_free_frame_with_a_film_on_arms(strain: str, verification_row: Any) -> None:
    """Six free motions, and mass and inertia by hand but for what the beams' sections have."""
    # Corners of the film between arms are compressed, which matters to no rigid motion.
    state = tf.solve_prestress(taut_frame(strain), check=False)
    assert not any("links" in text for text in state.warnings)
    motions = state.model.rigid_motions[state.model.free_dofs]
    found = motions.T @ (state.system.inertia.mass_matrix @ motions)
    film, tube, rope = 1500.0 * 5e-5 * 1.6**2, 0.27, 1.5e-3
    cables = rope * float(np.linalg.norm(np.diff(state.model.nodes[state.model.cables], axis=1)[:, 0], axis=1).sum())
    assert found[0, 0] == pytest.approx(film + 8.0 * tube + 0.35 + cables, rel=1e-12)
    across = film * 1.6**2 / 6.0 + 8.0 * tube * 4.0 / 3.0
    bodies = 0.01 + 0.3 * float(np.sum(state.model.nodes[2, :2] ** 2)) + 0.05 * 2.0 * 0.8**2
    ends = state.model.nodes[state.model.cables]
    middle, span = ends.mean(axis=1), ends[:, 1] - ends[:, 0]
    lines = rope * np.sum(np.linalg.norm(span, axis=1) * (np.sum(middle**2, axis=1) + np.sum(span**2, axis=1) / 12.0))
    assert found[5, 5] == pytest.approx(across + bodies + lines, rel=2e-5)
    frequencies = np.abs(tf.solve_modes(state, n=7).frequencies)
    assert frequencies[:6].max() < 1e-3 < 1.0 < frequencies[6]
    verification_row(f"free {strain} frame, film on arms: rigid motions [Hz]", 0, frequencies[:6].max(), "invariance")


@pytest.mark.parametrize("structure", ["bow", "frame"])
def test_free_tumble_keeps_momentum_and_energy(structure: str, verification_row: Any) -> None:
    """On a hub of grams, thrown into a tumble."""
    held = Support.clamped([0])
    state = clamped_bow() if structure == "bow" else tf.solve_prestress(taut_frame("corotational", held), check=False)
    center = tuple(state.model.nodes[2 if structure == "bow" else 0].tolist())
    hub = tf.FreeHub(1e-2, (1e-3, 1e-3, 1e-3), center=center, angular_velocity=(0.9, 0.4, -0.6))
    run = tf.simulate(state, hub, method=tf.EnergyConserving(), time_step=2e-3, end_time=0.1, tolerance=1e-10)
    balance = run.energy_balance
    assert abs(balance["residual"]) < 1e-9 * balance["initial"]
    for name in ("linear_momentum", "angular_momentum"):
        momentum = run.data[name].values
        assert np.abs(momentum - momentum[0]).max() < 1e-12 * np.abs(momentum).max()
    error = abs(balance["residual"]) / balance["initial"]
    verification_row(f"tumbling {structure} with arms: energy balance", 0, error, "energy")


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
