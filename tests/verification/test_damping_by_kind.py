"""Rayleigh's factors by kind of element: one matrix in every model, and closed forms of the damped modes.

[CP] Clough & Penzien, Dynamics of Structures, 2nd ed., 12-4: a mode in proportion to whose stiffness C is has beta w/2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError
from tautflex.case import parse_case, template
from tautflex.mechanics.products import MassDamping
from verification.batch_cases import changed_rom
from verification.dynamic_cases import TINY_VELOCITY, small_antenna, string

ALPHA = {"membrane": 0.3, "frame": 0.1}
BETA = {"membrane": 2e-3, "cable": 1e-4, "frame": 1e-3}
DAMPING = tf.Rayleigh(ALPHA, BETA)
STOP = tf.Stop(0.6, 0.04)
OPTIONS = {"time_step": 2e-3, "end_time": 0.06, "probes": {"A": (0.6, 0.3)}, "tolerance": 1e-12}


@pytest.fixture(scope="module")
def antenna():
    return tf.solve_prestress(small_antenna())


@pytest.fixture(scope="module")
def rom(antenna):
    return tf.reduce(antenna, tf.ModalBasis(directions=("rx",), count=3), weak_field=0.0)


def dense(state, entries):
    return state.system.pattern.symmetric_matrix(entries).toarray()


def assembled(state, factors, stress_factor):
    """``sum_e factors_e K_e + stress_factor K_0``, element by element from the blocks' rows, shape (size, size)."""
    size = state.system.size
    result = np.zeros((size + 1, size + 1))
    for block, stress, places in zip(state.system.blocks, state.stress, state.system.row_places, strict=True):
        for row, where in enumerate(places):
            g = block.gradient[row]
            material = block.linear.T @ block.elasticity[row] @ block.linear
            geometric = np.einsum("s,sij->ij", stress[row], block.quadratic)
            own = factors.get(block.kind, 0.0) * material + stress_factor * geometric
            result[np.ix_(where, where)] += block.measure[row] * (g.T @ own @ g)
    return result[:size, :size]


def by_hand(state):
    """C of DAMPING without the code that makes it."""
    mass = 0.3 * state.system.inertia_of("membrane").mass_matrix + 0.1 * state.system.inertia_of("beam").mass_matrix
    return mass.toarray() + assembled(state, {"membrane": 2e-3, "cable": 1e-4, "beam": 1e-3}, 2e-3)


def full_matrix(state, damping):
    return dense(state, state.linear.entries(damping.matrix(state.linear)))


def test_one_number_for_all_is_the_same_to_the_digit(antenna):
    """Also where it stands kind by kind."""
    expected = 0.3 * antenna.system.inertia.mass_entries + 2e-3 * antenna.tangent_entries
    kinds = dict.fromkeys(("membrane", "cable", "frame"), 2e-3)
    for damping in (tf.Rayleigh(0.3, 2e-3), tf.Rayleigh(0.3, kinds)):
        matrix = damping.matrix(antenna.linear)
        np.testing.assert_array_equal(antenna.linear.entries(matrix), expected)
    products = MassDamping(
        antenna.system.pattern, antenna.system.inertia.mass_entries, antenna.tangent_entries,
        tf.Rayleigh(0.3, 2e-3).matrix(antenna.linear),
    )  # fmt: skip
    np.testing.assert_array_equal(products.entries, expected)


def test_the_matrix_is_that_assembled_by_hand(antenna, verification_row):
    expected = by_hand(antenna)
    error = float(np.abs(full_matrix(antenna, DAMPING) - expected).max() / np.abs(expected).max())
    assert error < 1e-14
    verification_row("damping by kind of element: C", 0, error, "assembled element by element")


def test_elements_of_many_points_and_from_outside_have_it_too(antenna, verification_row):
    """Four integration points an element; an element's kind is that of its section, whoever declares it."""
    text = template("m2-nearest-node").replace('pattern = "regular"', "# none")
    small = ("mesh.divisions=[4,2]", "cables.per_long_edge=5", "cables.per_short_edge=3", "mesh.element='quad4'")
    state = tf.solve_prestress(tf.build_model(parse_case(text, small)))
    expected = by_hand(state)
    error = float(np.abs(full_matrix(state, DAMPING) - expected).max() / np.abs(expected).max())
    assert error < 1e-14
    verification_row("damping by kind, quadrilaterals: C", 0, error, "assembled point by point")


def test_the_kinds_and_the_prestress_make_the_stiffness(antenna):
    for law in ("elastic", "tension-field"):
        state = tf.solve_prestress(small_antenna()) if law == "elastic" else wrinkling()
        material = sum(stiffness for _, stiffness in state.linear.by_kind.values())
        unit = dict.fromkeys(("membrane", "cable", "frame"), 1e-3)
        total = state.linear.entries(tf.Rayleigh(0.0, unit | {"membrane": 0.0}).matrix(state.linear))
        own = 1e-3 * (material - state.linear.by_kind["membrane"][1])
        np.testing.assert_allclose(total, own, rtol=0, atol=1e-15 * np.abs(state.tangent_entries).max())
        stressed = dense(state, state.tangent_entries - material)
        difference = stressed - assembled(state, {}, 1.0)
        assert np.abs(difference).max() < 1e-14 * np.abs(state.tangent_entries).max()


def wrinkling():
    """The same antenna whose film may wrinkle; it is taut, so that its matrices are those of the elastic law."""
    model = small_antenna()
    groups = tuple(
        tf.ElementGroup(
            tf.MembraneSection(g.section.material, g.section.thickness, law="tension-field"), g.shape, g.connectivity,
            g.initial, g.orientation,
        )
        if g.section.kind == "membrane"
        else g
        for g in model.groups
    )  # fmt: skip
    return tf.solve_prestress(replace(model, groups=groups))


def test_modes_of_a_string_have_their_closed_form(verification_row):
    """Its axial modes are stretched (cable), its transverse ones turned (prestress); each feels its own factor."""
    state, beta = string(6), 0.01
    modes = tf.solve_modes(state, n=14)
    size = np.abs(modes.shapes).max(axis=1)
    axial = size[:, 0] > 0.5 * size.max(axis=1)
    assert axial.sum() == 4
    for kind, felt in (("cable", axial), ("membrane", ~axial)):
        expected = np.where(felt, 0.5 * beta * 2.0 * np.pi * modes.frequencies, 0.0)
        damping = tf.Rayleigh(0.0, {kind: beta})
        ratio = tf.appendage_data(modes, damping=damping).damping_ratio.values
        spinning = tf.solve_spinning_modes(state, (0.0, 0.0, 0.0), n=14, damping=damping)
        error = float(max(np.abs(ratio - expected).max(), np.abs(spinning.damping_ratios - expected).max()))
        assert error < 1e-9
        verification_row(f"ratios of a string's modes, beta of {kind} alone", 0, error, "[CP] 12-4, beta w / 2")


def test_spinning_modes_are_those_of_the_dense_matrices(antenna, verification_row):
    mass = antenna.system.inertia.mass_matrix.toarray()
    stiffness, damping = dense(antenna, antenna.tangent_entries), by_hand(antenna)
    n = len(mass)
    inverse = np.linalg.inv(mass)
    companion = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    exact = np.linalg.eigvals(companion)
    exact = exact[exact.imag > 1e-6]
    exact = exact[np.argsort(np.abs(exact))][:6]
    found = tf.solve_spinning_modes(antenna, (0.0, 0.0, 0.0), n=6, damping=DAMPING).eigenvalues
    error = float(np.abs(found - exact).max() / np.abs(exact).max())
    assert error < 1e-7
    verification_row("eigenvalues of the antenna damped by kind, at rest", 0, error, "dense pencil")


def test_the_reduced_matrices_are_the_projected_ones(antenna, rom, verification_row):
    """On coordinates ``V' C V``, on static derivatives ``E' C_pp E`` of the stiffness part."""
    c, vectors = rom.coefficients, rom.basis
    moving = vectors.kept + c.follow_linear.T @ vectors.derivatives
    following = c.follow_quadratic.T @ vectors.derivatives
    arrays = rom.arrays(DAMPING)
    own = moving @ by_hand(antenna) @ moving.T
    viscous = following @ full_matrix(antenna, tf.Rayleigh(0.0, BETA)) @ following.T
    errors = [
        float(np.abs(found - expected).max() / np.abs(expected).max())
        for found, expected in ((arrays.damping, own), (arrays.viscous.T @ arrays.viscous, viscous))
    ]
    assert max(errors) < 1e-9
    verification_row("damping by kind of a reduced model: its matrices", 0, max(errors), "projected C")


def test_full_and_reduced_model_agree(antenna, verification_row):
    """Large motion; with one number for all the record is a tenth and more away."""
    rom = tf.reduce(antenna, tf.ModalBasis(directions=("rx",), count=12), weak_field=0.0)
    options = {**OPTIONS, "end_time": 0.2, "method": tf.Newmark()}
    full, reduced, other = (
        tf.simulate(plant, STOP, damping=damping, **options).data.w.values
        for plant, damping in ((antenna, DAMPING), (rom, DAMPING), (rom, tf.Rayleigh(0.3, 2e-3)))
    )
    apart = float(np.abs(full - reduced).max() / np.abs(full).max())
    assert apart < 0.02
    assert np.abs(full - other).max() > 5 * apart * np.abs(full).max()
    verification_row("reduced model damped by kind: large motion", 0, apart, "full model")


def test_hyper_reduced_model_has_the_projected_matrix(antenna):
    options = {**OPTIONS, "method": tf.Newmark(), "damping": DAMPING}
    run = tf.simulate(antenna, STOP, fields="all", **options)
    rom = tf.hyper_reduce(antenna, run.data, tolerance=0.0, lost=(1e-10, 1e-10))
    expected = rom.basis.kept @ by_hand(antenna) @ rom.basis.kept.T
    np.testing.assert_allclose(rom.arrays(DAMPING).damping, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    reduced = tf.simulate(rom, STOP, **options).data.w.values
    assert np.abs(reduced - run.data.w.values).max() < 1e-3 * np.abs(run.data.w.values).max()


def test_a_curved_reduced_model_is_refused():
    """There the coordinates' rates would push the static derivatives, which no reduced model here has."""
    bent = small_antenna()
    nodes = bent.nodes.copy()
    nodes[:, 2] = 0.05 * nodes[:, 0] ** 2 + 0.03 * nodes[:, 0] * nodes[:, 1]
    state = tf.solve_prestress(replace(bent, nodes=nodes), check=False)
    rom = tf.reduce(state, tf.ModalBasis(directions=("rx",), count=3))
    with pytest.raises(tf.UnsupportedError, match="damping: expected one alpha and one beta for all kinds"):
        tf.simulate(rom, STOP, damping=DAMPING, **OPTIONS)
    tf.simulate(rom, STOP, damping=tf.Rayleigh(0.3, 2e-3), **OPTIONS)


@pytest.mark.parametrize("kind", ["reduced", "explicit", "full"])
@pytest.mark.jax
def test_batches_are_the_single_runs(antenna, rom, kind, verification_row):
    """Numbers by kind that differ from run to run, tensions and moduli too; loads by kind."""
    plant = antenna if kind == "full" else rom
    method = {"method": tf.CentralDifference() if kind == "explicit" else tf.Newmark()}
    coupling = tf.Coupling(inertial_load={"membrane": 0.5, "cable": 1.0, "frame": 0.7})
    options = {**OPTIONS, **method, "coupling": coupling}
    numbers = {"damping.beta.cable": [1e-4, 5e-4], "damping.alpha.beam": [0.1, 0.4]}
    changed = {} if kind == "full" else {"youngs_modulus.cable": [1.0, 1.1]}
    data = tf.Batch(plant).simulate(numbers | changed, STOP, damping=DAMPING, **options)
    twin = tf.Rayleigh(ALPHA | {"frame": 0.4}, BETA | {"cable": 5e-4})
    plants = plant, plant if kind == "full" else changed_rom(plant, {"youngs_modulus.cable": 1.1})
    singles = [
        tf.simulate(one, STOP, damping=damping, **options).data
        for one, damping in zip(plants, (DAMPING, twin), strict=True)
    ]
    assert np.abs(singles[0].w.values - singles[1].w.values).max() > 1e-4 * np.abs(singles[0].w.values).max()
    names = ("w", "w_velocity", "kinetic_energy", "strain_energy")
    found = max(
        float(np.abs(data.isel(run=run)[n].values - one[n].values).max() / np.abs(one[n].values).max())
        for run, one in enumerate(singles)
        for n in names
    )
    assert found < (1e-9 if kind == "full" else 1e-11)
    verification_row(f"batch damped by kind, {kind}, against single runs", 0, found, "single runs")
    if kind == "reduced":
        with pytest.raises(InputError, match=r"beta\.cable: expected a number >= 0, got -1"):
            tf.Batch(plant).simulate({"damping.beta.cable": [-1.0]}, STOP, damping=DAMPING, **options)
        with pytest.raises(InputError, match=r"damping\.beta\.membrane"):
            tf.Batch(plant).simulate({"damping.beta": [1e-3]}, STOP, damping=DAMPING, **options)


def test_wrong_numbers_by_kind_are_refused():
    with pytest.raises(InputError, match="beta: expected kinds of element, each once, of membrane, cable, frame, got"):
        tf.Rayleigh(beta={"film": 1e-3})
    with pytest.raises(InputError, match="alpha: expected kinds of element, each once"):
        tf.Rayleigh(alpha={"frame": 1.0, "beam": 2.0})
    with pytest.raises(InputError, match=r"beta\.cable: expected a number >= 0, got -0\.1"):
        tf.Rayleigh(beta={"cable": -0.1})
    with pytest.raises(InputError, match="beta: expected a number for some kind"):
        tf.Rayleigh(beta={})
    assert tf.Rayleigh(beta={"frame": 1e-3}) == tf.Rayleigh(beta={"beam": 1e-3})
    assert len({tf.Rayleigh(beta={"frame": 1e-3}), tf.Rayleigh(beta={"beam": 1e-3})}) == 1


def test_tiny_motion_of_an_undamped_kind_keeps_its_energy():
    """A string's transverse motion under its own beta alone."""
    state = string(6)
    modes = tf.solve_modes(state, n=1)
    run = tf.simulate(
        state, method=tf.Newmark(), time_step=0.01, end_time=2.0, damping=tf.Rayleigh(0.0, {"cable": 0.1}),
        initial_velocity=TINY_VELOCITY * modes.shapes[0],
    ).data  # fmt: skip
    energy = (run.kinetic_energy + run.strain_energy).values
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-6
