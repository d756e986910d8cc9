"""Central differences across a film that follows statically in its plane: limit, order, energy, the whole motion."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

import tautflex as tf
from tautflex.solvers.static.across import transverse_unknowns
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from verification.dynamic_cases import small_antenna, soft_film, string

STRESS = (4e4, 3e4, 0.0)


def stiff_film(strain: str = "green-lagrange"):
    """Fixed-edge film ten thousand times as stiff in its plane as it is taut."""
    section = tf.MembraneSection(tf.Material(3.5e8, 1500.0, 0.3), 1e-3, strain)
    return tf.solve_prestress(build_fixed_film(AntennaLayout(1.0, 0.8, (6, 5)), section, STRESS))


def struck(state, method, step: float, every: int = 1, end: float = 0.1, **options):
    return tf.simulate(
        state,
        method=method,
        time_step=step,
        end_time=end,
        initial_velocity=lambda x, y: 3.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x + 0.5 * y),
        probes={"A": (0.12, 0.1)},
        every=every,
        **options,
    )


def across(run) -> np.ndarray:
    return run.data.w.values[:, 0]


def test_limit_is_that_of_the_largest_tension(verification_row):
    """At rest: nine tenths of 2 / w_max of the film under the larger of its principal stresses on both axes."""
    state = tf.solve_prestress(
        build_fixed_film(
            AntennaLayout(1.0, 0.8, (6, 5)),
            tf.MembraneSection(tf.Material(3.5e8, 1500.0, 0.3), 1e-3, "von-karman"),
            (STRESS[0], STRESS[0], 0.0),
        )
    )
    some = transverse_unknowns(state)
    stiffness, mass = state.system.matrix(state.tangent_entries).toarray(), state.system.inertia.mass_matrix.toarray()
    largest = eigh(stiffness[some][:, some], mass[some][:, some], eigvals_only=True)[-1]
    stepper = tf.CondensedDifference().stepper(EquationOfMotion(state, tf.Rayleigh(), tf.Coupling()))
    got = stepper.stable_step(np.zeros(state.system.size)) / 0.9
    limit = 2.0 / np.sqrt(largest)
    assert limit * (1.0 - 1e-3) < got <= limit * (1.0 + 1e-9)
    verification_row("condensed difference, film: stable step [s]", limit, got, "2 / w_max, all eigenvalues")


@pytest.mark.slow
@pytest.mark.parametrize("damping", [tf.Rayleigh(), tf.Rayleigh(0.5, 1e-4)], ids=["undamped", "damped"])
def test_second_order_and_the_motion_of_the_whole(damping, verification_row):
    """Large amplitude, an angular acceleration that ends inside a step; the trapezoidal rule has inertia everywhere."""
    state, stop = stiff_film(), tf.Stop(3.0, 0.0237, origin=(0.0, 0.5, 0.0))
    records = [
        across(struck(state, tf.CondensedDifference(), 4e-4 / 2**k, 2**k, 0.08, maneuver=stop, damping=damping))
        for k in range(4)
    ]
    differences = [np.sqrt(np.mean((a - b) ** 2)) for a, b in itertools.pairwise(records)]
    order = float(np.log2(differences[-2] / differences[-1]))
    assert order == pytest.approx(2.0, abs=0.15)
    whole = across(struck(state, tf.Newmark(), 5e-5, 8, 0.08, maneuver=stop, damping=damping, tolerance=1e-9))
    assert np.abs(whole).max() > 10e-3  # ten thicknesses
    off = float(np.abs(records[-1] - whole).max() / np.abs(whole).max())
    assert off < 5e-3
    name = "damped" if damping.beta else "undamped"
    verification_row(f"condensed difference, {name} film with a stop: observed order", 2.0, order, "second order")


def test_what_is_left_out_falls_with_the_stiffness_in_the_plane():
    """Inertia in the plane over stiffness: a film sixteen times as stiff, struck half as hard, is nearer to static."""
    off = []
    for modulus, speed in ((2e6, 1.0), (3.2e7, 0.5)):
        section = tf.MembraneSection(tf.Material(modulus, 1500.0, 0.3), 1e-3, "von-karman")
        state = tf.solve_prestress(build_fixed_film(AntennaLayout(1.0, 0.8, (6, 5)), section, STRESS))
        options = {
            "time_step": 1e-4,
            "end_time": 0.1,
            "probes": {"A": (0.12, 0.1)},
            "initial_velocity": lambda x, y, speed=speed: speed * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8),
        }
        one, other = (
            across(tf.simulate(state, method=method, **options)) for method in (tf.CondensedDifference(), tf.Newmark())
        )
        off.append(np.abs(one - other).max() / np.abs(other).max())
    assert off[0] > 1e-4
    assert off[1] < 0.5 * off[0]


def test_energy_is_balanced_and_stays():
    """Undamped, of constant step: the energy oscillates with the step and does not drift; the books close."""
    run = struck(stiff_film(), tf.CondensedDifference(), 1e-4, end=0.4)
    assert run.stats.halvings == 0
    energy = (run.data.kinetic_energy + run.data.strain_energy).values
    assert np.ptp(energy) < 0.05 * energy[0]
    assert energy[-500:].mean() == pytest.approx(energy[:500].mean(), rel=5e-3)
    assert abs(run.energy_balance["residual"]) < 1e-4 * energy[0]


def test_stiffening_halves_steps():
    """Struck hard the film pulls itself taut: steps of the limit at rest are halved, and the motion stays bounded."""
    state = stiff_film()
    stepper = tf.CondensedDifference().stepper(EquationOfMotion(state, tf.Rayleigh(), tf.Coupling()))
    limit = stepper.stable_step(np.zeros(state.system.size))
    run = struck(state, tf.CondensedDifference(), limit, end=100 * limit)
    assert run.status.value == "completed"
    assert run.stats.halvings > 0
    energy = (run.data.kinetic_energy + run.data.strain_energy).values
    assert energy.max() < 1.2 * energy[0]
    with pytest.raises(tf.InputError, match="time_step: expected at most the stable step"):
        struck(state, tf.CondensedDifference(), 1.01 * limit, end=100 * limit)


def test_a_cut_run_goes_on_to_the_bit():
    state = stiff_film()
    whole = struck(state, tf.CondensedDifference(), 2e-4, end=0.04)
    first = struck(state, tf.CondensedDifference(), 2e-4, end=0.02)
    options = {"method": tf.CondensedDifference(), "time_step": 2e-4, "probes": {"A": (0.12, 0.1)}}
    second = tf.simulate(state, end_time=0.04, initial=first.final, **options)
    np.testing.assert_array_equal(across(second)[-50:], across(whole)[-50:])


def test_what_does_not_follow_statically_is_refused():
    options = {"method": tf.CondensedDifference(), "time_step": 1e-5, "end_time": 1e-4}
    antenna = tf.solve_prestress(small_antenna())
    for state, kind in ((antenna, "beam, cable"), (string(4), "cable")):
        with pytest.raises(tf.UnsupportedError, match=f"film alone for CondensedDifference.., got {kind}"):
            tf.simulate(state, **options)
    with pytest.raises(tf.UnsupportedError, match="damping"):
        tf.simulate(soft_film(), damping=tf.Modal(0.01), **options)
    model = soft_film().model
    curved = model.nodes + np.stack([0 * model.nodes[:, 0], 0 * model.nodes[:, 0], 0.1 * model.nodes[:, 0] ** 2], 1)
    with pytest.raises(tf.UnsupportedError, match="flat film"):
        tf.simulate(tf.solve_prestress(replace(model, nodes=curved)), **options)
    with pytest.raises(tf.UnsupportedError, match="method"):
        tf.simulate(tf.reduce(soft_film()), **options)
    with pytest.raises(tf.InputError, match="method"):
        tf.simulate(soft_film(), tf.FreeHub(mass=10.0, inertia=(1.0, 1.0, 1.0)), **options)
