"""What an element is to the rest of the code: constant arrays, one row per integration point.

With nodal unknowns ``q`` of one element, the gradients at one of its points are ``g = gradient @ q``, its strains are
quadratic, ``strain = linear @ g + 1/2 g . quadratic . g``, and the point's energy is
``measure * (initial_stress . strain + 1/2 strain . elasticity . strain)`` [theory.md 2]. A law may replace the stress.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.laws import Elastic, Law
from tautflex.elements.local_frame import local_slopes, make_room, to_local
from tautflex.numeric import Array, Indices
from tautflex.structure.materials import Material
from tautflex.text import brief

S = TypeVar("S", bound=np.generic)


@dataclass(frozen=True)
class InertiaPoints:
    """Mass as weighted points, exact for the products of interpolations that inertia needs.

    Parameters
    ----------
    mass
        Mass of each point [kg], shape (element, point).
    interpolation
        Displacement of each point from the element's unknowns, global axes, shape (element or 1, point, 3, dof).
    position
        Reference position of each point [m], shape (element, point, 3).
    turning
        What finite rotations add to ``M(Z)`` in the moving frame, see `turning_terms`, shape (element, 3, 3, dof, dof);
        None where displacements are linear in the unknowns.
    """

    mass: Array
    interpolation: Array
    position: Array
    turning: Array | None = None
    __repr__ = brief


_ELASTIC = Elastic()


@dataclass(frozen=True)
class ElementBlock:
    """All elements of one group as data; a row is one integration point.

    Parameters
    ----------
    kind
        Kind of the section: ``"membrane"``, ``"cable"`` or ``"beam"``.
    dofs
        Unknowns of each element, shape (element, dof).
    gradient
        Gradient matrix, global axes, shape (row, gradient, dof).
    linear
        Linear strain coefficients, shape (strain, gradient).
    quadratic
        Quadratic strain coefficients, symmetric in the last two axes, shape (strain, gradient, gradient).
    elasticity
        Elastic matrix, shape (row, strain, strain); SI units that make measure * stress * strain an energy.
    initial_stress
        Stress at zero unknowns, shape (row, strain).
    measure
        Volume or length that a row stands for, shape (row,).
    size
        Thickness of a film [m], area of a cable [m^2], shape (row,): resultant = stress * size, and a row stands for
        the area or length measure / size. 1 where stresses are resultants.
    inertia
        Mass points.
    axes
        Local axes as rows, shape (row, 3, 3).
    material
        What the elements are made of.
    law
        Makes stress of the elastic trial stress.
    owner
        Element of each row, ascending, shape (row,); None where every element is one row.
    turns
        Whether strains are those of the nine gradients of a line seen from its local frame, see `local_frame`, which
        the ends may turn by any angle.
    """

    kind: str
    dofs: Indices
    gradient: Array
    linear: Array
    quadratic: Array
    elasticity: Array
    initial_stress: Array
    measure: Array
    size: Array
    inertia: InertiaPoints
    axes: Array
    material: Material
    law: Law = _ELASTIC
    owner: Indices | None = None
    turns: bool = False
    __repr__ = brief

    @property
    def is_elastic(self) -> bool:
        """Whether the trial stress is the stress."""
        return self.law.function is None

    def strain(self, unknowns: Array) -> Array:
        """Strains of rows from their unknowns, shapes (row, dof) and (row, strain)."""
        g, _ = self._seen(unknowns)
        strain: Array = g @ self.linear.T + 0.5 * np.einsum("ni,sij,nj->ns", g, self.quadratic, g)
        return strain

    def strain_slope(self, unknowns: Array) -> Array:
        """Derivatives of the strains of rows by their unknowns, shapes (row, dof) -> (row, strain, dof)."""
        g, gradient = self._seen(unknowns)
        return np.asarray(np.matmul(self.linear + np.einsum("sgk,nk->nsg", self.quadratic, g), gradient))

    def _seen(self, unknowns: Array) -> tuple[Array, Array]:
        """Gradients that strains are quadratic in, and their derivatives by the unknowns."""
        g = np.einsum("nij,nj->ni", self.gradient, unknowns)
        if not self.turns:
            return g, self.gradient
        given, room, slopes = np.ascontiguousarray(g.T), make_room(), np.empty((len(g), g.shape[1], g.shape[1]))
        local = np.empty_like(given)
        to_local(given, len(g), local)
        for row, slope in enumerate(slopes):
            local_slopes(given, row, room, slope)
        return local.T, slopes @ self.gradient

    def rows_of(self, values: NDArray[S]) -> NDArray[S]:
        """Values of elements (element, ...) for their rows (row, ...)."""
        return values if self.owner is None else values[self.owner]

    def elements_of(self, values: NDArray[S], reduce: np.ufunc) -> NDArray[S]:
        """Values of rows (row, ...) reduced to elements (element, ...), as by ``numpy.minimum`` or ``numpy.add``."""
        if self.owner is None:
            return values
        result: NDArray[S] = reduce.reduceat(values, np.searchsorted(self.owner, np.arange(len(self.dofs))))
        return result


def translating_points(mass: Array, functions: Array, positions: Array) -> InertiaPoints:
    """Mass points of elements without rotations.

    ``mass`` is that of each point [kg], shape (element, point), ``functions`` the interpolation there, shape (point,
    node), ``positions`` those of the nodes [m], shape (element, node, 3).
    """
    interpolation = np.einsum("pi,kl->pkil", functions, np.eye(3)).reshape(1, len(functions), 3, -1)
    return InertiaPoints(mass, interpolation, np.einsum("pi,nik->npk", functions, positions))


def turning_terms(second: Array, rotation: Array) -> Array:
    """Second-order displacements of turning sections in the moments of the moving frame.

    A point at ``r`` from the axis moves by ``theta x r + theta x (theta x r)/2 + ...``. In the force of the frame,
    ``int rho (du/dtheta)' Z (r + u)``, both terms count to first order: beside ``theta x r`` twice there is
    ``sym(Z P) - tr(Z P) 1`` with ``P = int rho x r'``. Without it turning about the spin axis costs work.

    Parameters
    ----------
    second
        P of each point of the axis [kg m^2], global axes, shape (element, point, 3, 3); ``int rho r r'`` where sections
        balance about the axis.
    rotation
        Rotation vector of each point of the axis from the element's unknowns, shape (element or 1, point, 3, dof).

    Returns
    -------
    Array
        Matrices of symmetric Z, shape (element, 3, 3, dof, dof); of skew ones, frames that speed up, there are none.
    """
    turned = np.einsum("ac,npbd->npabcd", np.eye(3), second)
    turned = 0.5 * (turned + turned.swapaxes(4, 5)) - np.einsum("npba,cd->npabcd", second, np.eye(3))
    turned = 0.5 * (turned + turned.swapaxes(2, 3))
    rotation = np.broadcast_to(rotation, (*second.shape[:2], *rotation.shape[2:]))
    result: Array = np.einsum("npci,npabcd,npdj->nabij", rotation, turned, rotation, optimize=True)
    return result


def symmetric_terms(strains: int, gradients: int, terms: list[tuple[int, int, int, float]]) -> Array:
    """Quadratic coefficients such that ``strain[s] += c * g[i] * g[j]`` for every term (s, i, j, c)."""
    quadratic = np.zeros((strains, gradients, gradients))
    for strain, i, j, coefficient in terms:
        quadratic[strain, i, j] += coefficient
        quadratic[strain, j, i] += coefficient
    return quadratic
