"""The kernel: derivatives of the energy, invariance under rigid motion, patch tests."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tautflex import BeamSection, CableSection, Material, MembraneSection, Model
from tautflex.elements import element_blocks
from tautflex.mechanics.system import StructuralSystem
from verification.builders import line_elements, observed_order, rotation, rotation_matrix, strains

Array = NDArray[np.float64]

STRAINS = ("von-karman", "green-lagrange")
KINDS = ("membrane", "cable", "beam", "mixed")
# Stiffnesses of order one: round-off is then the only error of the difference rules.
SOFT = Material(2.0, 1.0, 0.3)


def structure(kind: str, strain: str, seed: int = 0, prestress: float = 1.0) -> Model:
    """Elements of one kind, or all, in general position in space; nothing supported."""
    rng = np.random.default_rng(seed)
    membrane = MembraneSection(SOFT, 0.7, strain)
    cable = CableSection(SOFT, 0.9, strain)
    beam = BeamSection(SOFT, 0.8, 0.3, 0.5, 0.6, strain)
    turn = rotation(seed)
    if kind == "cable":
        nodes = np.cumsum(rng.uniform(0.5, 1.0, (4, 3)), axis=0)
        options = {
            "cables": line_elements(3),
            "cable": cable,
            "cable_tension": prestress * rng.uniform(1, 2, 3),
        }
    elif kind == "membrane":
        nodes = np.array([[0, 0, 0], [1, 0.1, 0.2], [0.2, 0.9, 0.1], [1.2, 1.1, -0.3]])
        triangles, stress = [[0, 1, 2], [1, 3, 2]], prestress * np.array([0.9, 0.6, 0.2])
        options = {"triangles": triangles, "membrane": membrane, "membrane_stress": stress}
    elif kind == "beam":
        nodes = np.array([[0, 0, 0], [1, 0.2, 0.1], [1.3, 1.2, 0.4], [0.1, 1.0, 1.1]])
        options = {
            "beams": [[0, 1], [1, 2], [2, 3], [3, 0]],
            "beam": beam,
            "beam_axial_force": prestress * np.array([0.3, -0.4, 0.2, -0.1]),
        }
    else:
        nodes = np.array([[0, 0, 0], [1, 0.1, 0.2], [0.2, 0.9, 0.1], [1.2, 1.1, -0.3], [2, 0.1, 1], [2.4, 1.2, 0.8]])
        options = {
            "triangles": [[0, 1, 2], [1, 3, 2]],
            "membrane": membrane,
            "membrane_stress": prestress * np.array([0.9, 0.6, 0.2]),
            "cables": [[1, 4], [3, 5]],
            "cable": cable,
            "cable_tension": prestress,
            "beams": [[4, 5], [5, 0]],
            "beam": beam,
            "beam_axial_force": -0.3 * prestress,
        }
    return Model.from_mesh(np.asarray(nodes, dtype=float) @ turn.T, **options)


def stencil(function, x: Array, direction: Array, step: float) -> Array:
    """Five-point central difference: exact for polynomials of degree four, so for our forces and energies."""
    values = [np.asarray(function(x + k * step * direction)) for k in (-2, -1, 1, 2)]
    return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("kind", KINDS)
def test_force_is_the_gradient_of_the_energy_and_the_tangent_that_of_the_force(kind, strain, verification_row):
    force_error = tangent_error = 0.0
    for seed in range(3):
        system = StructuralSystem.from_model(structure(kind, strain, seed))
        rng = np.random.default_rng(100 + seed)
        q = 0.3 * rng.standard_normal(system.size)
        force, _ = system.force(q)
        force = force.copy()
        tangent = system.matrix(system.tangent(q)).toarray()
        gradient, columns = np.empty(system.size), np.empty((system.size, system.size))
        for k, unit in enumerate(np.eye(system.size)):
            gradient[k] = stencil(lambda x, s=system: s.force(x)[1], q, unit, 0.1)
            columns[:, k] = stencil(lambda x, s=system: s.force(x)[0].copy(), q, unit, 0.1)
        force_error = max(force_error, np.abs(force - gradient).max() / np.abs(force).max())
        tangent_error = max(tangent_error, np.abs(tangent - columns).max() / np.abs(tangent).max())
        np.testing.assert_allclose(tangent, tangent.T, rtol=0.0, atol=1e-14 * np.abs(tangent).max())
    assert force_error < 1e-12
    assert tangent_error < 1e-12
    source = "five-point difference, exact for quartics"
    verification_row(f"{kind}, {strain}: force - energy gradient, relative", 0.0, force_error, source)
    verification_row(f"{kind}, {strain}: tangent - force gradient, relative", 0.0, tangent_error, source)


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("kind", KINDS)
def test_energy_is_the_work_of_the_forces_along_any_path(kind, strain):
    # Force is cubic along a line: two Gauss points integrate it exactly.
    system = StructuralSystem.from_model(structure(kind, strain))
    rng = np.random.default_rng(5)
    points = 0.3 * rng.standard_normal((4, system.size))
    work = 0.0
    for start, end in zip(np.vstack([np.zeros(system.size), points[:-1]]), points, strict=True):
        for ratio in 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0):
            work += 0.5 * system.force(start + ratio * (end - start))[0] @ (end - start)
    assert work == pytest.approx(system.force(points[-1])[1], rel=1e-12)


def rigid_displacement(model: Model, turn: Array, shift: Array, start: Array | None = None) -> Array:
    """Unknowns of a structure without rotations after turning ``x + start`` by a finite rotation."""
    current = model.nodes if start is None else model.nodes + start.reshape(-1, 3)
    return (current @ turn.T + shift - model.nodes).ravel()


@pytest.mark.parametrize("kind", ["membrane", "cable"])
def test_finite_rigid_motion_of_film_and_cable_is_free(kind, verification_row):
    model = structure(kind, "green-lagrange", 2, prestress=0.0)
    system = StructuralSystem.from_model(model)
    shift, worst = np.array([3.0, -1.0, 2.0]), 0.0
    scale, _ = system.force(0.1 * np.random.default_rng(0).standard_normal(system.size))
    scale = float(np.abs(scale).max())
    for seed in range(6):
        force, energy = system.force(rigid_displacement(model, rotation(seed), shift))
        assert abs(energy) < 1e-24
        worst = max(worst, float(np.abs(force).max()) / scale)
    assert worst < 1e-12
    verification_row(
        f"{kind}, green-lagrange: force of a finite rigid motion / force of a strain of 0.1",
        0.0,
        worst,
        "objectivity",
    )


@pytest.mark.parametrize("kind", ["membrane", "cable"])
def test_prestressed_film_and_cable_are_objective(kind):
    """Turning a prestressed, deformed body turns its forces and keeps its energy."""
    model = structure(kind, "green-lagrange", 2)
    system = StructuralSystem.from_model(model)
    start = 0.2 * np.random.default_rng(1).standard_normal(system.size)
    force, energy = system.force(start)
    force = force.reshape(-1, 3).copy()
    for seed in range(4):
        turn = rotation(seed)
        turned, same = system.force(rigid_displacement(model, turn, np.ones(3), start))
        assert same == pytest.approx(energy, rel=1e-12)
        np.testing.assert_allclose(turned.reshape(-1, 3), force @ turn.T, atol=1e-12 * np.abs(force).max())


@pytest.mark.parametrize("kind", ["membrane", "cable"])
def test_von_karman_strains_are_not_objective(kind):
    """What von Karman leaves out: the axial strain cos(angle) - 1 + sin(angle)^2/2 of a turned element."""
    angle, section = 0.4, MembraneSection(SOFT, 1.0)
    nodes = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]
    if kind == "membrane":
        model = Model.from_mesh(nodes, triangles=[[0, 1, 2]], membrane=section)
    else:
        model = Model.from_mesh(nodes[:2], cables=[[0, 1]], cable=CableSection(SOFT, 1.0))
    turn = rotation_matrix(np.array([0.0, angle, 0.0]))
    found = strains(element_blocks(model)[0], rigid_displacement(model, turn, np.zeros(3)))
    assert found[0, 0] == pytest.approx(np.cos(angle) - 1.0 + 0.5 * np.sin(angle) ** 2, rel=1e-13)


def beam_rigid(model: Model, vector: Array) -> Array:
    """Unknowns of a frame turned by the rotation vector: exact positions, rotation vector at every node."""
    moved = model.nodes @ rotation_matrix(vector).T - model.nodes
    return np.hstack([moved, np.tile(vector, (len(moved), 1))]).ravel()


@pytest.mark.parametrize(("strain", "expected"), [("von-karman", 2), ("green-lagrange", 3)])
def test_order_of_beam_strains_under_rigid_rotation(strain, expected, verification_row):
    model = structure("beam", strain, 3, prestress=0.0)
    block = element_blocks(model)[0]
    axes = np.random.default_rng(7).standard_normal((5, 3))
    orders = []
    for axis in axes / np.linalg.norm(axes, axis=1)[:, None]:
        sizes = [np.abs(strains(block, beam_rigid(model, angle * axis))).max() for angle in (0.04, 0.02, 0.01)]
        orders.append(observed_order(np.array(sizes))[-1])
    assert expected - 0.1 < min(orders)
    assert max(orders) < expected + 0.1
    verification_row(
        f"frame beams, {strain}: order of the strains in the angle of a rigid rotation",
        float(expected),
        float(np.mean(orders)),
        "expansion of the exact rotation",
    )


@pytest.mark.parametrize(("strain", "expected"), [("von-karman", 2), ("green-lagrange", 3)])
def test_order_of_the_change_of_beam_strains_when_a_strained_frame_turns(strain, expected, verification_row):
    """Stretch, bending and twist together: what prestress and its reaction in the frame do when they turn."""
    model = structure("beam", strain, 3, prestress=0.0)
    block = element_blocks(model)[0]
    rng = np.random.default_rng(8)
    state = 0.5 * rng.standard_normal((len(model.nodes), 2, 3))
    axis = rng.standard_normal(3)
    changes = []
    for size in (0.02, 0.01, 0.005):
        start, turn = size * state, Rotation.from_rotvec(size * axis)
        turned = np.empty_like(start)
        turned[:, 0] = turn.apply(model.nodes + start[:, 0]) - model.nodes
        turned[:, 1] = (turn * Rotation.from_rotvec(start[:, 1])).as_rotvec()
        change = strains(block, turned.ravel()) - strains(block, start.ravel())
        changes.append(np.abs(change).max(axis=0))
    order = observed_order(np.array(changes))[-1]
    assert expected - 0.15 < order.min() < expected + 0.15
    verification_row(
        f"strained frame beams, {strain}: least order of the change of strains in the angle it turns",
        float(expected),
        float(order.min()),
        "expansion of the exact rotation",
    )


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("kind", KINDS)
def test_infinitesimal_rigid_motion_is_free(kind, strain):
    model = structure(kind, strain, 4, prestress=0.0)
    system = StructuralSystem.from_model(model)
    stiffness = system.matrix(system.tangent(np.zeros(system.size))).toarray()
    left = stiffness @ model.rigid_motions
    assert np.abs(left).max() < 1e-13 * np.abs(stiffness).max() * np.abs(model.rigid_motions).max()
    # ... and nothing else is, in a frame (films and cables are mechanisms without prestress).
    if kind == "beam":
        values = np.linalg.eigvalsh(stiffness)
        assert np.abs(values[:6]).max() < 1e-12 * values[-1]
        assert values[6] > 1e-4 * values[-1]


def patch() -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
    """Irregular triangulation of a quadrilateral with interior nodes 4..7."""
    nodes = np.array(
        [
            [0, 0, 0],
            [2, 0.1, 0],
            [2.3, 1.7, 0],
            [-0.2, 1.5, 0],
            [0.5, 0.4, 0],
            [1.5, 0.5, 0],
            [1.4, 1.1, 0],
            [0.6, 0.9, 0],
        ]
    )
    triangles = [
        [0, 1, 4],
        [1, 5, 4],
        [1, 2, 5],
        [2, 6, 5],
        [2, 3, 6],
        [3, 7, 6],
        [3, 0, 7],
        [0, 4, 7],
        [4, 5, 6],
        [4, 6, 7],
    ]
    return nodes.astype(float), np.array(triangles), np.arange(4, 8)


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("seed", [None, 9])
def test_membrane_patch(strain, seed, verification_row):
    """Linear displacement in the plane, constant slope out of it: constant stress, interior in balance."""
    flat, triangles, interior = patch()
    turn = np.eye(3) if seed is None else rotation(seed)
    assert turn[2, 2] > 0.0  # the film's normal points up, as its local axes do
    stress0 = np.array([0.9, 0.6, 0.2])
    model = Model.from_mesh(
        flat @ turn.T,
        triangles=triangles,
        membrane=MembraneSection(SOFT, 0.7, strain),
        membrane_stress=stress0,
        membrane_orientation=turn[:, 0],
    )
    system = StructuralSystem.from_model(model)
    slopes = np.array([[0.03, -0.02], [0.05, 0.01]])
    tilt = np.array([0.2, -0.3])
    local = np.column_stack([flat[:, :2] @ slopes.T, flat[:, :2] @ tilt])
    workspace = system.workspace()
    force, energy = workspace.force((local @ turn.T).ravel())
    inner = np.abs(force.reshape(-1, 3)[interior]).max() / np.abs(force).max()
    assert inner < 1e-13
    quadratic = np.outer(tilt, tilt) + (slopes.T @ slopes if strain == "green-lagrange" else 0.0)
    tensor = 0.5 * (slopes + slopes.T + quadratic)
    strain_vector = np.array([tensor[0, 0], tensor[1, 1], 2.0 * tensor[0, 1]])
    factor = SOFT.youngs_modulus / (1.0 - SOFT.poisson_ratio**2)
    elastic = factor * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    expected = stress0 + elastic @ strain_vector
    np.testing.assert_allclose(workspace.stress[0], np.tile(expected, (len(triangles), 1)), rtol=1e-12)
    corners = flat[triangles]
    area = 0.5 * np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]).sum()
    work = 0.7 * area * (stress0 @ strain_vector + 0.5 * strain_vector @ elastic @ strain_vector)
    assert energy == pytest.approx(work, rel=1e-12)
    where = "in z = 0" if seed is None else "turned"
    verification_row(f"membrane patch {where}, {strain}: interior / edge force", 0.0, inner, "patch test")


@pytest.mark.parametrize("strain", STRAINS)
def test_cable_patch(strain):
    """Stretch and slope that are uniform along an unevenly divided cable balance at the interior nodes."""
    nodes = np.array([0.0, 0.3, 1.0, 1.2, 2.0])[:, None] * rotation(3)[:, 0]
    model = Model.from_mesh(nodes, cables=line_elements(4), cable=CableSection(SOFT, 0.9, strain), cable_tension=0.8)
    system = StructuralSystem.from_model(model)
    displacement = nodes @ np.random.default_rng(2).uniform(-0.3, 0.3, (3, 3))
    force, _ = system.force(displacement.ravel())
    force = force.reshape(-1, 3)
    assert np.abs(force[1:-1]).max() < 1e-13 * np.abs(force).max()
    np.testing.assert_allclose(force[0], -force[-1], rtol=1e-13)


@pytest.mark.parametrize("seed", [None, 4])
@pytest.mark.parametrize("plane", ["v", "w"])
def test_beam_patch(seed, plane, verification_row):
    """Constant curvature, stretch and twist on uneven elements: end loads only, nothing in between."""
    turn = np.eye(3) if seed is None else rotation(seed)
    s = np.array([0.0, 0.3, 1.0, 1.2, 2.0])
    section = BeamSection(SOFT, 0.8, 0.3, 0.5, 0.6)
    model = Model.from_mesh(s[:, None] * turn[:, 0], beams=line_elements(4), beam=section, beam_orientation=turn[:, 2])
    system = StructuralSystem.from_model(model)
    curvature, stretch, twist = 0.8, 0.5, -0.6
    local = np.zeros((5, 2, 3))
    local[:, 0, 0], local[:, 1, 0] = stretch * s, twist * s
    if plane == "v":
        local[:, 0, 1], local[:, 1, 2] = 0.5 * curvature * s**2, curvature * s
        moment_direction, inertia = 2, section.inertia_z
    else:
        local[:, 0, 2], local[:, 1, 1] = 0.5 * curvature * s**2, -curvature * s
        moment_direction, inertia = 1, -section.inertia_y
    stiffness = system.matrix(system.tangent(np.zeros(system.size)))
    force = (stiffness @ (local @ turn.T).ravel()).reshape(5, 2, 3) @ turn
    expected = np.zeros((5, 2, 3))
    shear = SOFT.youngs_modulus / 2.6
    expected[-1, 0, 0] = SOFT.youngs_modulus * section.area * stretch
    expected[-1, 1, 0] = shear * section.torsion_constant * twist
    expected[-1, 1, moment_direction] = SOFT.youngs_modulus * inertia * curvature
    expected[0] = -expected[-1]
    error = np.abs(force - expected).max() / np.abs(expected).max()
    assert error < 1e-12
    verification_row(
        f"beam patch ({'along x' if seed is None else 'turned'}), curvature of {plane}: force error",
        0.0,
        error,
        "EA ε, EI κ, GJ θ'",
    )
