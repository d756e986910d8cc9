"""Shapes of elements: where nodes sit, what is interpolated between them, how to integrate, draw and write them.

A shape is data as well: local node positions and the monomials that span its interpolation; functions, slopes and
rules follow. Everything that must know what an element looks like (meshes, masses, pressure, probes, pictures, files)
asks its shape and nobody asks "triangle, cable or beam?". Shapes stand below the elements, because a model and its
checks need them before any element is declared.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices

Numbers = tuple[tuple[int, ...], ...]

DOMAINS = {"line": 1, "triangle": 2, "quad": 2}
"""Local domain -> dimension: [-1, 1]; the triangle (0, 0), (1, 0), (0, 1); [-1, 1] x [-1, 1]."""


class Rule(NamedTuple):
    """Quadrature rule: local positions (point, dimension) and weights (point,) that add up to the domain's measure."""

    points: Array
    weights: Array


@dataclass(frozen=True)
class Shape:
    """Geometry of one element type.

    Parameters
    ----------
    name
        How case files and messages call it.
    domain
        Local domain, a key of `DOMAINS`.
    nodes
        Local position of each node; corners first, counter-clockwise.
    exponents
        Exponents of the monomials that span the interpolation, one row per node.
    corners
        Number of corners.
    edges
        Local node numbers along each edge, end to end.
    split
        Local node numbers of the linear triangles, counter-clockwise, or lines that stand for it in pictures.
    strain_degree, product_degree
        Degree of the rules that integrate strains, and products of two interpolation functions (mass, pressure).
    vtk_cell
        VTK's number of the cell type, whose order of nodes is that of ``nodes``.

    Raises
    ------
    InputError
        If the parts contradict each other.
    """

    name: str
    domain: str
    nodes: tuple[tuple[float, ...], ...]
    exponents: Numbers
    corners: int
    edges: Numbers
    split: Numbers
    strain_degree: int
    product_degree: int
    vtk_cell: int

    def __post_init__(self) -> None:
        checks.one_of(f"shape {self.name}: domain", self.domain, tuple(DOMAINS))
        expected = (len(self.nodes), self.dimension)
        for what in ("nodes", "exponents"):
            if np.shape(getattr(self, what)) != expected:
                raise InputError(
                    f"shape {self.name}: expected {what} of shape {expected}, got {np.shape(getattr(self, what))}; "
                    "give every node a local position and the interpolation one monomial per node"
                )
        for number in (number for part in (*self.edges, *self.split) for number in part):
            if not 0 <= number < len(self.nodes):
                raise InputError(
                    f"shape {self.name}: expected local node numbers 0 to {len(self.nodes) - 1}, got {number}"
                )
        if np.linalg.cond(self._monomials(np.array(self.nodes, dtype=float))) > 1e12:
            raise InputError(f"shape {self.name}: its monomials cannot interpolate its nodes; change the exponents")

    @property
    def dimension(self) -> int:
        """1 for lines, 2 for surfaces."""
        return DOMAINS[self.domain]

    @property
    def midside_nodes(self) -> bool:
        """Whether every edge has a node in its middle."""
        return all(len(edge) == 3 for edge in self.edges)

    def sides(self, connectivity: Indices) -> Indices:
        """Both ends of every side of elements, side by side as they run around each, shape (element * side, 2)."""
        return connectivity[:, [(edge[0], edge[-1]) for edge in self.edges]].reshape(-1, 2)

    def least_divisions(self, intervals: int) -> int:
        """Least number of cells along a side whose nodes meet the ends of this many even intervals."""
        return intervals // 2 if self.midside_nodes and intervals % 2 == 0 else intervals

    @cached_property
    def strain_rule(self) -> Rule:
        """Rule for strains: its points are the element's integration points."""
        return quadrature(self.domain, self.strain_degree)

    @cached_property
    def product_rule(self) -> Rule:
        """Rule that is exact for products of two interpolation functions on straight-sided elements."""
        return quadrature(self.domain, self.product_degree)

    def functions(self, points: ArrayLike) -> Array:
        """Interpolation functions at local positions (point, dimension), shape (point, node)."""
        return self._monomials(np.asarray(points, dtype=float)) @ self._coefficients

    def slopes(self, points: ArrayLike) -> Array:
        """Their derivatives along the local coordinates, shape (point, node, dimension)."""
        local, powers = np.asarray(points, dtype=float), np.array(self.exponents)
        found = []
        for axis in range(self.dimension):
            lowered = np.maximum(powers - np.eye(self.dimension, dtype=int)[axis], 0)
            found.append((powers[:, axis] * np.prod(local[:, None] ** lowered, axis=2)) @ self._coefficients)
        return np.stack(found, axis=2)

    def tangents(self, positions: Array, points: ArrayLike) -> Array:
        """Derivatives of the position along the local coordinates [m], shape (element, point, dimension, 3).

        ``positions`` are those of the nodes [m], shape (element, node, 3), ``points`` local ones, shape (point,
        dimension).
        """
        slopes = self.slopes(points).swapaxes(1, 2)
        # As one product per element: ten times faster than einsum.
        along = slopes.reshape(-1, len(self.nodes)) @ positions
        return np.asarray(along.reshape(-1, *slopes.shape[:2], 3))

    def stretch(self, positions: Array, points: ArrayLike) -> Array:
        """Length or area per local measure, shape (element, point); arguments as for `tangents`."""
        along = self.tangents(positions, points)
        vectors = along[:, :, 0] if self.dimension == 1 else np.cross(along[:, :, 0], along[:, :, 1])
        return np.asarray(np.linalg.norm(vectors, axis=2))

    def measure(self, positions: Array) -> Array:
        """Length [m] or area [m^2] of elements with these node positions (element, node, 3), shape (element,)."""
        return self.stretch(positions, self.strain_rule.points) @ self.strain_rule.weights

    def split_elements(self, connectivity: Indices) -> tuple[Indices, Indices]:
        """Linear triangles or lines of elements (element, node), element by element, and the element of each."""
        local = np.array(self.split)
        owner = np.repeat(np.arange(len(connectivity)), len(local))
        return connectivity[:, local].reshape(-1, local.shape[1]), owner

    def _monomials(self, points: Array) -> Array:
        return np.asarray(np.prod(points[:, None] ** np.array(self.exponents), axis=2))

    @cached_property
    def _coefficients(self) -> Array:
        """Column i holds the coefficients of node i's function."""
        return np.asarray(np.linalg.inv(self._monomials(np.array(self.nodes, dtype=float))), dtype=np.float64)


def quadrature(domain: str, degree: int) -> Rule:
    """Gauss rule of a domain, exact for polynomials of this total degree (per coordinate on lines and squares).

    Triangles: 1 point (degree 1), 3 (degree 2), 6 (degree 4, Dunavant 1985), else Gauss points of a collapsed square.
    """
    if domain == "triangle" and degree in _TRIANGLE_RULES:
        return _TRIANGLE_RULES[degree]
    count = degree // 2 + (2 if domain == "triangle" else 1)  # collapsing costs one degree
    abscissa, weight = np.polynomial.legendre.leggauss(count)
    if domain == "line":
        return Rule(abscissa[:, None], weight)
    first, second = (grid.ravel() for grid in np.meshgrid(abscissa, abscissa, indexing="ij"))
    weights = np.outer(weight, weight).ravel()
    if domain == "quad":
        return Rule(np.column_stack([first, second]), weights)
    x, y = 0.5 * (1.0 + first), 0.25 * (1.0 - first) * (1.0 + second)
    return Rule(np.column_stack([x, y]), 0.125 * weights * (1.0 - first))


def _symmetric_points(share: float) -> Array:
    """Three points with two area coordinates equal to ``share``, the n-th nearest to (or opposite) corner n."""
    area = np.full((3, 3), share) + (1.0 - 3.0 * share) * np.eye(3)
    return area[:, 1:]


_ROOT = np.sqrt(38.0 - 44.0 * np.sqrt(0.4))
_OUTER = np.sqrt(213125.0 - 53320.0 * np.sqrt(10.0))
_TRIANGLE_RULES = {
    1: Rule(np.full((1, 2), 1.0 / 3.0), np.full(1, 0.5)),
    2: Rule(_symmetric_points(1.0 / 6.0), np.full(3, 1.0 / 6.0)),
    4: Rule(
        np.concatenate([_symmetric_points((8.0 - np.sqrt(10.0) + sign * _ROOT) / 18.0) for sign in (1.0, -1.0)]),
        np.repeat([(620.0 + _OUTER) / 7440.0, (620.0 - _OUTER) / 7440.0], 3),
    ),
}

LINE2 = Shape("line2", "line", ((-1,), (1,)), ((0,), (1,)), 2, ((0, 1),), ((0, 1),), 1, 2, vtk_cell=3)
TRIANGLE3 = Shape(
    "triangle3",
    "triangle",
    nodes=((0, 0), (1, 0), (0, 1)),
    exponents=((0, 0), (1, 0), (0, 1)),
    corners=3,
    edges=((0, 1), (1, 2), (2, 0)),
    split=((0, 1, 2),),
    strain_degree=1,
    product_degree=2,
    vtk_cell=5,
)
TRIANGLE6 = Shape(
    "triangle6",
    "triangle",
    nodes=((0, 0), (1, 0), (0, 1), (0.5, 0), (0.5, 0.5), (0, 0.5)),
    exponents=((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)),
    corners=3,
    edges=((0, 3, 1), (1, 4, 2), (2, 5, 0)),
    split=((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    strain_degree=2,
    product_degree=4,
    vtk_cell=22,
)
QUAD4 = Shape(
    "quad4",
    "quad",
    nodes=((-1, -1), (1, -1), (1, 1), (-1, 1)),
    exponents=((0, 0), (1, 0), (0, 1), (1, 1)),
    corners=4,
    edges=((0, 1), (1, 2), (2, 3), (3, 0)),
    split=((0, 1, 2), (0, 2, 3)),
    strain_degree=3,
    product_degree=3,
    vtk_cell=9,
)

SHAPES: dict[str, Shape] = {shape.name: shape for shape in (LINE2, TRIANGLE3, TRIANGLE6, QUAD4)}
"""All shapes by name; an element from outside adds its own with `register_shape`."""


def surface_shape(argument: str, name: str) -> Shape:
    """Shape of film elements by its name; InputError that names the ones there are."""
    return SHAPES[checks.one_of(argument, name, [key for key, shape in SHAPES.items() if shape.dimension == 2])]


def register_shape(shape: Shape) -> Shape:
    """Make a shape known by its name; InputError if another one has it."""
    known = SHAPES.setdefault(shape.name, shape)
    if known != shape:
        raise InputError(f"shape: expected a new name, got {shape.name!r}, which another shape has; rename it")
    return known
