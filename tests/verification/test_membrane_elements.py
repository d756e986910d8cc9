"""Second-order triangles and quadrilaterals: what triangle3 is tested for in test_kernel and test_membrane_modes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tautflex import ElementBlock, Material, MembraneSection, Model, solve_modes, solve_prestress
from tautflex.elements import element_blocks
from tautflex.elements.laws import TensionField
from tautflex.mechanics.membrane import principal_resultants, survey_at
from tautflex.mechanics.system import StructuralSystem
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.model import Support
from tautflex.structure.shapes import SHAPES
from verification.builders import AREAL_DENSITY, FILM, THICKNESS, observed_order, rotation, strains

Array = NDArray[np.float64]

ELEMENTS = ("triangle6", "quad4")
STRAINS = ("von-karman", "green-lagrange")
SOFT = Material(2.0, 1.0, 0.3)
A, B = 2.0, 1.0
RESULTANT = np.array([0.59, 0.5])


def film_arguments(element: str, elements: Array) -> dict[str, Array]:
    """Keyword of `Model.from_mesh` that takes these elements."""
    return {"quads" if element == "quad4" else "triangles": elements}


def warped(element: str, strain: str = "green-lagrange", *, prestress: float = 1.0, seed: int = 0) -> Model:
    """Two by two cells of a film whose nodes, those in the middle of sides too, lie in no plane."""
    nodes, elements = rectangle_mesh(np.linspace(0, 2, 3), np.linspace(0, 1.5, 3), "alternating", SHAPES[element])
    nodes = nodes + 0.04 * np.random.default_rng(seed).standard_normal(nodes.shape)
    return Model.from_mesh(
        nodes @ rotation(seed).T,
        membrane=MembraneSection(SOFT, 0.7, strain),
        membrane_stress=prestress * np.array([0.9, 0.6, 0.2]),
        **film_arguments(element, elements),
    )


def node_force(block: ElementBlock, q: Array) -> Array:
    """Internal force from the block's arrays alone, for complex unknowns too."""
    dofs = block.rows_of(block.dofs)
    g = np.einsum("nij,nj->ni", block.gradient, q[dofs])
    slope = np.einsum("sij,nj->nsi", block.quadratic, g)
    strain = g @ block.linear.T + 0.5 * np.einsum("nsi,ni->ns", slope, g)
    stress = block.initial_stress + np.einsum("nst,nt->ns", block.elasticity, strain)
    local = np.einsum("nij,nsi,ns,n->nj", block.gradient, block.linear + slope, stress, block.measure)
    force = np.zeros(len(q), dtype=q.dtype)
    np.add.at(force, dofs, local)
    return force


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("element", ELEMENTS)
def test_force_is_the_gradient_of_the_energy_and_the_tangent_that_of_the_force(element, strain, verification_row):
    model = warped(element, strain)
    system, block = StructuralSystem.from_model(model), element_blocks(model)[0]
    q = 0.3 * np.random.default_rng(1).standard_normal(system.size)
    force, _ = system.force(q)
    tangent = system.matrix(system.tangent(q)).toarray()
    units = 1e-30j * np.eye(system.size)
    columns = np.array([node_force(block, q + unit).imag for unit in units]).T / 1e-30
    gradient = np.empty(system.size)
    for k, unit in enumerate(np.eye(system.size)):
        energies = [system.force(q + step * unit)[1] for step in (-0.2, -0.1, 0.1, 0.2)]
        gradient[k] = (energies[0] - 8.0 * energies[1] + 8.0 * energies[2] - energies[3]) / 1.2
    force_error = np.abs(force - gradient).max() / np.abs(force).max()
    tangent_error = np.abs(tangent - columns).max() / np.abs(tangent).max()
    assert force_error < 1e-12
    assert tangent_error < 1e-13
    case = f"{element}, {strain}"
    source = "five-point difference, exact for quartics"
    verification_row(f"{case}: force - energy gradient, relative", 0.0, force_error, source)
    verification_row(f"{case}: tangent - force gradient, relative", 0.0, tangent_error, "complex step")


@pytest.mark.parametrize("element", ELEMENTS)
def test_finite_rigid_motion_is_free_and_prestress_turns_with_it(element, verification_row):
    model = warped(element, prestress=0.0)
    system = StructuralSystem.from_model(model)
    scale = np.abs(system.force(0.1 * np.random.default_rng(0).standard_normal(system.size))[0]).max()
    worst = 0.0
    for seed in range(4):
        moved = model.nodes @ rotation(seed).T + np.array([3.0, -1.0, 2.0]) - model.nodes
        force, energy = system.force(moved.ravel())
        assert abs(energy) < 1e-24
        worst = max(worst, float(np.abs(force).max()) / scale)
    assert worst < 1e-12
    verification_row(
        f"{element}, green-lagrange: force of a finite rigid motion / force of a strain of 0.1",
        0.0,
        worst,
        "objectivity",
    )
    taut = StructuralSystem.from_model(warped(element))
    start = 0.2 * np.random.default_rng(1).standard_normal(model.nodes.shape)
    force, energy = taut.force(start.ravel())
    turn = rotation(5)
    turned, same = taut.force(((model.nodes + start) @ turn.T - model.nodes).ravel())
    assert same == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(turned.reshape(-1, 3), force.reshape(-1, 3) @ turn.T, atol=1e-12 * np.abs(force).max())


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("element", ELEMENTS)
def test_patch(element, strain, verification_row):
    """Linear displacement on distorted elements with bent inner sides: constant stress, interior in balance."""
    nodes, elements = rectangle_mesh(np.linspace(0, 2, 4), np.linspace(0, 1.5, 4), "alternating", SHAPES[element])
    edge = np.isin(nodes[:, 0], (0.0, 2.0)) | np.isin(nodes[:, 1], (0.0, 1.5))
    nodes[~edge, :2] += 0.02 * np.random.default_rng(2).standard_normal((np.sum(~edge), 2))
    stress0, thickness = np.array([0.9, 0.6, 0.2]), 0.7
    model = Model.from_mesh(
        nodes,
        membrane=MembraneSection(SOFT, thickness, strain),
        membrane_stress=stress0,
        **film_arguments(element, elements),
    )
    system = StructuralSystem.from_model(model)
    slopes, tilt = np.array([[0.03, -0.02], [0.05, 0.01]]), np.array([0.2, -0.3])
    workspace = system.workspace()
    force, energy = workspace.force(np.column_stack([nodes[:, :2] @ slopes.T, nodes[:, :2] @ tilt]).ravel())
    inner = np.abs(force.reshape(-1, 3)[~edge]).max() / np.abs(force).max()
    assert inner < 1e-13
    tensor = slopes + slopes.T + np.outer(tilt, tilt) + (slopes.T @ slopes if strain == "green-lagrange" else 0.0)
    strain_vector = 0.5 * np.array([tensor[0, 0], tensor[1, 1], 2.0 * tensor[0, 1]])
    elastic = SOFT.youngs_modulus / (1.0 - 0.3**2) * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
    rows = workspace.stress[0]
    np.testing.assert_allclose(rows, np.tile(stress0 + elastic @ strain_vector, (len(rows), 1)), rtol=1e-12)
    work = thickness * 3.0 * (stress0 @ strain_vector + 0.5 * strain_vector @ elastic @ strain_vector)
    assert energy == pytest.approx(work, rel=1e-12)
    verification_row(f"{element} patch, {strain}: interior / edge force", 0.0, inner, "patch test")


@pytest.mark.parametrize("element", ELEMENTS)
def test_mass_is_exact_for_the_element_interpolation(element, verification_row):
    """``int rho h (x y)^2`` over a unit square: x y is in the interpolation of both elements."""
    nodes, elements = rectangle_mesh(np.linspace(0, 1, 3), np.linspace(0, 1, 4), "regular", SHAPES[element])
    model = Model.from_mesh(nodes, membrane=MembraneSection(SOFT, 0.7), **film_arguments(element, elements))
    inertia = StructuralSystem.from_model(model).inertia
    field = np.zeros_like(nodes)
    field[:, 2] = nodes[:, 0] * nodes[:, 1]
    found = float(inertia.mass_matrix.dot(field.ravel()) @ field.ravel()) / 0.7
    assert found == pytest.approx(1.0 / 9.0, rel=1e-13)
    assert inertia.mass == pytest.approx(0.7, rel=1e-13)
    np.testing.assert_allclose(inertia.second_moment[:2, :2] / 0.7, [[1 / 3, 1 / 4], [1 / 4, 1 / 3]], rtol=1e-12)
    verification_row(f"{element}: integral of (x y)² over the unit square from its mass", 1 / 9, found, "1/9")


@pytest.mark.parametrize("element", ELEMENTS)
def test_strains_of_an_expanded_cylinder(element):
    """Curved elements have axes of their own at every point: hoop strain e + e²/2, nothing along the axis."""
    turn, axis = np.linspace(0.2, 1.3, 3), np.linspace(0.0, 1.0, 3)
    flat, elements = rectangle_mesh(turn, axis, "alternating", SHAPES[element])
    nodes = np.column_stack([np.cos(flat[:, 0]), np.sin(flat[:, 0]), flat[:, 1]])
    model = Model.from_mesh(
        nodes,
        membrane=MembraneSection(SOFT, 0.7, "green-lagrange"),
        membrane_orientation=(0.0, 0.0, 1.0),
        **film_arguments(element, elements),
    )
    growth = 0.1
    block = element_blocks(model)[0]
    found = strains(block, (growth * nodes * [1.0, 1.0, 0.0]).ravel())
    np.testing.assert_allclose(found, np.tile([0.0, growth + 0.5 * growth**2, 0.0], (len(found), 1)), atol=1e-14)
    area = (block.measure / block.size).sum()
    assert area == pytest.approx(1.1, rel=1e-4 if element == "triangle6" else 2e-2)


@pytest.mark.parametrize("element", ELEMENTS)
def test_wrinkles_are_looked_at_point_by_point(element):
    """Growing shear wrinkles the points where it outgrows the tension; elements take the worst of theirs."""
    nodes, elements = rectangle_mesh(np.linspace(0, 1, 3), np.linspace(0, 1, 2), "regular", SHAPES[element])
    section = MembraneSection(SOFT, 0.7, law="tension-field")
    model = Model.from_mesh(
        nodes, membrane=section, membrane_stress=(0.2, 0.2, 0.0), **film_arguments(element, elements)
    )
    system = StructuralSystem.from_model(model)
    q = np.zeros_like(nodes)
    q[:, 1] = 0.3 * nodes[:, 0] ** 2
    block, (stress,) = system.blocks[0], system.stress(q.ravel())
    trial = block.initial_stress + strains(block, q.ravel()) @ block.elasticity[0].T
    law, numbers = TensionField(), TensionField().parameters(SOFT)
    assert law.function is not None
    np.testing.assert_allclose(stress, [law.function.at(row, numbers).stress for row in trial], rtol=1e-13, atol=1e-15)
    wrinkled = trial[:, 0] * trial[:, 1] < trial[:, 2] ** 2
    assert wrinkled.any()
    assert not wrinkled.all()
    survey = survey_at(system, q.ravel())
    area = block.measure / block.size
    assert survey.membrane().wrinkled == pytest.approx(area[wrinkled].sum() / area.sum(), rel=1e-13)
    worst = np.zeros(len(elements), dtype=int)
    np.maximum.at(worst, block.owner, wrinkled)
    np.testing.assert_array_equal(survey.membrane_states(), worst)
    low = principal_resultants(system, [stress])
    assert low.shape == (len(elements), 2)
    assert survey.membrane().smallest == low[:, 0].min()
    assert survey.membrane().element == np.argmin(low[:, 0])


def fixed_film(element: str, divisions: tuple[int, int], strain: str = "von-karman", law: str = "elastic") -> Model:
    """Film of 2 m x 1 m held all around."""
    lines = (np.linspace(-0.5, 0.5, n + 1) * size for n, size in zip(divisions, (A, B), strict=True))
    nodes, elements = rectangle_mesh(*lines, "alternating", SHAPES[element])
    edge = np.isclose(np.abs(nodes[:, 0]), A / 2) | np.isclose(np.abs(nodes[:, 1]), B / 2)
    return Model.from_mesh(
        nodes,
        membrane=MembraneSection(FILM, THICKNESS, strain, law),
        membrane_stress=(*RESULTANT / THICKNESS, 0.0),
        supports=[Support.pinned(np.flatnonzero(edge))],
        **film_arguments(element, elements),
    )


@pytest.mark.parametrize(
    ("element", "expected_order", "bounds"),
    [("triangle6", 4.0, (1e-3, 1e-4)), ("quad4", 2.0, (6e-2, 1.5e-2))],
)
def test_first_ten_frequencies_of_the_fixed_membrane(element, expected_order, bounds, verification_row):
    pairs = [(m, n) for m in range(1, 12) for n in range(1, 6)]
    exact = np.sort([0.5 * np.sqrt(RESULTANT @ [m**2 / A**2, n**2 / B**2] / AREAL_DENSITY) for m, n in pairs])[:10]
    errors = []
    for divisions, bound in zip(((20, 10), (40, 20)), bounds, strict=True):
        found = solve_modes(solve_prestress(fixed_film(element, divisions)), 10).frequencies
        errors.append(found / exact - 1.0)
        assert np.all(errors[-1] > 0.0)  # conforming, consistent mass: bounds from above
        assert errors[-1].max() < bound
        cells = f"{divisions[0]}x{divisions[1]} cells"
        source = "f_mn = sqrt((Nx m²/a² + Ny n²/b²)/(rho h))/2"
        verification_row(
            f"fixed membrane, {element}, {cells}: largest error of ten frequencies",
            f"< {bound:g}",
            errors[-1].max(),
            source,
        )
    order = observed_order(errors)[0]
    assert np.all(np.abs(order - expected_order) < 0.15), order
    verification_row(
        f"fixed membrane, {element}: observed order of f11", expected_order, order[0], "order of the interpolation"
    )
