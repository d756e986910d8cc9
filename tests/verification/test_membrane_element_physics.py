"""Everything that runs on a film runs on triangle6 and quad4: statics, motion, wrinkles, reduction, batches."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import BasisVectors, BeamSection, CableSection, HyperReducedModel, MembraneSection, Model, Rayleigh
from tautflex.reduction.bases.vectors import ritz
from tautflex.reduction.hyper.blocks import basis_blocks, chosen_blocks
from tautflex.reduction.hyper.forces import element_force
from tautflex.reduction.hyper.weights import ElementWeights
from tautflex.reduction.polynomial.forces import slopes
from tautflex.reduction.polynomial.monomials import monomials
from tautflex.structure.antenna import AntennaLayout, build_antenna
from verification.builders import CABLE, FILM, FRAME, THICKNESS
from verification.test_membrane_elements import ELEMENTS, fixed_film

STOP = tf.Stop(rate=0.6, duration=0.04)


def throw(x, y):
    """Velocity of all shapes [m/s]."""
    return 0.5 * np.cos(np.pi * x / 2.0) * np.cos(np.pi * y) * (1.0 + x)


def blow(x, y):
    """Velocity of the (1, 1) and the (2, 1) shape [m/s]."""
    return 0.15 * (np.cos(np.pi * x / 2.0) + np.sin(np.pi * x) / 3.0) * np.cos(np.pi * y)


def antenna(element: str, *, law: str = "elastic", scale: float = 1.0, cells: tuple[int, int] = (4, 2)) -> Model:
    """Coarse version of the paper's antenna with tensions in balance."""
    ends = [n + 1 if element == "quad4" else 2 * n + 1 for n in cells]  # a cable at every node of an edge
    layout = AntennaLayout(2.0, 1.0, cells, "regular", 2.5, 1.5, *ends, element=element)
    return build_antenna(
        layout,
        MembraneSection(FILM, THICKNESS, law=law),
        CableSection(CABLE, 3.14e-6),
        BeamSection(FRAME, 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=0.295 * scale,
        pretension_y=0.5 * scale,
        prestress_mode="equilibrium",
    )


@pytest.mark.parametrize("element", ELEMENTS)
def test_film_answers_given_tensions(element, verification_row):
    """Tensioning: an exact balance, and the mean resultant that the cables ask for."""
    state = tf.solve_prestress(antenna(element, cells=(8, 4)), check=False)
    assert state.relative_residual < 1e-10
    rows = next(block for block in state.system.blocks if block.kind == "membrane")
    area, stress = rows.measure / rows.size, state.membrane_stress
    # Virial theorem of the film: int N dA = sum of boundary force times position, by the cables' pull.
    pull = np.zeros((3, 3))
    film = np.unique(np.concatenate([group.connectivity.ravel() for group in state.model.surfaces]))
    for cable, tension in zip(state.model.cables, state.cable_tension, strict=True):
        at, away = cable if np.isin(cable[0], film) else cable[::-1]
        span = state.model.nodes[away] - state.model.nodes[at]
        pull += tension * np.outer(state.model.nodes[at], span / np.linalg.norm(span))
    mean = np.einsum("n,n,nc->c", area, rows.size, stress)
    worst = float(np.abs(mean - [pull[0, 0], pull[1, 1], pull[0, 1]]).max() / np.abs(pull).max())
    assert worst < 1e-9
    verification_row(
        f"{element}, tensioned film: integral of its resultants less the cables' virial", 0, worst, "virial"
    )


@pytest.mark.parametrize("element", ELEMENTS)
def test_energy_is_conserved_far_from_the_reference(element, verification_row):
    for law in ("elastic", "tension-field"):
        state = tf.solve_prestress(fixed_film(element, (4, 2), "green-lagrange", law))
        options = {"time_step": 1e-3, "end_time": 0.2, "initial_velocity": throw, "tolerance": 1e-9}
        run = tf.simulate(state, method=tf.EnergyConserving(), **options)
        energy = (run.data.kinetic_energy + run.data.strain_energy).values
        drift = float(np.abs(energy / energy[0] - 1.0).max())
        assert run.data.strain_energy.max() > 0.5 * energy[0]
        assert drift < 1e-9
        verification_row(f"{element}, {law}, energy-conserving: drift of the energy", 0.0, drift, "conservation")


def random_basis(state: tf.PrestressedState) -> BasisVectors:
    vectors = ritz(state, np.random.default_rng(0).standard_normal((5, state.system.size)))
    return BasisVectors(vectors, np.zeros((0, state.system.size)), np.ones(len(vectors)), "given")


class Given(tf.Basis):
    """Basis as it is."""

    def vectors(self, state: tf.PrestressedState) -> BasisVectors:
        return random_basis(state)


@pytest.mark.parametrize("element", ELEMENTS)
def test_polynomial_is_the_projected_force(element, verification_row):
    state = tf.solve_prestress(antenna(element), check=False)
    rom = tf.reduce(state, Given())
    eta = 1e-3 * np.random.default_rng(1).standard_normal(rom.size)
    expected = rom.basis.kept @ (state.system.force(eta @ rom.basis.kept)[0] - state.reference_force)
    c, slope, y = rom.coefficients, slopes(rom.arrays(Rayleigh()), eta), monomials(eta)
    exact = c.linear @ eta + c.quadratic @ y + slope.T @ (0.25 * c.cubic @ y)
    error = float(np.abs(exact - expected).max() / np.abs(expected).max())
    assert error < 1e-12
    verification_row(f"reduced polynomial, {element}: force against the kernel", 0.0, error, "round-off")


@pytest.mark.parametrize("element", ELEMENTS)
def test_hyper_reduction_weighs_points(element, verification_row):
    """All points with weight one give the projected force of a wrinkling film; doubling the weights doubles it."""
    state = tf.solve_prestress(fixed_film(element, (4, 2), law="tension-field"))
    basis = random_basis(state)
    blocks = basis_blocks(state.system, basis.kept)
    rows = sum(len(block.measure) for block in blocks)
    assert rows == len(state.membrane_stress)
    eta = 2e-3 * np.random.default_rng(1).standard_normal(len(basis.kept))
    assert np.any(tf.membrane_states(state, eta @ basis.kept) > 0)
    expected = basis.kept @ state.system.force(eta @ basis.kept)[0]
    force = {}
    for weight in (1.0, 2.0):
        chosen = tuple(chosen_blocks(blocks, np.full(rows, weight)))
        rom = HyperReducedModel(state, basis, chosen, ElementWeights(np.full(rows, weight), 0.0), 0.0)
        force[weight] = _hyper_force(rom, eta)
    error = float(np.abs(force[1.0] - expected).max() / np.abs(expected).max())
    assert error < 1e-11
    np.testing.assert_allclose(force[2.0], 2.0 * force[1.0], rtol=1e-12)
    verification_row(f"all points of a wrinkling film on a basis, {element}: force against the kernel", 0.0, error, "")


def _hyper_force(rom: HyperReducedModel, eta: np.ndarray) -> np.ndarray:
    """Internal force with that of the reference."""
    arrays, force = rom.arrays(Rayleigh()), np.empty(len(eta))
    element_force(arrays, eta, np.zeros(len(eta)), np.zeros(0), force)
    return force + arrays.reference


@pytest.mark.jax
def test_batch_is_the_single_run(verification_row):
    state = tf.solve_prestress(antenna("triangle6"), check=False)
    options = {"time_step": 2e-3, "end_time": 0.06, "probes": {"A": (0.6, 0.3)}, "tolerance": 1e-10}
    single = tf.simulate(state, STOP, damping=tf.Rayleigh(0.1, 1e-3), **options).data
    batch = tf.Batch(state).simulate({"damping.beta": [1e-3, 2e-3]}, STOP, damping=tf.Rayleigh(0.1, 1e-3), **options)
    error = float(np.abs(batch.w.isel(run=0) - single.w).max() / np.abs(single.w).max())
    assert error < 1e-8
    verification_row("batch of the full model, triangle6: w against the single run", 0.0, error, "single run")


@pytest.mark.slow
def test_large_amplitude_record_on_few_elements(verification_row):
    """Thrown to forty times its thickness: six-node triangles follow the converged record where linear ones do not."""
    record = {}
    for element, cells in (("triangle6", (30, 15)), ("triangle6", (20, 10)), ("triangle3", (40, 20))):
        state = tf.solve_prestress(fixed_film(element, cells, "green-lagrange"))
        options = {"time_step": 1e-3, "end_time": 2.0, "probes": {"P": (0.4, 0.2)}, "initial_velocity": blow}
        record[element, cells] = tf.simulate(state, method=tf.Newmark(), **options).data.w.values
    converged = record["triangle6", (30, 15)]
    errors = {key: float(np.linalg.norm(w - converged) / np.linalg.norm(converged)) for key, w in record.items()}
    assert np.abs(converged).max() > 35.0 * THICKNESS
    assert errors["triangle6", (20, 10)] < 0.05
    assert errors["triangle3", (40, 20)] > 0.1
    # At every instant of the first second; later small differences of phase have grown too far (docs/elements.md).
    early = np.abs(record["triangle6", (20, 10)] - converged)[:1001].max() / np.abs(converged).max()
    assert early < 0.05
    verification_row("film thrown to 40 thicknesses, triangle6 on 20x10: largest error of 1 s", "< 0.05", early, "same")
    for (element, cells), error in list(errors.items())[1:]:
        case = f"film thrown to 40 thicknesses, {element} on {cells[0]}x{cells[1]}: error of 2 s of record"
        bound = "< 0.05" if element == "triangle6" else "counter-example"
        verification_row(case, bound, error, "triangle6 on 30x15, same steps")
