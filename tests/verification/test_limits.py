"""How far the formulation reaches: hardening of a film at large amplitude, and finite rotations of a beam."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.structure.antenna import AntennaLayout, build_fixed_film

A, B, THICKNESS, STRESS = 2.0, 1.0, 1e-4, 4e3
FILM = tf.Material(3.5e9, 1530.0, 0.34)


def duffing_coefficient() -> float:
    """gamma of w'' + w0^2 w + gamma w^3 = 0 for one (1,1) half-wave, edges immovable on average [Chobotov & Binder]."""
    nu, sides = FILM.poisson_ratio, 1 / A**4 + 1 / B**4
    stretch = (sides + 2 * nu / (A * B) ** 2) / (8 * (1 - nu**2)) + sides / 16
    return np.pi**4 * FILM.youngs_modulus / FILM.density * stretch


@pytest.mark.parametrize("amplitude", [2e-4, 1e-3])
def test_film_hardens_like_a_duffing_oscillator(amplitude, verification_row):
    """Frequency of free vibration against sqrt(1 + 3/4 gamma A^2 / w0^2); the formula holds edges on average only."""
    layout = AntennaLayout(A, B, (16, 8), "alternating")
    state = tf.solve_prestress(build_fixed_film(layout, tf.MembraneSection(FILM, THICKNESS), (STRESS, STRESS, 0.0)))
    natural = 2 * np.pi * float(tf.solve_modes(state, 1).frequencies[0])
    gamma = duffing_coefficient()
    # Energy of the oscillator gives the velocity that leads to the amplitude.
    speed = np.sqrt(natural**2 * amplitude**2 + 0.5 * gamma * amplitude**4)
    data = tf.simulate(
        state,
        method=tf.Newmark(),
        time_step=1e-3,
        end_time=1.2,
        probes={"M": (0.0, 0.0)},
        initial_velocity=lambda x, y: speed * np.cos(np.pi * x / A) * np.cos(np.pi * y / B),
    ).data
    w, time = data.w[:, 0].values, data.time.values
    reached = float(np.abs(w[: w.size // 2]).max())
    after = np.flatnonzero((w[1:-1] > 0) & (w[2:] <= 0)) + 1
    crossing = time[after] + 1e-3 * w[after] / (w[after] - w[after + 1])
    found = np.pi / crossing[0] / natural
    exact = np.sqrt(1 + 0.75 * gamma * reached**2 / natural**2)
    assert found == pytest.approx(exact, rel=0.05)
    words = f"rectangular film, A = {1e3 * amplitude:g} mm: frequency over natural frequency"
    verification_row(words, exact, found, "Duffing, Chobotov & Binder type (edges immovable on average)")


def bent(angle: float) -> float:
    """Tip deflection over length of a cantilever under an end moment that should turn its tip by ``angle``."""
    length, elements = 10.0, 10
    section = tf.BeamSection(tf.Material(2e11, 7800.0, 0.3), 1e-3, 1e-7, 1e-7, 2e-7, "green-lagrange")
    nodes = np.column_stack([np.linspace(0.0, length, elements + 1), np.zeros((elements + 1, 2))])
    model = tf.Model.from_mesh(
        nodes,
        beams=np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        beam=section,
        supports=(tf.Support.clamped([0]),),
    )
    state = tf.solve_prestress(model)
    load = np.zeros(model.dof_count)
    load[model.dof_offset[elements] + 5] = -2e11 * 1e-7 / length * angle
    q = tf.solve_static(state, load[model.free_dofs])
    return float(state.system.translations(q)[elements, 1]) / length


def test_range_of_beam_rotations(verification_row):
    """Cantilever under an end moment bends to a circle; the error of our small-rotation strains shows their range."""
    for angle, limit in ((0.1, 0.002), (0.3, 0.02), (2 * np.pi, None)):
        exact = (1 - np.cos(angle)) / angle
        found = bent(angle)
        if limit is None:
            assert abs(found - exact) > 0.1  # a full circle needs a co-rotational frame: out of range
        else:
            assert found == pytest.approx(exact, rel=limit)
        name = "full circle, out of range" if limit is None else f"tip turned by {angle:g} rad"
        shown = (f"{exact:.3f}", f"{found:.3f}", "circle", f"{abs(found - exact):.2g} (abs)")
        verification_row(f"cantilever with end moment, {name}: tip deflection / L", *shown)


def curved_tip(load: float) -> np.ndarray:
    """Tip displacement of a cantilever bent to 45 degrees (radius 100, square section 1 x 1, E = 1e7, nu = 0)."""
    elements = 16
    angle = np.linspace(0.0, np.pi / 4, elements + 1)
    nodes = np.column_stack([100.0 * np.sin(angle), 100.0 * (1.0 - np.cos(angle)), np.zeros(elements + 1)])
    section = tf.BeamSection(tf.Material(1e7, 1.0), 1.0, 1 / 12, 1 / 12, 0.1406, "green-lagrange")
    model = tf.Model.from_mesh(
        nodes,
        beams=np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        beam=section,
        supports=(tf.Support.clamped([0]),),
    )
    state = tf.solve_prestress(model)
    force = np.zeros(model.dof_count)
    force[model.translation_dofs[elements, 2]] = -load
    return state.system.translations(tf.solve_static(state, force[model.free_dofs]))[elements]


def test_curved_cantilever(verification_row):
    """Bathe & Bolourchi 1979, 45-degree bend, load 600: out of range of small rotations; a small load is not."""
    small = curved_tip(0.6)
    # Castigliano: moments about the tangent (torsion) and the radius (bending) of a quarter of pi.
    phi = np.linspace(0.0, np.pi / 4, 20001)
    bending, torsion = 100.0 * np.sin(phi), 100.0 * (1.0 - np.cos(phi))
    compliance = np.trapezoid(bending**2 / (1e7 / 12) + torsion**2 / (0.5e7 * 0.1406), phi * 100.0)
    assert small[2] == pytest.approx(0.6 * compliance, rel=3e-3)
    verification_row("45-degree bend, load 0.6: tip rise", 0.6 * compliance, float(small[2]), "Castigliano")
    published = np.array([-13.4, -23.5, 53.4])
    found = curved_tip(600.0)
    gap = float(np.linalg.norm(found - published) / np.linalg.norm(published))
    assert gap > 0.1
    words = ", ".join(f"{value:.1f}" for value in found)
    verification_row(
        "45-degree bend, load 600: tip displacement (finite rotations, out of range)",
        "(-13.4, -23.5, 53.4)",
        f"({words})",
        "Bathe & Bolourchi 1979",
        error=f"{gap:.2f}",
    )
