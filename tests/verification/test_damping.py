"""Dampings: closed forms of damped modes, one matrix in every model, and dampings from outside.

[CP] Clough & Penzien, Dynamics of Structures, 2nd ed., 12-3 (uncoupled modes) and 12-4 (Rayleigh).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import BasisVectors, Coupling, InputError
from tautflex.mechanics.products import MassDamping
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.low_rank import LowRankUpdate
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.implicit import Stepper
from verification.batch_cases import changed_rom
from verification.dynamic_cases import TINY_VELOCITY, small_antenna, soft_film

RATIOS = (0.02, 0.05, 0.0, 0.1)
PROBE = (0.21, 0.13)


@dataclass(frozen=True)
class Dashpots(tf.Damping):
    """A damping from outside: dashpots [N s/m] along z at every node, made with public names alone."""

    coefficient: float

    def matrix(self, structure: tf.LinearStructure) -> tf.DampingMatrix:
        up = np.abs(structure.system.translations(np.eye(structure.system.size))[..., 2]).max(axis=1) > 0.5
        # Written without a thought of tracing, as users do.
        return tf.DampingMatrix(
            vectors=np.eye(len(up))[up], coefficients=np.array([float(self.coefficient)] * up.sum())
        )


@dataclass(frozen=True)
class FirstModes(tf.Basis):
    """Basis of the lowest modes and nothing else."""

    count: int

    def vectors(self, state):
        _, modes = state.linear.modes(self.count)
        return BasisVectors(modes, np.zeros((0, state.system.size)), np.full(self.count, 1e-4), "first modes")


@pytest.fixture(scope="module")
def film():
    return soft_film()


@pytest.fixture(scope="module")
def modes(film):
    return tf.solve_modes(film, n=6)


def dense(state, damping):
    """C of the full model as a dense matrix."""
    matrix = damping.matrix(state.linear)
    mass, stiffness = (
        state.system.matrix(v).toarray() for v in (state.system.inertia.mass_entries, state.tangent_entries)
    )
    return (
        matrix.proportional(mass, stiffness) + (matrix.vectors.T * matrix.coefficients) @ matrix.vectors
        if matrix.rank
        else matrix.proportional(mass, stiffness)
    )


def thrown(state, modes, mode, steps, method, damping, periods=4):
    """Deflection of a mode's free decay, and the closed form, over the largest deflection."""
    w, zeta = 2.0 * np.pi * modes.frequencies[mode], RATIOS[mode]
    period = 2.0 * np.pi / w
    run = tf.simulate(
        state,
        method=method,
        time_step=period / steps,
        end_time=periods * period,
        damping=damping,
        initial_velocity=TINY_VELOCITY * modes.shapes[mode],
        probes={"A": PROBE},
    )
    time, swing = run.data.time.values, w * np.sqrt(1.0 - zeta**2)
    still = tf.simulate(
        state, time_step=1e-6, end_time=1e-6, initial_velocity=TINY_VELOCITY * modes.shapes[mode], probes={"A": PROBE}
    )
    speed = float(still.data.w_velocity.values[0, 0])
    exact = speed / swing * np.exp(-zeta * w * time) * np.sin(swing * time)
    return np.abs(run.data.w.values[:, 0] - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("mode", [0, 1, 3])
def test_a_mode_decays_as_its_ratio_says(film, modes, mode, verification_row):
    """Second order to the closed form ``exp(-zeta w t) sin(w sqrt(1 - zeta^2) t)`` in frequency and decay."""
    for method in (tf.Newmark(), tf.WilsonTheta(), tf.GeneralizedAlpha(0.9)):
        coarse, fine = (thrown(film, modes, mode, steps, method, tf.Modal(RATIOS)) for steps in (100, 200))
        order = np.log2(coarse / fine)
        assert fine < 3e-3
        assert order == pytest.approx(2.0, abs=0.1)
        verification_row(f"free decay of mode {mode + 1}, modal damping, {method.name}: order", 2, order, "[CP] 12-3")


def test_central_differences_decay_too(film, modes, verification_row):
    errors = [thrown(film, modes, 1, steps, tf.CentralDifference(), tf.Modal(RATIOS)) for steps in (100, 200)]
    order = np.log2(errors[0] / errors[1])
    assert order == pytest.approx(2.0, abs=0.1)
    verification_row("the same of mode 2, central differences: order", 2, order, "[CP] 12-3")


def test_modes_that_are_not_listed_keep_their_energy(film, modes, verification_row):
    """Mode 3 has the ratio 0 and mode 5 is not listed: neither feels anything."""
    for mode in (2, 4):
        period = 1.0 / modes.frequencies[mode]
        runs = [
            tf.simulate(
                film,
                method=tf.Newmark(),
                time_step=period / 50,
                end_time=5 * period,
                damping=damping,
                initial_velocity=TINY_VELOCITY * modes.shapes[mode],
            ).data
            for damping in (tf.Modal(RATIOS), None)
        ]
        energy, free = ((run.kinetic_energy + run.strain_energy).values for run in runs)
        change = float(np.abs(energy / free - 1.0).max())
        assert change < 1e-9
        verification_row(f"energy of mode {mode + 1} under modal damping of others over none", 0, change, "[CP] 12-3")


def test_all_modes_with_the_ratios_of_rayleigh_are_rayleigh(film, verification_row):
    """``sum_k (alpha + beta w_k^2) (M phi_k)(M phi_k)' = alpha M + beta K`` over all modes."""
    rayleigh, (w, _) = tf.Rayleigh(0.3, 1e-3), film.linear.modes(film.system.size)
    # The stiffest in-plane modes would be overdamped: less of the stiffness part.
    every = tf.Modal(tuple(0.5 * (rayleigh.alpha / w + rayleigh.beta * w)))
    expected = dense(film, rayleigh)
    difference = float(np.abs(dense(film, every) - expected).max() / np.abs(expected).max())
    assert difference < 1e-12
    verification_row("modal damping of all modes with Rayleigh's ratios: matrix", 0, difference, "[CP] 12-4")
    options = {
        "time_step": 2e-3,
        "end_time": 0.2,
        "method": tf.GeneralizedAlpha(0.8),
        "probes": {"A": PROBE},
        "tolerance": 1e-11,
        "initial_velocity": lambda x, y: np.cos(np.pi * x) * np.cos(np.pi * y / 0.8),
    }
    one, other = (tf.simulate(film, damping=damping, **options).data.w.values for damping in (every, rayleigh))
    apart = float(np.abs(one - other).max() / np.abs(other).max())
    assert apart < 1e-9
    verification_row("the same: deflection of a large motion", 0, apart, "Rayleigh's run")


def test_rigid_motions_are_not_damped():
    """A free structure's translations have no frequency, and damping of its modes changes no linear momentum."""
    free = tf.solve_prestress(replace(small_antenna(), supports=()))
    w, _ = free.linear.modes(10)
    assert np.count_nonzero(w) == 7
    matrix = tf.Modal(0.05).matrix(free.linear)
    for axis in range(3):
        # Every node moves by one.
        full = np.zeros(free.model.dof_count)
        full[free.model.translation_dofs[:, axis]] = 1.0
        lost = matrix.low_rank_force(full[free.model.free_dofs])
        assert np.abs(lost).max() < 1e-8 * np.abs(matrix.coefficients * matrix.vectors.T).max()


@pytest.mark.parametrize(
    "damping", [tf.Modal(RATIOS), tf.Modal(0.02, modes=18), Dashpots(0.05), tf.Rayleigh(0.5, 1e-3)]
)
def test_solution_and_product_equal_those_of_the_dense_matrix(film, damping):
    system, matrix = film.system, damping.matrix(film.linear)
    mass, h = system.inertia.mass_entries, 0.01
    products = MassDamping(system.pattern, mass, film.tangent_entries, matrix)
    factors = SymmetricFactorization(system.pattern)
    factors.factorize(mass + h * products.entries)
    update = LowRankUpdate(factors)
    update.correct(matrix.vectors, h * matrix.coefficients)
    full, v = (
        system.matrix(mass).toarray() + h * dense(film, damping),
        np.random.default_rng(0).standard_normal(system.size),
    )
    np.testing.assert_allclose(
        products.damping_product(v), dense(film, damping) @ v, rtol=0, atol=1e-13 * np.abs(v).max()
    )
    np.testing.assert_allclose(update.solve(full @ v), v, rtol=0, atol=1e-12)


@pytest.mark.parametrize("damping", [tf.Modal(RATIOS), Dashpots(0.05)])
def test_energy_that_a_step_loses_is_the_work_of_the_damping(film, damping, verification_row):
    """Conserving method, large motion: ``E_1 - E_0 = -h v' C v``, v the mean velocity of the step."""
    stepper = Stepper(EquationOfMotion(film, damping, Coupling()), tf.EnergyConserving(), 1e-12)
    c, h, size = dense(film, damping), 2e-3, film.system.size
    segment = tf.AtRest().segments()[0]
    v = np.random.default_rng(3).standard_normal(size)
    v[np.abs(film.system.translations(np.eye(size))[..., 2]).max(axis=1) < 0.5] = 0.0
    at = stepper.equation.start(0.0, np.zeros(size), v, segment.motion(0.0))
    mass, lost, energy = film.system.inertia.mass_matrix, 0.0, []
    for _ in range(50):
        energy.append(0.5 * at.v @ (mass @ at.v) + stepper.equation.workspace.force(at.q)[1])
        end, outcome = stepper.step(at, h, segment)
        assert outcome.converged
        mean = (end.q - at.q) / h
        lost += h * mean @ c @ mean
        at = end
    energy.append(0.5 * at.v @ (mass @ at.v) + stepper.equation.workspace.force(at.q)[1])
    error = abs(energy[0] - energy[-1] - lost) / lost
    assert lost > 0.05 * energy[0]
    assert error < 1e-9
    verification_row(f"energy lost over the work of {type(damping).__name__} damping, large motion", 1, 1 + error, "")


@pytest.mark.parametrize("damping", [tf.Modal(RATIOS), Dashpots(0.05)])
def test_full_model_and_reduced_model_on_modes_agree(film, modes, damping, verification_row):
    """Tiny motion that the basis holds: modes under modal damping, any motion if it has all of them."""
    rom = tf.reduce(film, FirstModes(18 if isinstance(damping, Dashpots) else 4))
    options = {
        "time_step": 2e-3,
        "end_time": 0.4,
        "damping": damping,
        "probes": {"A": PROBE},
        "initial_velocity": TINY_VELOCITY * (modes.shapes[0] + modes.shapes[1] - modes.shapes[3]),
    }
    for method in (tf.Newmark(), tf.CentralDifference()):
        full, reduced = (tf.simulate(plant, method=method, **options).data.w.values for plant in (film, rom))
        apart = float(np.abs(full - reduced).max() / np.abs(full).max())
        assert apart < 1e-9
        verification_row(
            f"reduced model on modes, {type(damping).__name__} damping, {method.name}", 0, apart, "full model"
        )


@pytest.mark.slow
def test_hyper_reduced_model_agrees(film, modes):
    options = {"time_step": 2e-3, "end_time": 0.3, "damping": tf.Modal(RATIOS), "probes": {"A": PROBE}}
    options["initial_velocity"] = 0.2 * (modes.shapes[0] + modes.shapes[1]) / np.abs(modes.shapes[0]).max()
    run = tf.simulate(film, fields="all", **options)
    rom = tf.hyper_reduce(film, run.data, tolerance=0.0, lost=(1e-10, 1e-10))
    reduced = tf.simulate(rom, **options).data.w.values
    assert np.abs(reduced - run.data.w.values).max() < 1e-3 * np.abs(run.data.w.values).max()


def test_spinning_modes_at_rest_have_the_closed_form(film, modes, verification_row):
    """``-zeta w +- i w sqrt(1 - zeta^2)``."""
    w = 2.0 * np.pi * modes.frequencies[:4]
    exact = -np.array(RATIOS) * w + 1j * w * np.sqrt(1.0 - np.square(RATIOS))
    found = tf.solve_spinning_modes(film, (0.0, 0.0, 0.0), n=4, damping=tf.Modal(RATIOS)).eigenvalues
    error = float(np.abs(found - exact).max() / w.min())
    assert error < 1e-9
    verification_row("eigenvalues under modal damping at rest", 0, error, "-zeta w +- i w sqrt(1 - zeta^2)")


def test_spinning_modes_of_a_larger_film_are_eigenpairs():
    """Lanczos' modes and Arnoldi's method, spin and both kinds of damping; residual of the dense pencil."""
    state = soft_film((12, 8))
    found = tf.solve_spinning_modes(state, (0.0, 0.0, 3.0), n=6, damping=tf.Modal(0.03, modes=5))
    assert found.damping_ratios[:3] == pytest.approx(0.03, rel=0.1)
    assert found.stable


def test_participation_has_the_ratios(modes):
    data = tf.appendage_data(modes, damping=tf.Modal(RATIOS))
    expected = [*RATIOS, 0.0, 0.0]
    np.testing.assert_allclose(data.damping_ratio.values, expected, rtol=0, atol=1e-12)


def test_wrong_dampings_are_refused(film):
    with pytest.raises(InputError, match=r"ratio: expected a number in \[0, 1\], got -0\.1"):
        tf.Modal(-0.1)
    with pytest.raises(InputError, match=r"ratio: expected a number in \[0, 1\], got 1\.5"):
        tf.Modal((0.1, 1.5))
    with pytest.raises(InputError, match="modes: expected none beside a ratio per mode, got 3"):
        tf.Modal([0.1, 0.2], modes=3)
    with pytest.raises(InputError, match="ratio: expected at least one"):
        tf.Modal(())
    with pytest.raises(InputError, match="modes: expected an integer >= 1, got 0"):
        tf.Modal(0.1, modes=0)
    with pytest.raises(InputError, match="modes: expected 1 to 18 modes, got 40"):
        tf.simulate(film, damping=tf.Modal(0.1, modes=40), time_step=1e-3, end_time=1e-2)
    with pytest.raises(InputError, match="damping: expected an object such as Rayleigh"):
        tf.simulate(film, damping=0.1, time_step=1e-3, end_time=1e-2)
    assert tf.Modal([0.1, 0.2]) == tf.Modal((0.1, 0.2))


def worst(data, singles) -> float:
    pairs = [(data.isel(run=run), single) for run, single in enumerate(singles)]
    names = ("w", "w_velocity", "kinetic_energy", "strain_energy")
    return max(
        float(np.abs(a[n].values - b[n].values).max() / np.abs(b[n].values).max()) for a, b in pairs for n in names
    )


@pytest.mark.parametrize("kind", ["reduced", "explicit", "full"])
@pytest.mark.jax
def test_batches_are_the_single_runs(kind, verification_row):
    state = tf.solve_prestress(small_antenna())
    plant = state if kind == "full" else tf.reduce(state, tf.ModalBasis(directions=("rx",), count=3), weak_field=0.0)
    ratios, stop = [0.01, 0.08], tf.Stop(0.6, 0.04)
    options = {"time_step": 2e-3, "end_time": 0.06, "probes": {"A": (0.6, 0.3)}}
    method = {"method": tf.CentralDifference()} if kind == "explicit" else {"method": tf.Newmark(), "tolerance": 1e-12}
    parameters = {"damping.ratio": ratios, **({} if kind == "full" else {"tension_x": [1.0, 1.1]})}
    data = tf.Batch(plant).simulate(parameters, stop, damping=tf.Modal(0.5, modes=8), **options, **method)
    plants = [plant, plant if kind == "full" else changed_rom(plant, {"tension_x": 1.1})]
    singles = [
        tf.simulate(one, stop, damping=tf.Modal(ratio, modes=8), **options, **method).data
        for one, ratio in zip(plants, ratios, strict=True)
    ]
    assert np.abs(singles[0].w.values - singles[1].w.values).max() > 1e-3 * np.abs(singles[0].w.values).max()
    found = worst(data, singles)
    assert found < (1e-9 if kind == "full" else 1e-11)
    verification_row(f"batch with modal damping, {kind}, against single runs", 0, found, "single runs")
    if kind == "reduced":
        # A damping from outside, that no one can trace.
        outside = tf.Batch(plant).simulate(
            {"damping.coefficient": [0.1, 0.4]}, stop, damping=Dashpots(1.0), **options, **method
        )
        singles = [tf.simulate(plant, stop, damping=Dashpots(c), **options, **method).data for c in (0.1, 0.4)]
        assert worst(outside, singles) < 1e-11


@pytest.mark.jax
def test_derivative_by_the_ratio(verification_row):
    """Of the energy left at the end, against differences of two runs."""
    jax = pytest.importorskip("jax")
    rom = tf.reduce(tf.solve_prestress(small_antenna()), tf.ModalBasis(directions=("rx",), count=3))
    respond = tf.Batch(rom).response(
        tf.Stop(0.6, 0.02),
        time_step=2e-3,
        end_time=0.04,
        damping=tf.Modal((0.01, 0.02, 0.03)),
        tolerance=1e-12,
        store=("energy",),
    )

    def energy(ratio):
        return respond({"damping.ratio": ratio}).energy[-1].sum()

    ratio, step = np.array([0.01, 0.05, 0.03]), 1e-5 * np.eye(3)
    both = jax.jit(jax.value_and_grad(energy), compiler_options={"xla_backend_optimization_level": 0})
    found = np.asarray(both(ratio)[1])
    expected = np.array([(both(ratio + e)[0] - both(ratio - e)[0]) / 2e-5 for e in step])
    error = float(np.abs(found - expected).max() / np.abs(expected).max())
    assert error < 1e-6
    verification_row("derivative of the last energy by three damping ratios", 0, error, "differences of runs")
