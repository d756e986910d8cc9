"""How far film is off the plane that fits it best: root mean square, tilt and piston [theory.md 7].

The displacement w across the film and the plane ``a + b s + c t`` are interpolated as the film is, so that integrals
over its area are exact forms of nodal values: ``A = int N' N`` and P, the nodal values of (1, s, t), with s and t
counted from the film's centre of area. The plane that fits best is ``c = (P' A P)^-1 P' A w``, and what is left is
``rms^2 = (w - P c)' A (w - P c) / area``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from tautflex.mechanics.products import product, quadratic_form
from tautflex.numeric import Array, Indices, Places, jit
from tautflex.structure.model import Model

# Components of a direction that are round-off.
_NONE = 1e-12


class FilmSurface:
    """The film of a model as a reflecting surface; NaN without a film.

    Axes: across is the normal of the plane that fits the film's reference shape, its largest component positive; the
    first axis in it is x laid into the plane (y, where the film faces x), the second completes the right-handed three.
    Film in z = 0 has x, y, z.

    Parameters
    ----------
    model
        The structure.
    expansion
        All its unknowns from the free ones, shape (dof, size); None is the model's.

    Attributes
    ----------
    look
        Displacement across the film at its nodes, from free unknowns, shape (film node, size).
    weights
        A [m^2], shape (film node, film node).
    plane, fit
        P, and ``A P (P' A P)^-1``, shapes (film node, 3).
    area
        [m^2].
    parts
        What `measure_surface` reads.
    """

    def __init__(self, model: Model, expansion: csr_array | None = None) -> None:
        nodes = np.unique(np.concatenate([np.zeros(0, int), *(group.connectivity.ravel() for group in model.surfaces)]))
        self.weights = _area_products(model, nodes)
        positions, own = model.nodes[nodes], self.weights.sum(axis=1)
        self.area = float(own.sum())
        from_centre = positions - (own @ positions) / self.area if len(nodes) else positions
        axes = _axes(from_centre.T @ (self.weights @ from_centre))
        self.plane = np.column_stack([np.ones(len(nodes)), from_centre @ axes[0], from_centre @ axes[1]])
        weighed = self.weights @ self.plane
        self.fit = np.linalg.solve(self.plane.T @ weighed, weighed.T).T if len(nodes) else weighed
        self.look = _seen_across(model, nodes, axes[2], model.expansion if expansion is None else expansion)
        fit = np.ascontiguousarray(self.fit)  # one layout, and so one machine code, with and without film
        self.parts = (*_rows(self.look), *_rows(self.weights), self.plane, fit, self.area)

    def measure(self, q: Array, found: Array) -> None:
        """Write rms [m], tilt about both axes [rad] and piston [m] at free unknowns, shape (size,), to shape (4,)."""
        measure_surface(self.parts, q, found)


class SurfaceOnVectors:
    """The measures of `FilmSurface` for displacements that are sums of vectors, as those of reduced models are.

    Parameters
    ----------
    surface
        The film.
    vectors
        Shape (vector, size).

    Attributes
    ----------
    form
        Mean square of the deflection from the best plane as a form of the amounts, shape (vector, vector).
    """

    def __init__(self, surface: FilmSurface, vectors: Array) -> None:
        across = surface.look @ vectors.T
        self.count = len(vectors)
        self._plane = surface.fit.T @ across
        # Made free of the plane before it is squared: the difference of squares would lose half of the digits.
        left = across - surface.plane @ self._plane
        self.form = left.T @ (surface.weights @ left) / (surface.area or np.nan)
        self._plane[:, :] += 0.0 if surface.area else np.nan

    def measure(self, amounts: Array) -> Array:
        """Measures as `FilmSurface.measure` has them, shape (time, 4), from amounts of the vectors, (time, vector)."""
        square = np.sum((amounts @ self.form) * amounts, axis=1)
        piston, first, second = self._plane @ amounts.T
        return np.column_stack([np.sqrt(np.maximum(square, 0.0)), second, -first, piston])


def _area_products(model: Model, nodes: Indices) -> csr_array:
    """``int N_i N_j`` over the film [m^2], shape (film node, film node)."""
    rows, columns, values = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)]
    for group in model.surfaces:
        points, weights = group.shape.product_rule
        area = group.shape.stretch(model.nodes[group.connectivity], points) * weights
        functions = group.shape.functions(points)
        products = np.einsum("ep,pi,pj->eij", area, functions, functions)
        place = np.searchsorted(nodes, group.connectivity)
        rows.append(np.broadcast_to(place[:, :, None], products.shape).ravel())
        columns.append(np.broadcast_to(place[:, None, :], products.shape).ravel())
        values.append(products.ravel())
    where = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(values), where), shape=(len(nodes), len(nodes)))


def _axes(second_moment: Array) -> Array:
    """Both axes in the plane that fits points of this second moment [m^4] and its normal, as rows, shape (3, 3)."""
    normal = np.linalg.eigh(second_moment)[1][:, 0]
    normal = np.where(np.abs(normal) < _NONE, 0.0, normal)
    normal *= np.sign(normal[np.abs(normal).argmax()]) / np.linalg.norm(normal)
    along = np.eye(3)[int(abs(normal[0]) > np.sqrt(0.5))]
    first = along - (along @ normal) * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


def _seen_across(model: Model, nodes: Indices, normal: Array, expansion: csr_array) -> csr_array:
    """Displacement of nodes along a direction, from free unknowns, shape (node, size)."""
    row, axis = np.nonzero(np.broadcast_to(normal != 0.0, (len(nodes), 3)))
    shape = (len(nodes), model.dof_count)
    across = csr_array((normal[axis], (row, model.translation_dofs[nodes][row, axis])), shape=shape)
    result = csr_array(across @ expansion)
    result.sort_indices()
    return result


def _rows(matrix: csr_array) -> tuple[Indices, Places, Array]:
    return matrix.indptr.astype(np.int64), matrix.indices.astype(np.uint32), matrix.data


@jit
def measure_surface(parts: Any, q: Array, found: Array) -> None:
    """`FilmSurface.measure` with the ``parts`` of a surface."""
    look_start, look_column, look_value, start, column, value, plane, fit, area = parts
    if not area > 0.0:
        found[:] = np.nan
        return
    across = product(look_start, look_column, look_value, q)
    a, b, c = 0.0, 0.0, 0.0
    for i in range(across.size):
        a += fit[i, 0] * across[i]
        b += fit[i, 1] * across[i]
        c += fit[i, 2] * across[i]
    for i in range(across.size):
        across[i] -= a * plane[i, 0] + b * plane[i, 1] + c * plane[i, 2]
    found[0] = np.sqrt(max(quadratic_form(start, column, value, across), 0.0) / area)
    found[1], found[2], found[3] = c, -b, a
