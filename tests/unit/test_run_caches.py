"""What a run keeps and re-uses must not show in its results, nor pile up in memory."""

import math
import tracemalloc

import numpy as np
import pytest

import tautflex as tf
from tautflex import Material, MembraneSection, linear_solver
from tautflex.mechanics.products import MassDamping
from tautflex.structure.antenna import AntennaLayout, build_fixed_film


@pytest.fixture(scope="module")
def film():
    section = MembraneSection(Material(3.5e9, 1530.0, 0.34), 1e-4)
    return tf.solve_prestress(build_fixed_film(AntennaLayout(2.0, 1.0, (6, 4)), section, (2e5, 2e5, 0.0)))


def run(state, **changes):
    options = {
        "time_step": 1e-3,
        "end_time": 0.2,
        "damping": tf.Rayleigh(0.1, 1e-4),
        "probes": {"A": (0.3, 0.2)},
        "initial_velocity": lambda x, y: 2.0 * np.cos(math.pi * x / 2.0) * np.cos(math.pi * y),
    }
    return tf.simulate(state, tf.Stop(0.6, 0.0555), **{**options, **changes})


@pytest.mark.parametrize("method", [tf.WilsonTheta(), tf.GeneralizedAlpha(0.8), tf.EnergyConserving(), tf.HHT()])
def test_storing_less_changes_nothing_of_what_is_stored(film, method):
    dense, sparse = run(film, method=method), run(film, method=method, every=10)
    assert dense.stats.iterations == sparse.stats.iterations
    for name in ("u", "v", "w", "w_velocity", "kinetic_energy", "strain_energy", "min_principal_resultant"):
        np.testing.assert_array_equal(dense.data[name].values[::10], sparse.data[name].values)


def test_a_second_run_on_the_same_state_repeats_the_first_to_the_bit(film):
    first = run(film)
    run(film, time_step=7e-4, end_time=0.07, damping=None)  # other step, other matrices
    second = run(film)
    np.testing.assert_array_equal(first.data["w"].values, second.data["w"].values)
    np.testing.assert_array_equal(first.data["strain_energy"].values, second.data["strain_energy"].values)


@pytest.mark.parametrize("name", ["qdldl", "superlu"])
def test_every_linear_solver_gives_the_same_motion(film, name):
    expected = run(film).data["w"].values
    with linear_solver(name):
        found = run(film).data["w"].values
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


def test_one_walk_through_mass_and_damping_gives_both_products(film):
    system, rng = film.system, np.random.default_rng(0)
    mass, damping = system.inertia.mass_entries, 0.3 * system.inertia.mass_entries + 0.01 * film.tangent_entries
    products = MassDamping(system.pattern, mass, film.tangent_entries, tf.DampingMatrix(0.3, 0.01))
    vector = rng.standard_normal(system.size)
    assert len(products.column) < system.pattern.entries  # transverse and in-plane unknowns do not meet
    for found, values in ((products.mass_product(vector), mass), (products.damping_product(vector), damping)):
        np.testing.assert_allclose(found, system.matrix(values) @ vector, rtol=1e-12, atol=1e-12 * np.abs(found).max())
    expected = vector @ (system.matrix(mass) @ vector)
    assert products.mass_norm(vector) == pytest.approx(expected, rel=1e-13)


def test_a_longer_run_takes_no_more_memory(film):
    """Ten times the steps, the same number of samples: the peak must not rise."""
    run(film, every=10)

    def peak(steps, every):
        tracemalloc.start()
        run(film, time_step=1e-3, end_time=steps * 1e-3, every=every)
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    short, long = peak(300, 100), peak(3000, 1000)
    assert long < short + 50_000
