"""Inputs in time on reduced models: tension, temperature, pressure through the structure's own answer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import PreparedInput, TimeInput
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.reduction.inputs import ReducedInputs
from tautflex.reduction.marching.dispatch import internal_force
from tautflex.reduction.polynomial.forces import energies, strain_energies
from tautflex.reduction.polynomial.strains import stress_loads
from tautflex.solvers.static.across import transverse_unknowns
from verification.dynamic_cases import small_antenna, soft_film, string
from verification.test_reduced_model import Given, complete_basis

pytestmark = pytest.mark.slow

JUMP = 0.0331


def softened(model, factor):
    """Cables of the same tension whose stiffness is a part of theirs."""

    def soft(group):
        material = group.section.material
        slow = replace(material, youngs_modulus=material.youngs_modulus / factor)
        return replace(group, section=replace(group.section, material=slow))

    return replace(
        model, groups=tuple(soft(group) if group.section.kind == "cable" else group for group in model.groups)
    )


def antenna(soft=1.0, divisions=(4, 2), strain="von-karman"):
    return tf.solve_prestress(softened(small_antenna(divisions, strain), soft))


def cables_along(state, axis):
    ends = state.model.nodes[state.model.cables]
    along = np.abs(ends[:, 1] - ends[:, 0])
    return [int(cable) for cable in np.flatnonzero(along[:, axis] > along[:, 1 - axis])]


def actuators(state):
    """One number each: all cables along x, those along y, the film's temperature."""
    return [*(tf.CableTension(1.0, cables_along(state, axis)) for axis in (0, 1)), tf.MembraneTemperature(1.0, 1e-5)]


def reduced_inputs(rom, inputs):
    return ReducedInputs(rom, InputSet(rom.state.system, inputs))


def stressed_force(state, q, columns, u):
    """Internal force of the full structure above the reference, its stresses changed."""
    workspace = state.system.workspace()
    workspace.change_initial_stress({number: column @ u for number, column in columns.items()})
    return workspace.force(q)[0] - state.reference_force


@pytest.mark.parametrize("method", [tf.GeneralizedAlpha(0.8), tf.EnergyConserving(), tf.CentralDifference()], ids=str)
@pytest.mark.parametrize("kind", ["tension", "temperature"])
def test_a_complete_basis_is_the_full_model(method, kind, verification_row):
    if kind == "tension":
        state, size = string(8, strain="green-lagrange", density=1.0), 0.4
        inputs = [tf.CableTension(lambda t: size if t < JUMP else -size * np.cos(20.0 * t), breaks=(JUMP,))]
        if isinstance(method, tf.GeneralizedAlpha):  # of a jump the full model takes up what its steps resolve
            inputs = [tf.CableTension(lambda t: size * np.sin(20.0 * t))]
        probes, velocity = {"A": (0.375, 0.0, 0.0)}, lambda x, y: 0.05 * np.sin(np.pi * x)
    else:
        state, size = soft_film((3, 2), strain="green-lagrange"), 1e-3
        inputs = [tf.MembraneTemperature(lambda t: size if t < JUMP else -size * np.cos(20.0 * t), 1.0, (JUMP,))]
        probes = {"A": (0.25, 0.1)}

        def velocity(x, y):
            return 0.05 * np.cos(np.pi * x) * np.cos(np.pi * y / 0.8)

    rom = tf.reduce(state, Given(complete_basis(state)), weak_field=0.0)
    given = {"time_step": 1e-3, "end_time": 0.1, "method": method, "inputs": inputs, "probes": probes}
    given |= {"initial_velocity": velocity, "damping": tf.Rayleigh(0.1, 1e-4)}
    given |= {} if isinstance(method, tf.CentralDifference) else {"tolerance": 1e-10}
    full, reduced = (tf.simulate(plant, **given) for plant in (state, rom))
    without = tf.simulate(rom, **{**given, "inputs": []})
    for name in ("w", "w_velocity", "strain_energy", "kinetic_energy"):
        a, b = full.data[name].values, reduced.data[name].values
        assert np.abs(a - b).max() < 1e-7 * np.abs(a).max(), name
    effect = float(np.abs(without.data.w - full.data.w).max() / np.abs(full.data.w).max())
    assert effect > 1e-3
    error = float(np.abs(full.data.w - reduced.data.w).max() / np.abs(full.data.w).max())
    verification_row(f"reduced model with a complete basis, {kind}, {method.name}: w against full", 0, error, "exact")
    balance = reduced.energy_balance
    total = max(abs(value) for value in balance.values())
    assert abs(balance["residual"]) < 1e-8 * total
    assert balance["loads"] == pytest.approx(full.energy_balance["loads"], abs=0.02 * total)


@pytest.mark.parametrize("soft", [1.0, 1e3])
def test_stiffness_is_the_derivative_of_the_full_tangent(soft, verification_row):
    """K_tan is quadratic along the answer, so that a central difference over any distance is exact."""
    state = antenna(soft, strain="green-lagrange")
    rom = tf.reduce(state, tf.ModalBasis(count=4))
    inputs = reduced_inputs(rom, actuators(state))
    worst = 0.0
    for k, (answer, stiffness) in enumerate(zip(inputs.answers, inputs.stiffness, strict=True)):
        for size in (1.0, 3.0):
            ends = []
            for s in (size, -size):
                workspace = state.system.workspace()
                workspace.change_initial_stress({at: s * column[..., k] for at, column in inputs.columns.items()})
                matrix = state.system.pattern.symmetric_matrix(workspace.tangent(s * answer))
                ends.append(rom.basis.kept @ (matrix @ rom.basis.kept.T))
            difference = (ends[0] - ends[1]) / (2.0 * size)
            worst = max(worst, float(np.abs(difference - stiffness).max() / np.abs(difference).max()))
    assert worst < 1e-8
    verification_row(f"stiffness per unit of input, cables {soft:g} times softer", 0, worst, "tangent's difference")


def test_a_flat_antenna_is_not_pushed_by_its_tension(verification_row):
    state = antenna()
    rom = tf.reduce(state, tf.ModalBasis(count=6, derivatives="none"))
    inputs = reduced_inputs(rom, actuators(state))
    pulls = stress_loads(state.system, inputs.columns)
    assert not pulls[:, transverse_unknowns(state)].any()
    # What is left is the round-off of the modes in the plane.
    worst = float(np.abs(inputs.beta).max() / np.linalg.norm(pulls, axis=1).min() / np.linalg.norm(rom.basis.kept))
    assert worst < 1e-13
    verification_row("force of tension on transverse modes of a flat antenna", 0, worst, "symmetry")


@pytest.mark.parametrize("soft", [1.0, 1e3])
def test_the_condensed_answer_is_exact_for_a_flat_antenna(soft, verification_row):
    """At ``q = kept eta + E y + u psi`` nothing is left in the plane, and the forces on all coordinates agree."""
    state = antenna(soft, (2, 2))
    rom = tf.reduce(state, tf.ModalBasis(count=8, directions=("z", "rx", "ry")), weak_field=0.0)
    inputs, u = reduced_inputs(rom, actuators(state)), np.array([0.7, -0.5, 0.02])
    eta = rom.basis.amplitude * np.random.default_rng(3).standard_normal(rom.size)
    eta *= 2e-3 / np.abs(rom.displacement(eta)).max()
    q = rom.displacement(eta) + u @ inputs.answers
    full = stressed_force(state, q, inputs.columns, u)
    arrays, force = inputs.arrays(tf.Rayleigh()), np.empty(rom.size)
    load, given = inputs.driven(u[None])
    internal_force(arrays, eta, np.zeros(rom.size), given[0], force)
    wanted, change = rom.basis.kept @ full, stressed_force(state, q, inputs.columns, 0.0 * u)
    error = float(np.abs(force + load[0] - wanted).max() / np.abs(wanted).max())
    # Cables that the answer moves sideways stretch in second order.
    assert error < 2e-7
    assert np.abs(rom.basis.kept @ (full - change)).max() > 1e-3 * np.abs(wanted).max()
    # The stored energy is that of the full structure, and its slope the force.
    workspace = state.system.workspace()
    workspace.change_initial_stress({number: column @ u for number, column in inputs.columns.items()})
    stored = workspace.strain_energy(q) - state.reference_force @ q
    own = strain_energies(arrays, eta[None], given)[0] + u @ inputs.beta @ eta + 0.5 * u @ inputs.own @ u
    assert own == pytest.approx(stored, rel=1e-5)
    verification_row(f"flat antenna, tension and heat, cables {soft:g} times softer: force", 0, error, "full model")


def _trained(state, inputs):
    run = tf.simulate(
        state, tf.Stop(rate=0.6, duration=0.2), inputs=inputs, time_step=2e-3, end_time=0.4, fields="all", every=4
    )
    return tf.hyper_reduce(state, run, tolerance=0.0)


def test_all_elements_take_the_stresses_in_their_rows(verification_row):
    """Whatever the law: force and energy are those of the full structure on the basis and the answer."""
    state = antenna(1e3)
    rom = _trained(state, [])
    inputs, u = reduced_inputs(rom, actuators(state)), np.array([0.3, -0.4, 0.02])
    eta = 1e-4 * np.random.default_rng(3).standard_normal(rom.size)
    q = eta @ rom.basis.kept + u @ inputs.answers
    arrays, force = inputs.arrays(tf.Rayleigh()), np.empty(rom.size)
    internal_force(arrays, eta, np.zeros(rom.size), u, force)
    wanted = rom.basis.kept @ stressed_force(state, q, inputs.columns, u)
    error = float(np.abs(force - wanted).max() / np.abs(wanted).max())
    assert error < 1e-12
    still = np.zeros((1, rom.size))
    for i in range(rom.size):
        move = 1e-7 * np.eye(rom.size)[i]
        ahead, behind = (strain_energies(arrays, (eta + s * move)[None], u[None])[0] for s in (1.0, -1.0))
        assert (ahead - behind) / 2e-7 == pytest.approx(force[i], rel=1e-6, abs=1e-7 * np.abs(force).max())
    before = energies(arrays, eta[None], still)[0, 1]
    plain = rom.arrays(tf.Rayleigh())
    assert before == pytest.approx(energies(plain, eta[None], still)[0, 1], rel=1e-12)
    verification_row("hyper-reduced antenna under tension and heat: force", 0, error, "full model")


def test_a_hyper_reduced_run_follows_switched_tension(verification_row):
    state = antenna(1e3)
    pull = tf.CableTension(lambda t: 0.6 if t < 0.1 or 0.2 < t < 0.3 else -0.6, cables_along(state, 1), (0.1, 0.2, 0.3))
    rom = _trained(state, [pull])
    given = {"maneuver": tf.Stop(rate=0.6, duration=0.2), "time_step": 2e-3, "end_time": 0.4, "inputs": [pull]}
    given |= {"method": tf.Newmark(), "tolerance": 1e-10, "probes": {"A": (0.3, 0.2)}}
    full, reduced = (tf.simulate(plant, **given) for plant in (state, rom))
    wanted = full.data.w.values
    error = float(np.sqrt(np.mean((reduced.data.w.values - wanted) ** 2) / np.mean(wanted**2)))
    plain = tf.simulate(state, **{**given, "inputs": []}).data.w.values
    assert np.sqrt(np.mean((plain - wanted) ** 2) / np.mean(wanted**2)) > 0.1
    assert error < 0.02
    total = max(abs(value) for value in reduced.energy_balance.values())
    assert abs(reduced.energy_balance["residual"]) < 1e-8 * total
    verification_row("hyper-reduced antenna, switched tension: rms of the record", 0, error, "full model")


def test_a_slow_answer_becomes_a_coordinate():
    state = antenna(1e5)
    inputs = [tf.CableTension(lambda t: 30.0 * t, cables_along(state, axis)) for axis in (0, 1)]
    basis = Given(replace(tf.ModalBasis(count=4).vectors(state), fast=2.0 * np.pi * 40.0))
    given = {"time_step": 1e-3, "end_time": 0.02, "inputs": inputs, "method": tf.Newmark()}
    fast = tf.reduce(state, basis)
    said = tf.simulate(fast, **given).data.attrs["warnings"]
    assert any("answers CableTension number 2 in 0.0082 s" in text and "inputs=[...]" in text for text in said)
    slow = tf.reduce(state, basis, inputs=inputs)
    assert slow.size == fast.size + 4
    assert "4 answers to inputs" in repr(slow)
    assert not any("answers" in text for text in tf.simulate(slow, **given).data.attrs["warnings"])
    # What was condensed stays in equilibrium beside the new coordinates.
    beside = slow.basis.kept @ slow.reference.multiply(slow.basis.derivatives).T
    assert np.abs(beside).max() < 1e-6 * np.sqrt(slow.reference.energies(slow.basis.kept).max())


def test_pressure_on_a_reduced_film(verification_row):
    """Dead but for parts of second order; the check says how much of it is left out."""
    state = soft_film((6, 5))
    rom = tf.reduce(state, tf.ModalBasis(directions=("z",), count=12))
    push = tf.Pressure(lambda time: 0.5 * np.sin(30.0 * time))
    given = {"time_step": 1e-3, "end_time": 0.3, "inputs": [push], "probes": {"A": (0.0, 0.0)}, "method": tf.Newmark()}
    full, reduced = (tf.simulate(plant, **given).data for plant in (state, rom))
    error = float(np.abs(full.w - reduced.w).max() / np.abs(full.w).max())
    assert error < 0.02
    assert float(reduced.truncated_energy.max()) < 0.02
    verification_row("film under pressure, 12 modes: w at the centre", 0, error, "full model")


@dataclass(frozen=True)
class Warmed(PreparedInput):
    """An own input that says its stress at every instant, and nothing more."""

    def stress(self, time):
        return {}


@dataclass(frozen=True)
class Own(TimeInput):
    def prepare(self, system):
        return Warmed()


def test_stress_without_columns_is_refused_by_name():
    rom = tf.reduce(soft_film((3, 2)), tf.ModalBasis(directions=("z",), count=2))
    with pytest.raises(tf.UnsupportedError, match=r"expected columns of stress .* got Own number 1, .* StressChange"):
        tf.simulate(rom, time_step=1e-3, end_time=2e-3, inputs=[Own()])
