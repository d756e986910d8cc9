"""Rigid bodies at nodes: against closed forms, the rigid body they are part of, and models made of them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import tautflex as tf
from tautflex import InputError, MeshError, PointMass
from verification.decks import ALUMINIUM, TUBE, beam_frequency, tip_mass_frequency

NODES = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
LINES = np.column_stack([np.arange(10), np.arange(1, 11)])


def mast(*masses, section=TUBE, held=(0,)):
    supports = [tf.Support.clamped(held)] if held else []
    return tf.Model.from_mesh(NODES, beams=LINES, beam=section, supports=supports, masses=masses)


def test_cantilever_with_tip_mass(verification_row):
    model = mast(PointMass(10, 2.5))
    found, wanted = tf.solve_modes(tf.solve_prestress(model), n=1).frequencies[0], tip_mass_frequency(2.5 / 0.27)
    verification_row("cantilever with a tip mass of 9.26 times its own [Hz]", wanted, found, "closed form")
    assert found == pytest.approx(wanted, rel=1e-6)
    assert wanted == pytest.approx(1.3147, abs=5e-5)
    assert model.mass == pytest.approx(2.77)
    assert "2.5 kg in 1 of its nodes" in repr(model)


def test_body_with_inertia_and_offset_on_a_light_beam(verification_row):
    """Six modes of a body at the tip of a beam without mass, from the beam's 6 x 6 stiffness."""
    light = tf.BeamSection(tf.Material(7e10, 1e-7, 0.33), 1e-4, 8e-10, 5e-10, 1.4e-9)
    inertia, offset, mass = (
        np.array([[0.3, 0.02, -0.01], [0.02, 0.2, 0.03], [-0.01, 0.03, 0.25]]),
        [0.1, 0.05, -0.2],
        2.0,
    )
    stretch, twist = 7e10 * 1e-4, ALUMINIUM.shear_modulus * 1.4e-9
    stiffness = np.diag([stretch, 12 * 7e10 * 5e-10, 12 * 7e10 * 8e-10, twist, 4 * 7e10 * 8e-10, 4 * 7e10 * 5e-10])
    stiffness[1, 5] = stiffness[5, 1] = -6 * 7e10 * 5e-10
    stiffness[2, 4] = stiffness[4, 2] = 6 * 7e10 * 8e-10
    x, y, z = offset
    lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    rigid = np.block([[mass * np.eye(3), mass * lever], [mass * lever.T, inertia + mass * lever.T @ lever]])
    wanted = np.sqrt(eigh(stiffness, rigid, eigvals_only=True)) / (2.0 * np.pi)
    state = tf.solve_prestress(mast(PointMass(10, mass, inertia, offset), section=light))
    found = tf.solve_modes(state, n=6).frequencies
    worst = float(np.abs(found / wanted - 1.0).max())
    verification_row(
        "six modes of a body with inertia and offset on a light cantilever", 0.0, worst, "6 x 6 eigenproblem"
    )
    assert worst < 1e-5


@pytest.mark.parametrize("inertia", [0.7, (0.1, 0.2, 0.25), (0.5, 0.0, 0.0), np.diag([0.1, 0.2, 0.25]) + 0.01])
@pytest.mark.parametrize("mass", [1.5, 0.0])
def test_the_rigid_body_has_their_mass_and_inertia(inertia, mass):
    """Rigid motions weigh 1/2 m v^2 + 1/2 w J w, whether the moments are those of a real body or one alone."""
    offset = np.array([0.3, -0.2, 0.1]) if mass else np.zeros(3)
    plain, model = mast(held=()), mast(PointMass(4, mass, inertia, offset), held=())
    operators = [tf.solve_prestress(one).system.inertia for one in (plain, model)]
    body, whole = (plain.rigid_motions.T @ one.mass_matrix @ plain.rigid_motions for one in operators)
    centre = NODES[4] + offset
    tensor = np.asarray(inertia) * np.eye(3) if np.ndim(inertia) < 2 else np.asarray(inertia)
    about = tensor + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    x, y, z = mass * centre
    lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    np.testing.assert_allclose(whole - body, np.block([[mass * np.eye(3), lever], [lever.T, about]]), atol=1e-14)
    assert operators[1].mass - operators[0].mass == pytest.approx(mass, abs=1e-14)
    np.testing.assert_allclose(operators[1].mass_moment - operators[0].mass_moment, mass * centre, atol=1e-14)
    second = operators[1].second_moment - operators[0].second_moment
    np.testing.assert_allclose(np.trace(second) * np.eye(3) - second, about, atol=1e-14)


def test_a_rod_of_points_is_a_beam_without_mass(verification_row):
    """The mass of the mast on its nodes alone: order 2 towards the beam with mass spread."""
    light = tf.BeamSection(tf.Material(7e10, 1e-9, 0.33), 1e-4, 8.33e-10, 8.33e-10, 1.4e-9)
    errors = []
    for count in (10, 20, 40):
        nodes = np.column_stack([np.linspace(0.0, 1.0, count + 1), np.zeros((count + 1, 2))])
        lumps = [PointMass(k, 0.27 / count * (0.5 if k == count else 1.0)) for k in range(1, count + 1)]
        lines = np.column_stack([np.arange(count), np.arange(1, count + 1)])
        model = tf.Model.from_mesh(nodes, beams=lines, beam=light, supports=[tf.Support.clamped([0])], masses=lumps)
        errors.append(
            tf.solve_modes(tf.solve_prestress(model), n=1).frequencies[0] / beam_frequency(1.87510407**2) - 1.0
        )
    order = float(np.log2(errors[1] / errors[2]))
    verification_row(
        "mass of a cantilever lumped to its nodes: order of the first frequency", 2.0, order, "observed order"
    )
    assert order == pytest.approx(2.0, abs=0.05)


def test_inertial_loads_act_on_the_bodies():
    """A steady turn pulls m r w^2 out of the tip: the axial displacement of a light beam is m w^2 L^2 / (E A)."""
    light = tf.BeamSection(tf.Material(7e10, 1e-9, 0.33), 1e-4, 8.33e-10, 8.33e-10, 1.4e-9)
    state = tf.solve_prestress(mast(PointMass(10, 2.5), section=light))
    load = state.system.inertia.load(-np.diag([9.0, 9.0, 0.0]))  # (S(w))^2 for 3 rad/s about z
    force = -state.system.full(load)[state.model.translation_dofs[10]]
    np.testing.assert_allclose(force, [2.5 * 1.0 * 9.0, 0.0, 0.0], atol=1e-9)
    assert state.system.load_moments({"beam": 1.0, "mass": 0.5}).load(-np.diag([9.0, 9.0, 0.0])).min() == pytest.approx(
        -0.5 * 22.5, rel=1e-6
    )


def test_runs_and_reduced_models_carry_them():
    """Stop of a mast with a payload: the reduced model follows the full one, the energy balance closes."""
    state = tf.solve_prestress(mast(PointMass(10, 0.5, (1e-3, 2e-3, 2e-3), (0.05, 0.0, 0.0))))
    maneuver = tf.Stop(rate=0.2, duration=0.5, axis=(0.0, 1.0, 0.0))
    given = {"time_step": 1e-3, "end_time": 0.6, "probes": {"tip": (1.0, 0.0)}}
    full = tf.simulate(state, maneuver, damping=tf.Rayleigh(alpha=0.1), **given)
    reduced = tf.simulate(
        tf.reduce(state, tf.ModalBasis(("ry",), count=4)), maneuver, damping=tf.Rayleigh(alpha=0.1), **given
    )
    one, other = (run.data["w"].sel(probe="tip").values for run in (full, reduced))
    assert np.abs(one - other).max() < 1e-3 * np.abs(one).max()
    by_kind = tf.simulate(state, maneuver, damping=tf.Rayleigh(alpha={"frame": 0.1}), **given)
    assert np.abs(by_kind.data["w"].sel(probe="tip").values - one).max() > 1e-4 * np.abs(one).max()


def test_a_free_hub_that_carries_them(verification_row):
    """Energy is that of the start, and the momenta too, whatever the body's offset and inertia."""
    body = PointMass(10, 0.5, (1e-3, 2e-3, 2e-3), (0.05, 0.02, -0.03))
    run = tf.simulate(
        tf.solve_prestress(mast(body)),
        tf.FreeHub(mass=5.0, inertia=(1.0, 1.2, 1.4)),
        method=tf.EnergyConserving(),
        initial_velocity=lambda x, y: 0.2 * x,
        time_step=2e-3,
        end_time=0.3,
        probes={"tip": (1.0, 0.0)},
    )
    balance = run.energy_balance
    lost = abs(balance["kinetic"] + balance["strain"] - balance["initial"]) / balance["initial"]
    verification_row("free hub with a boom and a payload: energy lost, of the first", 0.0, lost, "conservation")
    assert lost < 1e-7
    for name in ("linear_momentum", "angular_momentum"):
        values = run.data[name].values
        assert np.abs(values - values[0]).max() < 1e-6 * np.abs(values).max()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"mass": -1.0}, "mass"),
        ({}, "neither"),
        ({"inertia": (1.0, -0.1, 1.0)}, "moments >= 0"),
        ({"mass": 1.0, "inertia": [[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]}, "symmetric"),
        ({"inertia": 1.0, "offset": (1.0, 0.0, 0.0)}, "without mass"),
        ({"mass": 1.0, "offset": (1.0, 0.0)}, "offset"),
    ],
)
def test_bodies_that_do_not_exist(given, words):
    with pytest.raises(InputError, match=words):
        PointMass(0, **given)


def test_bodies_that_nothing_carries():
    film = {"triangles": [[0, 1, 2]], "membrane": tf.MembraneSection(ALUMINIUM, 1e-4)}
    corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    assert tf.Model.from_mesh(corners, **film, masses=[PointMass(1, 2.0)]).mass == pytest.approx(2.0 + 0.5 * 0.27)
    with pytest.raises(MeshError, match=r"body without inertia and offset at node 1, which no beam turns"):
        tf.Model.from_mesh(corners, **film, masses=[PointMass(1, 2.0, 0.1)])
    with pytest.raises(MeshError, match="masses"):
        tf.Model.from_mesh(corners, **film, masses=[PointMass(3, 2.0)])
    with pytest.raises(InputError, match="masses"):
        tf.Model.from_mesh(corners, **film, masses=[2.0])
