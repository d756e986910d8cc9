"""Axes that turn with the structure: rotations of nodes, tangents in turned axes, and what they save."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import cross_matrix
from tautflex.solvers.transient.corotation import Corotation, rotation_operator
from tautflex.structure.mesh import rectangle_mesh

FILM = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4, "green-lagrange")
BEAM = tf.BeamSection(tf.Material(7e10, 2700.0, 0.3), 1e-4, 1e-8, 1e-8, 2e-8)


def sheet(divisions: tuple[int, int], held: str, beams: bool = False) -> tf.Model:
    """Film of 2 m x 1 m under 1 N/m, its edge held or free, with or without beams along one side."""
    nodes, triangles = rectangle_mesh(
        np.linspace(-1.0, 1.0, divisions[0] + 1), np.linspace(-0.5, 0.5, divisions[1] + 1)
    )
    edge = np.flatnonzero((np.abs(nodes[:, 0]) > 0.999) | (np.abs(nodes[:, 1]) > 0.499))
    side = np.flatnonzero(nodes[:, 1] < -0.499)
    extra = {"beams": np.stack([side[:-1], side[1:]], axis=1), "beam": BEAM} if beams else {}
    supports = {"edge": [tf.Support.pinned(edge)], "side": [tf.Support.clamped(side[:1])]}[held]
    return tf.Model.from_mesh(
        nodes, triangles=triangles, membrane=FILM, membrane_stress=(1e4, 1e4, 0.0), supports=supports, **extra
    )


def test_a_rigid_rotation_is_found_exactly_in_any_direction():
    system = StructuralSystem.from_model(sheet((5, 4), "side", beams=True))
    model, angle = system.model, np.array([0.02, -0.03, 0.05])
    full = np.zeros(model.dof_count)
    full[model.translation_dofs] = (model.nodes - model.nodes[0]) @ cross_matrix(angle).T
    nodes = np.arange(1, len(model.nodes))
    found = rotation_operator(system, nodes) @ full[model.free_dofs]
    np.testing.assert_allclose(found.reshape(-1, 3), np.tile(angle, (len(nodes), 1)), atol=1e-14)


def test_a_straight_cable_says_nothing_about_its_twist():
    nodes = np.stack([np.linspace(0.0, 1.0, 6), np.zeros(6), np.zeros(6)], axis=1)
    cable = tf.CableSection(tf.Material(1e11, 1600.0), 1e-3)
    pairs = np.stack([np.arange(5), np.arange(1, 6)], axis=1)
    model = tf.Model.from_mesh(
        nodes, cables=pairs, cable=cable, cable_tension=10.0, supports=[tf.Support.pinned([0, 5])]
    )
    operator = rotation_operator(StructuralSystem.from_model(model), np.arange(1, 5)).toarray()
    rotation = (operator @ np.ravel([(0.0, 0.1 * x, 0.3 * x) for x in nodes[1:5, 0]])).reshape(-1, 3)
    np.testing.assert_allclose(rotation[:, 0], 0.0, atol=1e-14)
    np.testing.assert_allclose(rotation[:3, 1:], [(-0.3, 0.1)] * 3, atol=1e-14)


@pytest.mark.parametrize("held", ["edge", "side"])
def test_going_out_of_the_axes_is_the_transpose_of_going_into_them(held):
    system = StructuralSystem.from_model(sheet((5, 4), held, beams=held == "side"))
    random = np.random.default_rng(1)
    axes = Corotation(system)
    axes.follow(0.01 * random.standard_normal(system.size))
    force, step = random.standard_normal((2, system.size))
    assert axes.into(force) @ step == pytest.approx(force @ axes.out_of(step.copy()), rel=1e-12)
    axes.restart(np.ones(system.size))
    np.testing.assert_array_equal(axes.into(force), force)


def test_in_turned_axes_the_tangent_of_a_rotated_sheet_is_that_of_the_reference():
    """K(rotated) - Q K Q' falls with the square of the angle; without Q it falls with the angle itself."""
    system = StructuralSystem.from_model(sheet((4, 3), "side"))
    model = system.model
    reference = system.matrix(system.tangent(np.zeros(system.size))).toarray()
    axes, errors = Corotation(system), []
    for angle in (0.02, 0.01):
        turn = np.array([0.0, angle, 0.0])
        rotation = np.eye(3) + np.sin(angle) * cross_matrix(turn / angle)
        rotation += (1.0 - np.cos(angle)) * cross_matrix(turn / angle) @ cross_matrix(turn / angle)
        full = np.zeros(model.dof_count)
        full[model.translation_dofs] = (model.nodes - model.nodes[0]) @ (rotation - np.eye(3)).T
        q = full[model.free_dofs]
        now = system.matrix(system.tangent(q)).toarray()
        axes.follow(q)
        turned = np.array(
            [axes.out_of(row) for row in np.array([axes.into(row) for row in np.eye(len(now))]) @ reference]
        )
        errors.append([np.linalg.norm(now - other) / np.linalg.norm(reference) for other in (turned, reference)])
    (large, plain_large), (small, plain_small) = errors
    assert large < 1e-2 * plain_large
    assert np.log2(large / small) > 1.95
    assert np.log2(plain_large / plain_small) == pytest.approx(1.0, abs=0.05)


class _Still(Corotation):
    """Axes that do not turn."""

    def follow(self, q, share=1.0):
        pass


@pytest.mark.parametrize("beta", [0.0, 0.001])
def test_turned_tangents_serve_longer_and_do_not_change_the_motion(monkeypatch, beta):
    model = sheet((20, 10), "edge")
    state = tf.solve_prestress(model)
    x, y = model.nodes[:, 0] / 2.0, model.nodes[:, 1]
    velocity = np.zeros_like(model.nodes)
    velocity[:, 2] = 0.15 * np.cos(np.pi * x) * np.cos(np.pi * y) + 0.05 * np.sin(2.0 * np.pi * x) * np.cos(np.pi * y)
    options = {
        "method": tf.Newmark(),
        "time_step": 1e-3,
        "end_time": 0.15,
        "initial_velocity": velocity,
        "tolerance": 1e-9,
        "probes": {"A": (0.4, 0.2)},
        "damping": tf.Rayleigh(0.0, beta),
    }
    # Step by step: the axes of a stretch cannot be held.
    monkeypatch.setattr("tautflex.solvers.transient.march.stretch.March.serves", staticmethod(lambda *_: False))
    turned = tf.simulate(state, **options)
    monkeypatch.setattr("tautflex.solvers.transient.implicit.Corotation", _Still)
    still = tf.simulate(state, **options)
    np.testing.assert_allclose(turned.data.w, still.data.w, atol=1e-7 * float(np.abs(still.data.w).max()))
    work = [run.stats.iterations + 9 * run.stats.factorizations for run in (turned, still)]
    assert work[0] < (0.85 if beta == 0.0 else 1.0) * work[1]
