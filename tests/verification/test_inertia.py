"""The inertia operator M(Z) against closed forms of mass matrices, rigid inertia and inertial loads."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tautflex import BeamSection, CableSection, Material, MembraneSection, Model
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import cross_matrix
from verification.builders import antenna, beam_line, rotation

Array = NDArray[np.float64]

DENSITY, THICKNESS, AREA = 1530.0, 3e-4, 5e-6
MATERIAL = Material(1e9, DENSITY, 0.3)
BEAM = BeamSection(MATERIAL, 4e-4, 5e-8, 2e-8, 3e-8)
LENGTH = 1.3
CORNERS = np.array([[0.1, -0.2, 0.3], [1.4, 0.3, -0.1], [0.4, 1.1, 0.6]])
W = np.array([0.7, -1.3, 0.4])


def triangle() -> Model:
    return Model.from_mesh(CORNERS, triangles=[[0, 1, 2]], membrane=MembraneSection(MATERIAL, THICKNESS))


def cable() -> Model:
    return Model.from_mesh(CORNERS[:2], cables=[[0, 1]], cable=CableSection(MATERIAL, AREA))


def mixed(strain: str = "von-karman") -> Model:
    """A bent patch of film, two cables and three beams in general position, all free."""
    nodes = np.random.default_rng(3).standard_normal((7, 3))
    return Model.from_mesh(
        nodes,
        triangles=[[0, 1, 2], [1, 2, 3]],
        membrane=MembraneSection(MATERIAL, THICKNESS, strain),
        cables=[[3, 4], [0, 5]],
        cable=CableSection(MATERIAL, AREA, strain),
        beams=[[4, 5], [5, 6], [6, 4]],
        beam=BEAM,
        beam_orientation=(0.3, 0.5, 1.0),
    )


def operator(model: Model) -> InertiaOperator:
    return StructuralSystem.from_model(model).inertia


def random_matrix(seed: int) -> Array:
    return np.random.default_rng(seed).standard_normal((3, 3))


def close(got: Array, expected: Array, relative: float = 1e-13) -> None:
    np.testing.assert_allclose(got, expected, rtol=0.0, atol=relative * float(np.abs(expected).max()))


def test_triangle_has_its_consistent_mass_matrix(verification_row):
    area = 0.5 * np.linalg.norm(np.cross(CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0]))
    scalar = DENSITY * THICKNESS * area / 12.0 * (1.0 + np.eye(3))
    inertia = operator(triangle())
    for z in (np.eye(3), random_matrix(1)):
        got = inertia.matrix(z).toarray()
        close(got, np.kron(scalar, z))
    verification_row(
        "triangle, M(Z), largest error / largest entry",
        0.0,
        np.abs(got - np.kron(scalar, z)).max() / np.abs(got).max(),
        "rho hA/12 (1+δ) ⊗ Z",
    )


def test_cable_has_its_consistent_mass_matrix(verification_row):
    length = np.linalg.norm(CORNERS[1] - CORNERS[0])
    scalar = DENSITY * AREA * length / 6.0 * (1.0 + np.eye(2))
    inertia = operator(cable())
    for z in (np.eye(3), random_matrix(2)):
        got = inertia.matrix(z).toarray()
        close(got, np.kron(scalar, z))
    verification_row(
        "cable, M(Z), largest error / largest entry",
        0.0,
        np.abs(got - np.kron(scalar, z)).max() / np.abs(got).max(),
        "rho Al/6 (1+δ) ⊗ Z",
    )


def hermite_beam_mass() -> Array:
    """Textbook consistent mass matrix of a beam along x with polar inertia on the twist, 12 unknowns."""
    mass = DENSITY * BEAM.area * LENGTH
    result = np.zeros((12, 12))
    linear = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    result[np.ix_([0, 6], [0, 6])] = mass * linear
    result[np.ix_([3, 9], [3, 9])] = DENSITY * (BEAM.inertia_y + BEAM.inertia_z) * LENGTH * linear
    h = LENGTH
    bending = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    ) * (mass / 420.0)
    result[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])] = bending
    turned = np.array([1.0, -1.0, 1.0, -1.0])  # theta_y = -w'
    result[np.ix_([2, 4, 8, 10], [2, 4, 8, 10])] = bending * np.outer(turned, turned)
    return result


@pytest.mark.parametrize("seed", [None, 5])
def test_beam_has_its_hermite_mass_matrix(seed, verification_row):
    turn = np.eye(3) if seed is None else rotation(seed)
    got = operator(beam_line(BEAM, LENGTH, 1, turn=turn)).mass_matrix.toarray()
    blocks = np.kron(np.eye(4), turn)
    expected = blocks @ hermite_beam_mass() @ blocks.T
    close(got, expected)
    verification_row(
        f"beam, mass matrix, largest error / largest entry ({'along x' if seed is None else 'turned'})",
        0.0,
        np.abs(got - expected).max() / np.abs(expected).max(),
        "rho Al/420 (156, 22l, 54, …), rho(Iy+Iz)l/6",
    )


def test_operator_is_linear_and_transposes():
    inertia = operator(mixed())
    first, second = random_matrix(3), random_matrix(4)
    combined = inertia.matrix(2.0 * first - 3.0 * second).toarray()
    close(combined, 2.0 * inertia.matrix(first).toarray() - 3.0 * inertia.matrix(second).toarray())
    close(inertia.matrix(first.T).toarray(), inertia.matrix(first).toarray().T)


def test_gyroscopic_matrix_is_skew_and_centrifugal_matrix_symmetric():
    inertia = operator(mixed())
    spin = cross_matrix(W)
    gyroscopic, centrifugal = inertia.matrix(2.0 * spin).toarray(), inertia.matrix(spin @ spin).toarray()
    close(gyroscopic.T, -gyroscopic)
    close(centrifugal.T, centrifugal)
    # S(w)^2 = w w' - w^2 1 has eigenvalues -w^2, -w^2, 0: the matrix only softens.
    assert np.linalg.eigvalsh(centrifugal).max() < 1e-13 * np.abs(centrifugal).max()
    close(cross_matrix(W) @ CORNERS[0], np.cross(W, CORNERS[0]))


def closed_form_moments(model: Model) -> tuple[float, Array, Array]:
    """Mass, first moment and inertia tensor about the origin from exact integrals, element by element."""
    mass, moment, second = 0.0, np.zeros(3), np.zeros((3, 3))
    polar = np.zeros((3, 3))
    for group in model.groups:
        for corners in model.nodes[group.connectivity]:
            if group.section.kind == "membrane":
                area = 0.5 * np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
                piece = group.section.material.density * group.section.thickness * area
                factor = piece / 12.0
            else:
                span = corners[1] - corners[0]
                length = np.linalg.norm(span)
                piece = group.section.material.density * group.section.area * length
                factor = piece / 6.0
                if group.section.kind == "beam":
                    inertia = group.section.inertia_y + group.section.inertia_z
                    polar += group.section.material.density * inertia * np.outer(span, span) / length
            mass += piece
            moment += piece * corners.mean(axis=0)
            second += factor * (np.outer(corners.sum(axis=0), corners.sum(axis=0)) + corners.T @ corners)
    return mass, moment, np.trace(second) * np.eye(3) - second + polar


@pytest.mark.parametrize("name", ["mixed", "antenna"])
def test_rigid_motions_carry_the_rigid_inertia(name, verification_row):
    model = mixed() if name == "mixed" else antenna((0.6, 1.0), (6, 4), support="free")
    assert model.dof_count == StructuralSystem.from_model(model).size
    matrix = operator(model).mass_matrix
    rigid = model.rigid_motions.T @ (matrix @ model.rigid_motions)
    mass, moment, inertia = closed_form_moments(model)
    close(rigid[:3, :3], mass * np.eye(3))
    close(rigid[3:, 3:], inertia, 1e-12)
    # Velocity of a rotation is w x r, so the coupling block is -S(int rho r).
    np.testing.assert_allclose(rigid[:3, 3:], -cross_matrix(moment), atol=1e-12 * mass)
    velocity = model.rigid_motions @ np.concatenate([np.zeros(3), W])
    energy = 0.5 * velocity @ (matrix @ velocity)
    assert energy == pytest.approx(0.5 * W @ inertia @ W, rel=1e-12)
    operator_ = operator(model)
    assert operator_.mass == pytest.approx(mass, rel=1e-13)
    np.testing.assert_allclose(operator_.mass_moment, moment, atol=1e-13 * mass)
    label = "general structure" if name == "mixed" else "antenna"
    verification_row(f"{label}, mass [kg]", mass, rigid[0, 0], "exact integrals")
    verification_row(f"{label}, kinetic energy of a rotation [J]", 0.5 * W @ inertia @ W, energy, "½ω·Jω")


def test_antenna_mass_and_inertia_by_hand(verification_row):
    # Film 2 x 1, frame 2.5 x 1.5 (paper, Table 1), 6 + 10 cables of 0.25 m on each pair of edges.
    model = antenna((0.6, 1.0), (4, 2), support="free")
    film = 1530.0 * 1e-4 * 2.0
    per_cable = 1440.0 * 3.14e-6 * 0.25
    per_metre = 1380.0 * 5.24e-4
    mass = film + 16 * per_cable + 8.0 * per_metre
    assert operator(model).mass_matrix.shape == (model.dof_count, model.dof_count)
    assert operator(model).mass == pytest.approx(mass, rel=1e-12)
    # About x: film w^2/12, 10 cables along y, 6 along x (of which 4 off the axis), frame, polar.
    cables = 10 * per_cable * (0.625**2 + 0.25**2 / 12) + 4 * per_cable * 0.5**2
    frame = 2 * per_metre * (2.5 * 0.75**2 + 1.5**3 / 12)
    polar = 1380.0 * (4.81e-7 + 2.69e-7) * 2 * 2.5
    expected = film / 12.0 + cables + frame + polar
    rotation_x = model.rigid_motions[:, 3]
    got = rotation_x @ (operator(model).mass_matrix @ rotation_x)
    assert got == pytest.approx(expected, rel=1e-12)
    verification_row("antenna, rigid inertia about x [kg m²]", expected, got, "sums by hand")


def test_inertial_load_is_the_operator_on_positions_without_beams(verification_row):
    worst = 0.0
    for model in (triangle(), cable()):
        inertia, z, a = operator(model), random_matrix(6), np.array([0.3, -2.0, 1.1])
        shift = np.tile(a, len(model.nodes))
        expected = inertia.matrix(z) @ model.nodes.ravel() + inertia.mass_matrix @ shift
        close(inertia.load(z, a), expected)
        worst = max(worst, np.abs(inertia.load(z, a) - expected).max() / np.abs(expected).max())
    verification_row("film and cable, inertial load - M(Z)X, relative", 0.0, worst, "Q_T = M(Z)X, paper (45)")


def test_inertial_load_of_a_beam(verification_row):
    """M(Z)X along the axis plus the torque that the cross-section adds to the twist."""
    rate, alpha = np.array([0.5, 0.9, -1.4]), np.array([2.0, -0.3, 0.8])
    z = cross_matrix(alpha) + cross_matrix(rate) @ cross_matrix(rate)
    model = beam_line(BEAM, LENGTH, 1)
    inertia = operator(model)
    position = np.zeros(12)
    position[6] = LENGTH  # the axis x = s: linear along, no deflection
    on_axis = inertia.matrix(z) @ position
    torque = DENSITY * (
        (BEAM.inertia_y + BEAM.inertia_z) * alpha[0] + (BEAM.inertia_z - BEAM.inertia_y) * rate[1] * rate[2]
    )
    expected = on_axis.copy()
    expected[[3, 9]] += torque * LENGTH / 2.0
    close(inertia.load(z), expected)
    twist = inertia.load(cross_matrix(alpha))[[3, 9]]
    by_hand = DENSITY * (BEAM.inertia_y + BEAM.inertia_z) * alpha[0] * LENGTH
    assert twist.sum() == pytest.approx(by_hand, rel=1e-12)
    verification_row(
        "beam, Euler torque about its axis [N m]",
        by_hand,
        twist.sum(),
        "rho(Iy+Iz) alpha L (Euler's equation)",
    )


def test_inertial_load_does_the_work_of_euler_s_equation(verification_row):
    """Virtual work of the load on rigid rotations is the moment J alpha + w x J w, on translations m a_c."""
    alpha, acceleration = np.array([1.2, -0.6, 2.1]), np.array([0.4, 0.1, -0.9])
    z = cross_matrix(alpha) + cross_matrix(W) @ cross_matrix(W)
    model = mixed()
    inertia = operator(model)
    work = model.rigid_motions.T @ inertia.load(z, acceleration)
    mass, moment, _ = closed_form_moments(model)
    np.testing.assert_allclose(work[:3], z @ moment + mass * acceleration, rtol=1e-12)
    # Moments of a film only: bending has no rotary inertia, so a beam's section enters J but in part.
    film = Model.from_mesh(model.nodes[:4], triangles=model.triangles, membrane=model.groups[0].section)
    inertia = operator(film)
    work = film.rigid_motions.T @ inertia.load(z)
    second = inertia.second_moment
    tensor = np.trace(second) * np.eye(3) - second
    expected = tensor @ alpha + np.cross(W, tensor @ W)
    np.testing.assert_allclose(work[3:], expected, rtol=1e-12)
    verification_row(
        "film in space, moment of the inertial load [N m]",
        float(np.linalg.norm(expected)),
        float(np.linalg.norm(work[3:])),
        "J alpha + ω x Jω",
    )


def test_supported_unknowns_leave_the_rest_unchanged():
    free = antenna((0.6, 1.0), (4, 2), support="free")
    held = antenna((0.6, 1.0), (4, 2), support="short-side")
    keep = held.free_dofs
    z = random_matrix(8)
    close(operator(held).matrix(z).toarray(), operator(free).matrix(z).toarray()[np.ix_(keep, keep)])
    close(operator(held).load(z), operator(free).load(z)[keep])
