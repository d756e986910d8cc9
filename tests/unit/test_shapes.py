"""Shapes of elements: interpolation, rules, splitting, point search, grids and checks."""

from __future__ import annotations

from dataclasses import replace
from math import factorial

import numpy as np
import pytest

from tautflex import BeamSection, CableSection, InputError, Material, MembraneSection, MeshError, Model, Shape
from tautflex.structure.antenna import AntennaLayout, build_antenna
from tautflex.structure.locate import locate
from tautflex.structure.mesh import graded_lines, rectangle_mesh
from tautflex.structure.shapes import (
    LINE2,
    QUAD4,
    SHAPES,
    TRIANGLE3,
    TRIANGLE6,
    quadrature,
    register_shape,
    surface_shape,
)

ALL = [LINE2, TRIANGLE3, TRIANGLE6, QUAD4]
SURFACES = [TRIANGLE3, TRIANGLE6, QUAD4]
FILM = MembraneSection(Material(3.5e9, 1530.0, 0.34), 1e-4)
# A field that each shape interpolates exactly, over x and y.
FIELDS = {
    "triangle3": lambda x, y: 1.0 + 2.0 * x - 3.0 * y,
    "quad4": lambda x, y: 1.0 + 2.0 * x - 3.0 * y + 4.0 * x * y,
    "triangle6": lambda x, y: 1.0 + 2.0 * x - 3.0 * y + 4.0 * x * y - 5.0 * x**2 + 6.0 * y**2,
}


def named(shape):
    return shape.name


@pytest.mark.parametrize("shape", ALL, ids=named)
def test_functions_are_one_at_their_node_and_add_up_to_one(shape):
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (7, shape.dimension))
    np.testing.assert_allclose(shape.functions(shape.nodes), np.eye(len(shape.nodes)), atol=1e-15)
    np.testing.assert_allclose(shape.functions(points).sum(axis=1), 1.0, rtol=1e-14)
    step = 1e-4  # central differences are exact for quadratic functions
    for axis, unit in enumerate(np.eye(shape.dimension)):
        difference = (shape.functions(points + step * unit) - shape.functions(points - step * unit)) / (2.0 * step)
        np.testing.assert_allclose(shape.slopes(points)[:, :, axis], difference, atol=1e-11)


@pytest.mark.parametrize("degree", range(1, 8))
def test_rules_integrate_every_monomial_of_their_degree(degree):
    points, weights = quadrature("triangle", degree)
    for m in range(degree + 1):
        for n in range(degree + 1 - m):
            exact = factorial(m) * factorial(n) / factorial(m + n + 2)  # over the triangle (0, 0), (1, 0), (0, 1)
            assert weights @ (points[:, 0] ** m * points[:, 1] ** n) == pytest.approx(exact, rel=1e-14)
    even = [2.0 / (m + 1) if m % 2 == 0 else 0.0 for m in range(degree + 1)]  # over [-1, 1]
    points, weights = quadrature("line", degree)
    np.testing.assert_allclose([weights @ points[:, 0] ** m for m in range(degree + 1)], even, atol=1e-14)
    points, weights = quadrature("quad", degree)
    for m, along in enumerate(even):
        for n, across in enumerate(even):
            assert weights @ (points[:, 0] ** m * points[:, 1] ** n) == pytest.approx(along * across, abs=1e-14)


@pytest.mark.parametrize("shape", SURFACES, ids=named)
def test_area_and_split_of_a_turned_film(shape):
    nodes, elements = rectangle_mesh(np.array([0.0, 0.3, 2.0]), np.array([-1.0, 0.0, 0.5]), shape=shape)
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    areas = shape.measure(nodes[elements] @ turn.T)
    assert areas.sum() == pytest.approx(3.0, rel=1e-14)
    triangles, owner = shape.split_elements(elements)
    split = TRIANGLE3.measure(nodes[triangles] @ turn.T)
    np.testing.assert_allclose(np.bincount(owner, split), areas, rtol=1e-13)
    along = TRIANGLE3.tangents(nodes[triangles], [[0.0, 0.0]])[:, 0]
    assert (np.cross(along[:, 0], along[:, 1])[:, 2] > 0.0).all()  # turned as the elements are


def test_area_of_a_curved_triangle():
    """Two sides of a quarter disc are straight; the third, a parabola through its middle, bounds a known area."""
    middle = 0.5 + 0.3 / np.sqrt(2.0)  # a bulge of 0.3 beyond the chord of length sqrt(2): 2/3 of the parallelogram
    nodes = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [middle, middle, 0], [0, 0.5, 0]]])
    assert TRIANGLE6.measure(nodes)[0] == pytest.approx(0.5 + 2.0 / 3.0 * 0.3 * np.sqrt(2.0), rel=1e-14)


@pytest.mark.parametrize("shape", SURFACES, ids=named)
def test_a_point_is_found_and_read_as_the_element_interpolates(shape):
    rng = np.random.default_rng(1)
    lines = np.sort(np.concatenate([[-1.0, 1.0], rng.uniform(-1.0, 1.0, 4)]))
    nodes, elements = rectangle_mesh(lines, np.linspace(-0.5, 0.5, 4), shape=shape)
    values = FIELDS[shape.name](*nodes[:, :2].T)
    for x, y in rng.uniform(-1.0, 1.0, (50, 2)) * [1.0, 0.5]:
        element, weights = locate(shape, nodes, elements, np.array([x, y]))
        assert weights @ values[elements[element]] == pytest.approx(FIELDS[shape.name](x, y), abs=1e-13)
    corner = locate(shape, nodes, elements, np.array([1.0, 0.5]))
    assert corner[1] @ nodes[elements[corner[0]], 0] == pytest.approx(1.0, abs=1e-15)
    assert locate(shape, nodes, elements, np.array([1.001, 0.0])) is None
    assert locate(shape, nodes, elements, np.array([0.1, 0.0, 0.01])) is None


@pytest.mark.parametrize("shape", [TRIANGLE6, QUAD4], ids=named)
def test_a_point_is_found_in_bent_and_skew_elements(shape):
    """Inside what the nodes span, at the local position it was made from; outside by a hair, nowhere."""
    rng = np.random.default_rng(2)
    nodes, elements = rectangle_mesh(np.linspace(0, 2, 3), np.linspace(0, 1, 3), shape=shape)
    nodes = nodes + 0.06 * rng.uniform(-1.0, 1.0, nodes.shape)
    for element, corners in enumerate(elements):
        local = shape.strain_rule.points[:1] + 0.05
        point = (shape.functions(local) @ nodes[corners])[0]
        found, weights = locate(shape, nodes, elements, point)
        assert found == element
        np.testing.assert_allclose(weights, shape.functions(local)[0], atol=1e-12)
    # A point on the outer side, whose nodes bend it, and the same point pushed outwards.
    side = next((e, edge) for e in elements for edge in shape.edges if all(n in bottom(shape) for n in e[list(edge)]))
    ends = np.array(shape.nodes)[[side[1][0], side[1][1]]]
    local = np.atleast_2d(0.7 * ends[0] + 0.3 * ends[1])
    point = (shape.functions(local) @ nodes[side[0]])[0, :2]
    assert locate(shape, nodes, elements, point + np.array([0.0, 1e-7])) is not None
    assert locate(shape, nodes, elements, point - np.array([0.0, 1e-7])) is None


def bottom(shape):
    nodes, _ = rectangle_mesh(np.linspace(0, 2, 3), np.linspace(0, 1, 3), shape=shape)
    return np.flatnonzero(nodes[:, 1] == 0.0)


def test_grids_have_the_nodes_of_their_shape_in_order():
    lines = np.linspace(0, 2, 4), np.linspace(0, 1, 3)
    plain, triangles = rectangle_mesh(*lines)
    same, quads = rectangle_mesh(*lines, shape=QUAD4)
    np.testing.assert_array_equal(same, plain)
    assert (len(triangles), len(quads)) == (12, 6)
    nodes, elements = rectangle_mesh(*lines, shape=TRIANGLE6)
    fine, _ = rectangle_mesh(np.linspace(0, 2, 7), np.linspace(0, 1, 5))
    np.testing.assert_allclose(nodes, fine, atol=1e-15)  # every node of the grid with half the spacing, in its order
    np.testing.assert_allclose(nodes[elements[:, 3]], 0.5 * (nodes[elements[:, 0]] + nodes[elements[:, 1]]), atol=1e-15)


def test_a_shape_from_outside_gets_its_grid_its_area_and_its_probes():
    """Eight-node quad: nothing but the shape itself is written."""
    corners, sides = QUAD4.nodes, ((0, -1), (1, 0), (0, 1), (-1, 0))
    quad8 = Shape(
        "quad8",
        "quad",
        nodes=corners + sides,
        exponents=(*QUAD4.exponents, (2, 0), (0, 2), (2, 1), (1, 2)),
        corners=4,
        edges=((0, 4, 1), (1, 5, 2), (2, 6, 3), (3, 7, 0)),
        split=((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)),
        strain_degree=3,
        product_degree=5,
        vtk_cell=23,
    )
    try:
        assert register_shape(quad8) is register_shape(replace(quad8, name="quad8"))
        with pytest.raises(InputError, match="shape: expected a new name, got 'quad8'"):
            register_shape(replace(quad8, vtk_cell=9))
        nodes, elements = rectangle_mesh(np.linspace(0, 2, 4), np.linspace(0, 1, 3), shape=surface_shape("", "quad8"))
        assert len(nodes) == 4 * 3 + 3 * 3 + 4 * 2  # corners, sides along x, sides along y
        model = Model.from_mesh(nodes, surfaces={"quad8": elements}, membrane=FILM)
        assert model.mass == pytest.approx(2.0 * 1530.0 * 1e-4, rel=1e-14)
        element, weights = locate(quad8, nodes, elements, np.array([1.234, 0.777]))
        values = FIELDS["triangle6"](*nodes[:, :2].T)
        assert weights @ values[elements[element]] == pytest.approx(FIELDS["triangle6"](1.234, 0.777), abs=1e-13)
    finally:
        del SHAPES["quad8"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"domain": "circle"}, "expected one of 'line', 'triangle', 'quad', got 'circle'"),
        ({"exponents": ((0, 0), (1, 0))}, r"expected exponents of shape \(3, 2\), got \(2, 2\)"),
        ({"split": ((0, 1, 3),)}, "expected local node numbers 0 to 2, got 3"),
        ({"exponents": ((0, 0), (1, 0), (2, 0))}, "its monomials cannot interpolate its nodes"),
    ],
)
def test_a_shape_whose_parts_contradict_each_other_is_refused(change, words):
    with pytest.raises(InputError, match=f"shape odd: .*{words}"):
        replace(TRIANGLE3, name="odd", **change)


def test_cables_stand_where_the_layout_puts_them_whatever_the_element():
    def model(element, divisions):
        layout = AntennaLayout(2.0, 1.0, divisions, "alternating", 2.5, 1.5, 9, 5, element=element)
        metal = Material(7e10, 2700.0, 0.3)
        sections = CableSection(metal, 1e-6), BeamSection(metal, 1e-4, 1e-9, 1e-9, 1e-9)
        return build_antenna(layout, FILM, *sections, pretension_x=1.0, pretension_y=2.0)

    wanted = model("triangle3", (8, 4))
    for element, divisions in (("quad4", (8, 4)), ("triangle6", (4, 2)), ("triangle6", (8, 4)), ("triangle6", (6, 3))):
        found = model(element, divisions)
        np.testing.assert_allclose(found.nodes[found.cables], wanted.nodes[wanted.cables], atol=1e-14)
        assert found.mass == pytest.approx(wanted.mass, rel=1e-14)
    with pytest.raises(MeshError, match="divisions: expected at least 4 so that a mesh node meets each of the 9"):
        model("triangle6", (3, 2))
    with pytest.raises(MeshError, match="expected at least 3"):  # an odd number of spaces has no middle station
        graded_lines(1.0, 2, np.linspace(-0.5, 0.5, 4), TRIANGLE6)


BENT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0.0]])
SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def test_folded_elements_are_refused():
    with pytest.raises(MeshError, match=r"quads: element 0 \(nodes \[0, 2, 1, 3\]\) is (degenerate|folded)"):
        Model.from_mesh(SQUARE, quads=[[0, 2, 1, 3]], membrane=FILM)
    dart = np.vstack([SQUARE[:2], [0.3, 0.3, 0.0], SQUARE[3:]])
    with pytest.raises(MeshError, match=r"quads: element 0 .* is folded over \(1 such element\(s\)\); list its nodes"):
        Model.from_mesh(dart, quads=[[0, 1, 2, 3]], membrane=FILM)
    far = BENT.copy()
    far[3, 0] = 0.9
    with pytest.raises(MeshError, match=r"triangles: element 0 .* is folded over"):
        Model.from_mesh(far, triangles=[[0, 1, 2, 3, 4, 5]], membrane=FILM)
    with pytest.raises(MeshError, match=r"quads: element 0 .* is degenerate, area 0 m2"):
        Model.from_mesh(SQUARE * [1, 0, 0], quads=[[0, 1, 2, 3]], membrane=FILM)


def test_a_film_torn_at_a_middle_node_is_refused():
    nodes = np.vstack([BENT, [1.0, 1.0, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.5, 0.5, 0.0]])
    whole, torn = [[0, 1, 2, 3, 4, 5], [1, 6, 2, 7, 8, 4]], [[0, 1, 2, 3, 4, 5], [1, 6, 2, 7, 8, 9]]
    assert Model.from_mesh(nodes[:9], triangles=whole, membrane=FILM).membrane_count == 2
    with pytest.raises(MeshError, match=r"share the edge between nodes 1 and 2 but not the nodes between them \(1 "):
        Model.from_mesh(nodes, triangles=torn, membrane=FILM)
    with pytest.raises(MeshError, match="join elements of the same order"):
        Model.from_mesh(nodes[:7], triangles=whole[:1], surfaces={"triangle3": [[1, 6, 2]]}, membrane=FILM)


def test_shapes_mix_in_one_film():
    nodes, quads = rectangle_mesh(np.linspace(0, 2, 3), np.linspace(0, 1, 2), shape=QUAD4)
    lower_left, lower_right, upper_right, upper_left = quads[1]
    cut = [[lower_left, lower_right, upper_right], [lower_left, upper_right, upper_left]]
    stress = np.arange(9.0).reshape(3, 3)
    model = Model.from_mesh(nodes, triangles=cut, quads=quads[:1], membrane=FILM, membrane_stress=stress)
    assert [group.shape.name for group in model.surfaces] == ["triangle3", "quad4"]
    np.testing.assert_array_equal(model.groups[1].initial, stress[2:])
    assert model.triangle_owner.tolist() == [0, 1, 2, 2]
    np.testing.assert_array_equal(model.triangles[2:], [quads[0][[0, 1, 2]], quads[0][[0, 2, 3]]])
    np.testing.assert_allclose(model.centre("membrane", 2), [0.5, 0.5, 0.0])
    assert model.mass == pytest.approx(2.0 * FILM.mass_per_measure)
    with pytest.raises(InputError, match="surfaces: expected one of 'triangle3', 'triangle6', 'quad4', got 'hexagon'"):
        Model.from_mesh(nodes, surfaces={"hexagon": [[0, 1, 2]]}, membrane=FILM)
