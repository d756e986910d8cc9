"""Explicit central differences: stability limit, order, damping, and agreement with the trapezoidal rule."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from scipy.linalg import eigh

from tautflex import (
    Adaptive,
    AtRest,
    CentralDifference,
    Coupling,
    InputError,
    Newmark,
    Rayleigh,
    Stop,
    simulate,
    solve_prestress,
)
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.methods.largest_eigenvalue import largest_eigenvalue
from tautflex.solvers.transient.status import Status
from verification.dynamic_cases import TINY_VELOCITY, small_antenna, soft_film, string, two_term_root


def dense_limit(state) -> float:
    """2 / (largest angular frequency), from all eigenvalues."""
    stiffness = state.system.matrix(state.tangent_entries).toarray()
    return 2.0 / np.sqrt(eigh(stiffness, state.system.inertia.mass_matrix.toarray(), eigvals_only=True)[-1])


@pytest.mark.parametrize("damping", [Rayleigh(), Rayleigh(0.5, 2e-2)], ids=["undamped", "damped"])
@pytest.mark.parametrize("name", ["string", "film"])
def test_limit_is_two_over_the_largest_frequency(name, damping, verification_row):
    """The step that is refused, and the one that is not, bracket 2 / w_max; implicit damping does not move it."""
    state = string(8, tension=1.0, modulus=1e3) if name == "string" else soft_film()
    limit = dense_limit(state)
    stepper = CentralDifference().stepper(EquationOfMotion(state, damping, Coupling()))
    got = stepper.stable_step(np.zeros(state.system.size))
    assert limit * (1.0 - 1e-3) < got <= limit * (1.0 + 1e-9)
    options = {"method": CentralDifference(), "damping": damping, "fields": "all"}
    with pytest.raises(InputError, match="time_step") as refused:
        simulate(state, time_step=1.0001 * limit, end_time=5 * limit, **options)
    run = simulate(
        state,
        time_step=0.999 * limit,
        end_time=400 * limit,
        initial_velocity=1e-6 * np.random.default_rng(0).standard_normal((len(state.model.nodes), 3)),
        **options,
    )
    assert run.stats.halvings == 0
    energy = (run.data.kinetic_energy + run.data.strain_energy).values
    assert energy.max() < 1e3 * energy[0]  # a mode close to the limit beats, it does not grow
    assert np.abs(run.data.displacement.values[-50:]).max() < 2.0 * np.abs(run.data.displacement.values[:-50]).max()
    # The number that the message advises is stable.
    advice = float(re.search(r"use ([0-9.e-]+),", str(refused.value)).group(1))
    assert 0.85 * limit < advice < limit
    if not damping.beta:
        verification_row(f"central difference, {name}: stable step [s]", limit, got, "2 / w_max, all eigenvalues")


def test_a_step_beyond_the_limit_gives_itself_away():
    """With the estimate silenced, the stiffness felt along a growing step, move . df / move . M move, exceeds 4/h^2."""
    state = string(8, tension=1.0, modulus=1.0, free_directions="z")
    size = 1.02 * dense_limit(state)
    stepper = CentralDifference().stepper(EquationOfMotion(state, Rayleigh(), Coupling()))
    stepper._largest = 1e-12  # believes every step to be stable
    at = stepper.equation.start(0.0, np.zeros(state.system.size), np.zeros(state.system.size), AtRest().start())
    at.v = TINY_VELOCITY * np.random.default_rng(0).standard_normal(state.system.size)
    segment = AtRest().segments()[0]
    sizes, refused = [], 0
    for _ in range(30):
        end, outcome = stepper.step(at, size, segment)
        refused += not outcome.converged
        if not outcome.converged:
            break
        at = end
        sizes.append(np.abs(at.q).max())
    assert refused == 1
    assert sizes[-1] < 50.0 * sizes[0]


def test_all_factorizations_are_counted_however_many_step_sizes_a_damped_run_takes():
    state = string(8, tension=1.0, modulus=1.0, free_directions="z")
    stepper = CentralDifference().stepper(EquationOfMotion(state, Rayleigh(alpha=0.1), Coupling()))
    at = stepper.equation.start(0.0, np.zeros(state.system.size), np.zeros(state.system.size), AtRest().start())
    stepper.check(at, 0.5 * dense_limit(state))
    for k in range(20):
        at, outcome = stepper.step(at, 0.5 * dense_limit(state) / (1.0 + k), AtRest().segments()[0])
        assert outcome.converged
    stepper.collect_counts()
    assert stepper.equation.statistics.factorizations == 20 + 1  # and the mass matrix


@pytest.mark.parametrize("ratio", [0.0, 0.03])
@pytest.mark.parametrize("steps", [20.0, 5.0, 3.2])
def test_period_and_decay_follow_the_textbook(steps, ratio):
    """(1 + x O) z^2 - (2 - O^2) z + (1 - x O) = 0 for damping ratio x and O = h w [Bathe 9.2.1 for one mode]."""
    state = string(2, tension=1.0, modulus=1.0, free_directions="z")
    frequency = 2.0 / dense_limit(state)
    phase = 2.0 * np.pi / steps
    run = simulate(
        state,
        method=CentralDifference(),
        time_step=phase / frequency,
        end_time=60 * phase / frequency,
        damping=Rayleigh(2.0 * ratio * frequency, 0.0),
        initial_velocity=lambda x, y: TINY_VELOCITY + 0.0 * x,
        probes={"middle": (0.5, 0.0, 0.0)},
    )
    root = two_term_root(run.data.w.values[:, 0])
    roots = np.roots([1.0 + ratio * phase, -(2.0 - phase**2), 1.0 - ratio * phase])
    assert root == pytest.approx(roots[np.argmax(roots.imag)], rel=1e-8)


def record(method, step: float, every: int, damping: Rayleigh, **options) -> np.ndarray:
    run = simulate(
        soft_film(),
        Stop(3.0, 0.0737, origin=(0.0, 0.5, 0.0)),
        method=method,
        time_step=step,
        end_time=0.25,
        damping=damping,
        initial_velocity=lambda x, y: 4.0 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8) * (1.0 + x + 0.5 * y),
        probes={"A": (0.12, 0.1)},
        every=every,
        **options,
    )
    return run.data.w.values[:, 0]


@pytest.mark.parametrize("damping", [Rayleigh(), Rayleigh(0.5, 2e-3)], ids=["undamped", "damped"])
def test_second_order_and_the_same_motion_as_the_trapezoidal_rule(damping, verification_row):
    """Large amplitude, a stop that ends inside a step."""
    records = [record(CentralDifference(), 1e-3 / 2**level, 2**level, damping) for level in range(4)]
    differences = [np.sqrt(np.mean((a - b) ** 2)) for a, b in itertools.pairwise(records)]
    order = float(np.log2(differences[-2] / differences[-1]))
    assert order == pytest.approx(2.0, abs=0.1)
    trapezoidal = record(Newmark(), 2.5e-4, 4, damping, tolerance=1e-9)
    assert np.abs(records[-1] - trapezoidal).max() < 1e-4 * np.abs(trapezoidal).max()
    name = "damped" if damping.beta else "undamped"
    verification_row(f"central difference, {name} film with a stop: observed order", 2.0, order, "second order")


def test_gyroscopic_forces_are_solved_for():
    """Spinning antenna about a tilted axis: agreement with the trapezoidal rule falls with the square of the step."""
    state, stop = solve_prestress(small_antenna()), Stop(20.0, 0.05, axis=(1.0, 0.4, 0.3))
    stepper = CentralDifference().stepper(EquationOfMotion(state, Rayleigh(), Coupling()))
    limit = stepper.stable_step(np.zeros(state.system.size))
    step = 1e-3 / np.ceil(1e-3 / (0.5 * limit))
    options = {"end_time": 4e-3, "fields": [4e-3], "time_step": step}
    fields = [
        simulate(state, stop, method=method, **options).data.displacement.values[0]
        for method in (CentralDifference(), Newmark())
    ]
    assert np.abs(fields[0] - fields[1]).max() < 1e-3 * np.abs(fields[1]).max()


def test_stiffening_halves_steps_instead_of_blowing_up():
    """A soft string thrown hard: tension, and with it the largest frequency, grows a hundredfold in the run."""
    state = string(8, tension=1e-2, modulus=1e3, free_directions="z")
    limit = dense_limit(state)
    run = simulate(
        state,
        method=CentralDifference(),
        time_step=0.9 * limit,
        end_time=200 * limit,
        initial_velocity=lambda x, y: 0.5 * np.sin(np.pi * x),
        probes={"A": (0.5, 0.0, 0.0)},
        fields="all",
    )
    assert run.status is Status.COMPLETED
    assert run.stats.halvings > 0
    energy = (run.data.kinetic_energy + run.data.strain_energy).values
    # Steps of changing size do not keep the energy, but it stays bounded: without the halving it grows for ever.
    assert energy.max() < 1.5 * energy[0]


def test_largest_eigenvalue_of_a_random_pair():
    random = np.random.default_rng(5)
    half = random.standard_normal((30, 30))
    mass = half @ half.T + np.eye(30)
    stiffness = half.T @ half
    exact = eigh(stiffness, mass, eigvals_only=True)[-1]
    got, vector = largest_eigenvalue(stiffness, mass, lambda x: np.linalg.solve(mass, x), tolerance=1e-10)
    assert got == pytest.approx(exact, rel=1e-9)
    np.testing.assert_allclose(stiffness @ vector, got * (mass @ vector), atol=1e-7 * got * np.linalg.norm(vector))


def test_adaptive_steps_are_for_implicit_methods():
    with pytest.raises(InputError, match="adaptive"):
        simulate(soft_film(), method=CentralDifference(), time_step=1e-3, end_time=0.1, adaptive=Adaptive())
