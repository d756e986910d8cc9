"""Reduced models: exact polynomials, condensed static derivatives, parameters, stepping."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import Basis, BasisVectors, Coupling, Material, Rayleigh, TransientProblem, solve_modes, solve_static
from tautflex.motion.kinematics import fixed_axis_motion
from tautflex.reduction.bases.static_derivatives import add_static_derivatives
from tautflex.reduction.bases.vectors import ReferenceSolver, ritz
from tautflex.reduction.marching.frame_terms import frame_at
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.polynomial.condensation import Factors, assemble
from tautflex.reduction.polynomial.forces import derivative_forces, energies, internal_force, slopes, tangent
from tautflex.reduction.polynomial.monomials import monomial_rates, monomials
from tautflex.reduction.polynomial.projection import project
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from verification.dynamic_cases import SuddenSpin, small_antenna, soft_film, transverse_spin


def run_of(rom) -> ReducedRun:
    return ReducedRun(rom, TransientProblem(rom, method=tf.Newmark(), time_step=1.0, end_time=1.0))


@dataclass(frozen=True)
class Given(Basis):
    """A basis that is simply there."""

    basis: BasisVectors

    def vectors(self, state):
        return self.basis


def mixed_basis(state, count=6, derivatives=False, seed=0):
    """A few modes and random vectors: nothing about them is special."""
    rng = np.random.default_rng(seed)
    kept = ritz(state, np.concatenate([solve_modes(state, count).vectors, rng.standard_normal((2, state.system.size))]))
    none = np.zeros((0, state.system.size))
    if not derivatives:
        return BasisVectors(kept, none, np.ones(len(kept)), "test")
    return add_static_derivatives(
        state, ReferenceSolver(state), kept[:count], np.ones(count), ("rx",), "condensed", "test"
    )


def complete_basis(state, transverse_only=False):
    """Every motion the mesh can make (or every one along z), without static derivatives."""
    size = state.system.size
    unit = np.eye(size)
    if transverse_only:
        places = state.system.place[state.model.translation_dofs[:, 2]]
        unit = np.eye(size)[places[places < size]]
    kept = ritz(state, unit)
    return BasisVectors(kept, np.zeros((0, size)), np.ones(len(kept)), "complete")


def forces_of(rom, eta, rate=None, damping=None):
    arrays = rom.arrays(damping or Rayleigh())
    force = np.empty(rom.size)
    rate = np.zeros(rom.size) if rate is None else rate
    internal_force(arrays, eta, rate, np.zeros(len(arrays.first)), force)
    return force


@pytest.mark.parametrize("strain", ["von-karman", "green-lagrange"])
def test_polynomial_is_the_projected_force(strain, verification_row):
    state = tf.solve_prestress(small_antenna(strain=strain))
    rom = tf.reduce(state, Given(mixed_basis(state)))
    eta = 1e-3 * np.random.default_rng(1).standard_normal(rom.size)
    full, _ = state.system.force(eta @ rom.basis.kept)
    expected = rom.basis.kept @ (full - state.reference_force)
    coefficients = rom.coefficients
    arrays = rom.arrays(Rayleigh())
    # The exact tensors, then the stress fields that a run uses in their place.
    slope = slopes(arrays, eta)
    y = monomials(eta)
    exact = coefficients.linear @ eta + coefficients.quadratic @ y + slope.T @ (0.25 * coefficients.cubic @ y)
    error = np.abs(exact - expected).max() / np.abs(expected).max()
    verification_row(f"reduced polynomial of the antenna, {strain}: force against the kernel", 0.0, error, "round-off")
    assert error < 1e-13
    assert np.abs(forces_of(rom, eta) - expected).max() < 1e-5 * np.abs(expected).max()


def test_force_is_the_gradient_of_the_energy_and_the_tangent_its_derivative():
    state = tf.solve_prestress(small_antenna(strain="green-lagrange"))
    rom = tf.reduce(state, Given(mixed_basis(state, derivatives=True)))
    arrays, eta = rom.arrays(Rayleigh()), 1e-3 * np.random.default_rng(2).standard_normal(rom.size)
    still = np.zeros((1, rom.size))
    step = 1e-7
    force = forces_of(rom, eta)
    for i in range(rom.size):
        move = step * np.eye(rom.size)[i]
        ahead, behind = energies(arrays, eta[None] + move, still)[0, 1], energies(arrays, eta[None] - move, still)[0, 1]
        assert (ahead - behind) / (2 * step) == pytest.approx(force[i], rel=1e-6, abs=1e-7 * np.abs(force).max())
        slope = (forces_of(rom, eta + move) - forces_of(rom, eta - move)) / (2 * step)
        matrix = tangent(arrays, eta, np.zeros(len(arrays.first)))
        assert np.abs(slope - matrix[:, i]).max() < 1e-6 * np.abs(matrix).max()


@pytest.mark.parametrize(
    "method",
    [tf.WilsonTheta(), tf.GeneralizedAlpha(0.6), tf.Newmark(), tf.HHT(0.1), tf.CentralDifference()],
    ids=lambda method: method.name,
)
def test_a_complete_basis_is_the_full_model(method, verification_row):
    state = soft_film(strain="green-lagrange")
    rom = tf.reduce(state, Given(complete_basis(state)))
    # The maneuver ends between two steps of the grid.
    options = {
        "time_step": 2e-3,
        "end_time": 0.6,
        "damping": tf.Rayleigh(0.3, 1e-3),
        "method": method,
        "probes": {"A": (0.25, 0.1)},
        "initial_velocity": lambda x, y: 0.05 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8),
    }
    tight = {} if isinstance(method, tf.CentralDifference) else {"tolerance": 1e-10}
    maneuver = tf.Stop(rate=3.0, duration=0.1507, axis=(0.6, 0.8, 0.0), origin=(0.1, 0.0, 0.0))
    full, reduced = (tf.simulate(plant, maneuver, **options, **tight).data for plant in (state, rom))
    # Compare with coefficients that keep weak stress fields.
    for name in ("u", "v", "w", "w_velocity", "kinetic_energy"):
        scale = float(np.abs(full[name]).max())
        error = float(np.abs(full[name] - reduced[name]).max()) / scale
        assert error < 2e-5, name
    error = float(np.abs(full.w - reduced.w).max() / np.abs(full.w).max())
    verification_row(
        f"reduced model with a complete basis, {method.name}: w against the full model", 0.0, error, "exact"
    )
    assert np.array_equal(full.time, reduced.time)
    assert np.allclose(full.angular_velocity, reduced.angular_velocity, atol=1e-12)


def test_condensed_derivatives_are_exact_in_statics(verification_row):
    """A von Karman film on fixed edges: in-plane fields are linear in the monomials, so nothing is lost."""
    state = soft_film((6, 5))
    solver = ReferenceSolver(state)
    kept = complete_basis(state, transverse_only=True).kept
    rom = tf.reduce(state, Given(add_static_derivatives(state, solver, kept, np.ones(len(kept)), (), "condensed", "w")))
    assert rom.size < state.system.size
    motion = transverse_spin(400.0)
    q = solve_static(state, Coupling().load(motion, state.system.inertia))
    run = run_of(rom)
    ours = rom.displacement(run.beginning(motion).equilibrium())
    error = float(np.abs(ours - q).max() / np.abs(q).max())
    linear = solver.solve(-Coupling().load(motion, state.system.inertia))
    assert np.abs(linear).max() > 2.0 * np.abs(q).max()  # the film has hardened
    verification_row("static deflection of a film, in-plane fields condensed", 0.0, error, "exact for von Karman films")
    assert error < 1e-4


def test_centrifugal_load_stiffens_through_the_derivatives():
    state = soft_film((6, 5))
    kept = solve_modes(state, 40).vectors
    flat = np.abs(state.system.translations(kept)[:, :, 2]).max(axis=1) > 1e-9
    kept = ritz(state, kept[flat][:6])
    basis = add_static_derivatives(state, ReferenceSolver(state), kept, np.ones(6), ("rx",), "condensed", "w")
    rom = tf.reduce(state, Given(basis))
    motion = fixed_axis_motion(2.0, 0.0, np.array([1.0, 0.0, 0.0]), np.zeros(3))
    run = run_of(rom)
    frame = frame_at(Coupling(), run.moments, motion, rom.size)
    # Slow in-plane fields are coordinates, fast ones are condensed; both carry the load.
    eta = run.beginning(motion).equilibrium()
    ours = tangent(run.arrays, eta, frame.stress[0])
    q = spinning_equilibrium(state, motion, Coupling())
    matrix = state.system.pattern.symmetric_matrix(state.system.tangent(q))
    theirs = rom.basis.kept @ (matrix @ rom.basis.kept.T)
    change = np.abs(theirs - np.diag(np.diag(rom.coefficients.linear))).max()
    assert change > 1e-4 * np.abs(theirs).max()
    assert np.abs(ours - theirs).max() < 1e-3 * change


def test_derivatives_dissipate_what_their_velocity_does():
    """Power of the reduced damping = beta v'Kv of the lifted velocity."""
    state = tf.solve_prestress(small_antenna())
    rom = tf.reduce(state, tf.ModalBasis(("rx",), count=5, static_correction=False))
    rng = np.random.default_rng(3)
    eta, rate = 1e-3 * rng.standard_normal((2, rom.size))
    c, damping = rom.coefficients, Rayleigh(0.0, 1e-2)
    moving = monomial_rates(eta, rate)
    power = damping.beta * (rate @ c.linear @ rate + moving @ c.viscous @ moving)
    lifted = rate @ rom.basis.kept + monomial_rates(eta, rate) @ rom.monomial_vectors
    stiffness = state.system.pattern.symmetric_matrix(state.tangent_entries)
    assert power == pytest.approx(damping.beta * lifted @ (stiffness @ lifted), rel=1e-9)
    # What a run uses: the same power from the strongest fields.
    eta, rate = rom.basis.amplitude * rng.standard_normal((2, rom.size))
    moving = monomial_rates(eta, rate)
    force = forces_of(rom, eta, rate, damping) - forces_of(rom, eta)
    assert rate @ force == pytest.approx(damping.beta * moving @ c.viscous @ moving, rel=2e-2)


def test_gyroscopic_coupling_of_derivatives_does_no_work():
    state = tf.solve_prestress(small_antenna())
    rom = tf.reduce(state, tf.ModalBasis(("rx",), count=5))
    arrays = rom.arrays(Rayleigh())
    run = run_of(rom)
    motion = fixed_axis_motion(1.5, 0.0, np.array([0.6, 0.8, 0.0]), np.zeros(3))
    frame = frame_at(Coupling(euler=False, centrifugal=False, inertial_load=False), run.moments, motion, rom.size)
    rng = np.random.default_rng(4)
    q, v = 1e-3 * rng.standard_normal((2, rom.size))
    stress, force = np.empty(len(arrays.first)), np.empty(rom.size)
    derivative_forces(arrays, frame, 0, q, v, stress, force)
    follow = slopes(arrays, q).T @ stress
    assert abs(v @ force) > 0.0
    assert abs(v @ (force + follow)) < 1e-12 * (abs(v @ force) + abs(v @ follow))


def test_parameters_give_what_a_rebuilt_structure_gives(verification_row):
    model = small_antenna()
    state = tf.solve_prestress(model)
    basis = mixed_basis(state, derivatives=True)
    factors = Factors(1.7, 0.6, {"membrane": 1.2, "beam": 0.8}, {"membrane": 1.1, "cable": 0.5})
    ours = assemble(project(state, basis), factors)
    changed = model.with_pretension_scaled(1.7, 0.6)
    groups = tuple(replace(group, section=_scaled(group.section, factors)) for group in changed.groups)
    theirs = assemble(project(tf.solve_prestress(replace(changed, groups=groups)), basis))
    worst = 0.0
    for name in ("mass", "linear", "quadratic", "cubic", "viscous", "turning", "load", "load_stress", "follow_load"):
        a, b = getattr(ours, name), getattr(theirs, name)
        worst = max(worst, float(np.abs(a - b).max() / max(np.abs(b).max(), 1e-12)))
    verification_row("reduced coefficients at other tensions, moduli, densities", 0.0, worst, "structure built anew")
    assert worst < 1e-8


def _scaled(section, factors):
    young, density = factors.youngs_modulus.get(section.kind, 1.0), factors.density.get(section.kind, 1.0)
    old = section.material
    return replace(section, material=Material(young * old.youngs_modulus, density * old.density, old.poisson_ratio))


def test_energy_conserving_steps_conserve_the_reduced_energy(verification_row):
    state = soft_film((6, 5))
    rom = tf.reduce(state, tf.ModalBasis(("z",), count=4))
    run = tf.simulate(
        rom,
        method=tf.EnergyConserving(),
        time_step=4e-3,
        end_time=8.0,
        initial_velocity=lambda x, y: 0.5 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8),
    )
    total = (run.data.kinetic_energy + run.data.strain_energy).values
    drift = float(np.abs(total / total[0] - 1.0).max())
    verification_row("energy-conserving method, reduced film, 2000 steps: drift of the energy", 0.0, drift, "exact")
    assert drift < 1e-10


@pytest.mark.parametrize(("method", "order"), [(tf.WilsonTheta(), 2), (tf.CentralDifference(), 2), (tf.Newmark(), 2)])
def test_second_order_through_a_stop_that_ends_between_steps(method, order):
    state = tf.solve_prestress(small_antenna())
    rom = tf.reduce(state, tf.ModalBasis(("rx",), count=4))
    maneuver = tf.Stop(rate=0.3, duration=0.203)

    def final(step):
        run = tf.simulate(
            rom,
            maneuver,
            method=method,
            time_step=step,
            end_time=0.6,
            damping=tf.Rayleigh(0.1, 1e-3),
            probes={"A": (0.5, 0.3)},
        )
        return float(run.data.w[-1, 0])

    finest = final(2.5e-4 / 4)
    errors = [abs(final(step) - finest) for step in (2e-3, 1e-3, 5e-4)]
    observed = np.log2(errors[0] / errors[1]), np.log2(errors[1] / errors[2])
    assert np.mean(observed) == pytest.approx(order, abs=0.25)


def test_start_of_a_sudden_spin_equals_the_full_one():
    """The run starts at the equilibrium before the maneuver, with the acceleration after it."""
    state = soft_film()
    rom = tf.reduce(state, Given(complete_basis(state)))
    maneuver = SuddenSpin(tf.SpinUp(rate=4.0, duration=0.2, axis=(1.0, 0.0, 0.0)))
    options = {"time_step": 1e-3, "end_time": 0.3, "method": tf.Newmark(), "probes": {"A": (0.25, 0.1)}}
    full, reduced = (tf.simulate(plant, maneuver, **options).data for plant in (state, rom))
    assert float(np.abs(full.w - reduced.w).max()) < 1e-5 * float(np.abs(full.w).max())
