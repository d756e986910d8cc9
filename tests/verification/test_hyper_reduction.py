"""Hyper-reduced models: weighted elements on a basis against the full structure, wrinkled film included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import BasisVectors, HyperReducedModel, Rayleigh, membrane_states, solve_modes
from tautflex.reduction.bases.vectors import ritz
from tautflex.reduction.hyper.blocks import basis_blocks
from tautflex.reduction.hyper.weights import ElementWeights, element_forces, train_weights
from tautflex.reduction.marching.dispatch import internal_force, tangent
from tautflex.reduction.polynomial.forces import energies
from verification.dynamic_cases import small_antenna, soft_film

pytestmark = pytest.mark.slow  # compiles for most of a minute
STOP = tf.Stop(rate=0.6, duration=0.1)


def wrinkling(model):
    """The same structure with a film that cannot be compressed."""
    groups = tuple(
        replace(group, section=replace(group.section, law="tension-field"))
        if group.section.kind == "membrane"
        else group
        for group in model.groups
    )
    return tf.solve_prestress(replace(model, groups=groups))


def all_elements(state, vectors):
    """Hyper-reduced model that left no element out."""
    basis = BasisVectors(vectors, np.zeros((0, state.system.size)), np.ones(len(vectors)), "given")
    blocks = tuple(basis_blocks(state.system, vectors))
    return HyperReducedModel(state, basis, blocks, ElementWeights(np.ones(count(blocks)), 0.0), 0.0)


def count(blocks):
    return sum(len(block.measure) for block in blocks)


def mixed_vectors(state, modes=6):
    """A few modes and random vectors: nothing about them is special."""
    rng = np.random.default_rng(0)
    return ritz(state, np.concatenate([solve_modes(state, modes).vectors, rng.standard_normal((3, state.system.size))]))


def force_at(arrays, eta):
    force = np.empty(len(eta))
    internal_force(arrays, eta, np.zeros(len(eta)), np.zeros(0), force)
    return force


def test_dampers_of_the_structure():
    """All elements on natural modes, small motion: a damper does the same to the hyper-reduced as to the full model."""
    bare = small_antenna((6, 4))
    node = int(np.linalg.norm(bare.nodes - [0.3, 0.1, 0.0], axis=1).argmin())
    runs = []
    for dampers in ((), (tf.Damper((node,), (0.0, 0.0, 0.5)),)):
        state = tf.solve_prestress(replace(bare, dampers=dampers))
        rom = all_elements(state, solve_modes(state, 40).vectors)
        given = {"time_step": 1e-3, "end_time": 0.3, "probes": {"A": (0.3, 0.1)}, "method": tf.Newmark()}
        runs.append([tf.simulate(plant, tf.SpinUp(6e-4, 0.1), **given).data.w.values[:, 0] for plant in (state, rom)])
    scale = np.abs(runs[0][0]).max()
    changes = [damped - free for free, damped in zip(*runs, strict=True)]
    assert np.abs(changes[0]).max() > 0.05 * scale
    assert changes[1] == pytest.approx(changes[0], abs=0.03 * np.abs(changes[0]).max())


@pytest.fixture(scope="module")
def antenna():
    """Small antenna of one quarter of the paper's M2 tension: it wrinkles."""
    return wrinkling(small_antenna((6, 4), scale=0.1))


@pytest.fixture(scope="module")
def training(antenna):
    """Stop that wrinkles the film, with all fields."""
    return tf.simulate(
        antenna, STOP, time_step=2.5e-3, end_time=1.5, damping=Rayleigh(1e-3, 1e-3), probes={"A": (0.7, 0.4)},
        every=2, fields="all",
    )  # fmt: skip


def test_all_elements_give_the_projected_force(antenna, verification_row):
    rom = all_elements(antenna, mixed_vectors(antenna))
    eta = 2e-4 * np.random.default_rng(1).standard_normal(rom.size)
    q = eta @ rom.basis.kept
    states = membrane_states(antenna, q)
    assert {0, 1} <= set(states.tolist()), "the state must mix taut and wrinkled film"
    full, energy = antenna.system.force(q)
    expected = rom.basis.kept @ (full - antenna.reference_force)
    arrays = rom.arrays(Rayleigh())
    error = np.abs(force_at(arrays, eta) - expected).max() / np.abs(expected).max()
    verification_row("hyper-reduced antenna with all elements, wrinkled: force", 0.0, error, "round-off")
    assert error < 1e-12
    strain = energies(arrays, eta[None], np.zeros((1, rom.size)))[0, 1]
    assert strain == pytest.approx(energy - antenna.reference_force @ q, rel=1e-12)


def test_force_is_the_gradient_of_the_energy_and_the_tangent_its_derivative(antenna):
    rom = all_elements(antenna, mixed_vectors(antenna))
    arrays, eta = rom.arrays(Rayleigh()), 2e-4 * np.random.default_rng(2).standard_normal(rom.size)
    assert np.any(membrane_states(antenna, eta @ rom.basis.kept) > 0)
    still, step = np.zeros((1, rom.size)), 1e-9
    force, matrix = force_at(arrays, eta), tangent(arrays, eta, np.zeros(0))
    for move in step * np.eye(rom.size):
        ahead, behind = (energies(arrays, eta[None] + sign * move, still)[0, 1] for sign in (1.0, -1.0))
        assert (ahead - behind) / (2 * step) == pytest.approx(force @ move / step, abs=1e-5 * np.abs(force).max())
        slope = (force_at(arrays, eta + move) - force_at(arrays, eta - move)) / (2 * step)
        assert np.abs(slope - matrix @ move / step).max() < 1e-5 * np.abs(matrix).max()


def test_at_rest_it_has_the_stiffness_of_the_reference(antenna):
    rom = all_elements(antenna, mixed_vectors(antenna))
    matrix, linear = tangent(rom.arrays(Rayleigh()), np.zeros(rom.size), np.zeros(0)), rom.coefficients.linear
    assert np.abs(matrix - linear).max() < 1e-10 * np.abs(linear).max()
    assert np.abs(rom.coefficients.mass - np.eye(rom.size)).max() < 1e-10


def test_elastic_elements_are_the_polynomial(verification_row):
    state = tf.solve_prestress(small_antenna((6, 4), scale=0.1))

    class Given(tf.Basis):
        def vectors(self, state):
            return BasisVectors(vectors, np.zeros((0, state.system.size)), np.ones(len(vectors)), "given")

    vectors = mixed_vectors(state)
    hyper, polynomial = all_elements(state, vectors), tf.reduce(state, Given())
    eta = 2e-4 * np.random.default_rng(3).standard_normal(hyper.size)
    y_size = len(polynomial.arrays(Rayleigh()).first)
    expected = np.empty(hyper.size)
    internal_force(polynomial.arrays(Rayleigh()), eta, 0.0 * eta, np.zeros(y_size), expected)
    error = np.abs(force_at(hyper.arrays(Rayleigh()), eta) - expected).max() / np.abs(expected).max()
    verification_row(
        "hyper-reduced elastic antenna against the polynomial model: force", 0.0, error, "weak stress fields"
    )
    # The polynomial drops stress fields below 1e-5 of the strongest one's energy.
    assert error < 1e-4


@pytest.mark.parametrize(
    "method",
    [tf.WilsonTheta(), tf.GeneralizedAlpha(0.6), tf.EnergyConserving(), tf.CentralDifference()],
    ids=lambda method: method.name,
)
def test_a_complete_basis_with_all_elements_is_the_full_model(method, verification_row):
    film = soft_film()
    state = wrinkling(film.model)
    rom = all_elements(state, ritz(state, np.eye(state.system.size)))
    options = {
        "time_step": 2e-3,
        "end_time": 0.6,
        "damping": Rayleigh(0.3, 1e-3),
        "method": method,
        "probes": {"A": (0.25, 0.1)},
        "initial_velocity": lambda x, y: 8.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x),
    }
    tight = {} if isinstance(method, tf.CentralDifference) else {"tolerance": 1e-11}
    maneuver = tf.Stop(rate=3.0, duration=0.1507, axis=(0.6, 0.8, 0.0), origin=(0.1, 0.0, 0.0))
    full, reduced = (tf.simulate(plant, maneuver, **options, **tight).data for plant in (state, rom))
    assert float(full.wrinkled_fraction.max()) > 0.1
    for name in ("u", "v", "w", "w_velocity", "kinetic_energy", "strain_energy"):
        error = float(np.abs(full[name] - reduced[name]).max() / np.abs(full[name]).max())
        assert error < 1e-6, name
    error = float(np.abs(full.w - reduced.w).max() / np.abs(full.w).max())
    verification_row(f"hyper-reduced model, complete, wrinkled, {method.name}: w against the full", 0.0, error, "exact")
    checked = np.isfinite(reduced.wrinkled_fraction)
    assert np.allclose(reduced.wrinkled_fraction[checked], full.wrinkled_fraction[checked])


def test_trained_weights_reproduce_the_forces(antenna, training):
    rom = tf.hyper_reduce(antenna, training.data, transverse=8, in_plane=10, tolerance=1e-2)
    weights = rom.weights
    assert np.all(weights.values >= 0.0)
    assert weights.chosen < 0.7 * len(weights.values)
    assert 0.0 < weights.residual <= 1e-2
    finer = tf.hyper_reduce(antenna, training.data, transverse=8, in_plane=10, tolerance=1e-3)
    assert finer.weights.chosen > weights.chosen
    assert finer.weights.residual <= 1e-3
    # A quadrature of the film's area, though nobody asked for that.
    area = sum(block.measure.sum() for block in rom.blocks if block.kind == "membrane")
    assert area == pytest.approx(2.0 * 1.0 * 1e-4, rel=0.15)


def test_weights_of_equal_elements_are_found():
    """Ten equal elements and one that does nothing: one of the ten stands for all."""
    rng = np.random.default_rng(4)
    forces = np.repeat(rng.standard_normal((5, 1, 3)), 11, axis=1)
    forces[:, 10] = 0.0
    weights = train_weights(forces, np.ones(3), 1e-6)
    assert weights.chosen == 1
    assert weights.values.sum() == pytest.approx(10.0)
    assert weights.residual < 1e-9


def test_element_forces_add_up_to_the_projected_force(antenna):
    vectors = mixed_vectors(antenna)
    eta = 2e-4 * np.random.default_rng(5).standard_normal((2, len(vectors)))
    parts = element_forces(basis_blocks(antenna.system, vectors), eta)
    full = np.array([antenna.system.force(row @ vectors)[0] - antenna.reference_force for row in eta])
    assert np.allclose(parts.sum(axis=1), full @ vectors.T, rtol=0.0, atol=1e-12 * np.abs(parts).max())


def test_training_run_and_another_are_met(antenna, training, verification_row):
    rom = tf.hyper_reduce(antenna, training.data, tolerance=5e-3)
    assert rom.weights.chosen < len(rom.weights.values)
    options = {"time_step": 2.5e-3, "end_time": 1.5, "damping": Rayleigh(1e-3, 1e-3), "probes": {"A": (0.7, 0.4)}}
    for name, maneuver in (("trained", STOP), ("weaker, longer", tf.Stop(rate=0.4, duration=0.3))):
        full = tf.simulate(antenna, maneuver, **options).data
        run = tf.simulate(rom, maneuver, **options)
        assert float(full.wrinkled_fraction.max()) > 0.1
        error = float(tf.amplitude(run.data.w.sel(probe="A")) / tf.amplitude(full.w.sel(probe="A")) - 1.0)
        verification_row(f"hyper-reduced small antenna, {name}: amplitude at A / full - 1", 0.0, error, "full model")
        assert abs(error) < 0.02
        assert run.stats.halvings == 0


def test_bad_input_says_what_to_do(antenna, training):
    with pytest.raises(tf.InputError, match="data: expected a Dataset"):
        tf.hyper_reduce(antenna, antenna)
    with pytest.raises(tf.InputError, match="data: expected at least one run"):
        tf.hyper_reduce(antenna, [])
    bare = tf.simulate(antenna, STOP, time_step=0.01, end_time=0.02)
    with pytest.raises(tf.InputError, match=r"at least two stored fields, got 0; simulate with fields='all'"):
        tf.hyper_reduce(antenna, bare.data)
    other = wrinkling(small_antenna((4, 2), scale=0.1))
    with pytest.raises(tf.InputError, match="use a run of the same mesh"):
        tf.hyper_reduce(other, training.data)
    with pytest.raises(tf.InputError, match=r"transverse: expected at most \d+ vectors.*store more fields"):
        tf.hyper_reduce(antenna, training.data, transverse=1000)
    with pytest.raises(tf.InputError, match="tolerance"):
        tf.hyper_reduce(antenna, training.data, tolerance=2.0)
    with pytest.raises(tf.InputError, match="training_states"):
        tf.hyper_reduce(antenna, training.data, training_states=1)
