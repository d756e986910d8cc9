"""Static loads: follower pressure on the film and dead forces on nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import HasSystem, StructuralSystem, system_of
from tautflex.numeric import Array
from tautflex.structure.groups import ElementGroup
from tautflex.text import count, span

_EVEN, _ODD = ("ijk", "jki", "kij"), ("jik", "ikj", "kji")  # orders of three nodes, by the sign of their triple product


def nodal_load(system: StructuralSystem, forces: ArrayLike) -> Array:
    """Dead forces on nodes as a vector of free unknowns.

    Parameters
    ----------
    system
        The structure.
    forces
        Force on every node [N], shape (node, 3).

    Returns
    -------
    numpy.ndarray
        Force that acts on the structure [N, N m], shape (size,).

    Raises
    ------
    InputError
        If the shape is wrong or a value is not finite.
    """
    model = system.model
    values = checks.float_array("forces", forces, (len(model.nodes), 3))
    full = np.zeros(model.dof_count)
    full[model.translation_dofs] = values
    return full[model.free_dofs]


class PressureLoad:
    """Pressure that stays normal to the film while it moves.

    It acts along the right-hand normal of each element's corner order and is integrated over the interpolated surface.
    Its work is pressure times enclosed volume, whose second derivative is the symmetric tangent; that is exact where
    the film's edge is closed, held, or slides in planes through the origin (symmetry planes), and otherwise the
    symmetric part [Bufler 1984].

    Parameters
    ----------
    system
        Prestressed state, or its system.
    pressure
        Pressure [Pa], one number or one per film element, shape (t,).

    Raises
    ------
    InputError
        If there is no film, or the shape is wrong.
    """

    def __init__(self, system: StructuralSystem | HasSystem, pressure: ArrayLike) -> None:
        system = system_of("system", system)
        count = system.model.membrane_count
        if not count:
            raise InputError("pressure: expected a model with a film, got none; give triangles and a membrane section")
        self.pressure = checks.spread("pressure", pressure, count)
        self._system = system
        ends = np.cumsum([len(group.connectivity) for group in system.model.surfaces])[:-1]
        self._patches = [
            _Patch(system, group, own)
            for group, own in zip(system.model.surfaces, np.split(self.pressure, ends), strict=True)
        ]

    def __repr__(self) -> str:
        return f"PressureLoad({span(self.pressure, 'Pa')} on {count(self.pressure, 'film element')})"

    def force(self, q: Array) -> Array:
        """Force on the free unknowns [N], shape (size,): ``p n`` weighted with each node's interpolation function."""
        force, extended = np.zeros(self._system.size + 1), np.append(q, 0.0)
        for patch in self._patches:
            np.add.at(force, patch.dofs, patch.forces(extended))
        return force[:-1]

    def work(self, q: Array) -> float:
        """Pressure times the volume between the film and the origin, above that of the reference [J]."""
        extended = np.append(q, 0.0)
        return sum(patch.work(extended) - patch.work(np.zeros_like(extended)) for patch in self._patches)

    def tangent(self, q: Array) -> Array:
        """Second derivative of the work [N/m], values in the pattern, shape (entries,)."""
        values, extended = np.zeros(self._system.pattern.entries + 1), np.append(q, 0.0)
        for patch in self._patches:
            np.add.at(values, patch.slots, patch.second_derivative(extended))
        return values[:-1]


class _Patch:
    """Film elements of one shape under pressure."""

    def __init__(self, system: StructuralSystem, group: ElementGroup, pressure: Array) -> None:
        self.pressure = pressure
        self.dofs = system.place[system.model.translation_dofs[group.connectivity]]
        flat = self.dofs.reshape(len(self.dofs), -1)
        self.slots = system.pattern.slots(flat[:, :, None], flat[:, None, :])
        self._reference = system.model.nodes[group.connectivity]
        points, self._weights = group.shape.product_rule
        self._functions, self._slopes = group.shape.functions(points), group.shape.slopes(points)
        # The volume is sum over i, j, k of triple[i, j, k] x_i . (x_j x x_k) / 6, each triple counted with its sign.
        one = np.einsum("p,pi,pj,pk->ijk", self._weights, self._functions, *np.moveaxis(self._slopes, 2, 0)) / 3.0
        even, odd = (sum(np.einsum(f"{order}->ijk", one) for order in orders) for orders in (_EVEN, _ODD))
        self._triple = even - odd

    def _normals(self, corners: Array) -> Array:
        """Area vectors that the points of the rule stand for, shape (element, point, 3)."""
        along = np.einsum("pid,nik->npdk", self._slopes, corners)
        return self._weights[:, None] * np.cross(along[:, :, 0], along[:, :, 1])

    def forces(self, extended: Array) -> Array:
        """Nodal forces [N], shape (element, node, 3)."""
        normals = self._normals(self._reference + extended[self.dofs])
        return np.einsum("pi,npk->nik", self._functions, self.pressure[:, None, None] * normals)

    def work(self, extended: Array) -> float:
        """Pressure times the volume of the cones between the elements and the origin [J]."""
        corners = self._reference + extended[self.dofs]
        places = np.einsum("pi,nik->npk", self._functions, corners)
        return float(self.pressure @ np.einsum("npk,npk->n", places, self._normals(corners))) / 3.0

    def second_derivative(self, extended: Array) -> Array:
        """Of the work [N/m], shape (element, 3 node, 3 node)."""
        corners = self._reference + extended[self.dofs]
        levers = np.einsum("n,ijk,nkx->nijx", self.pressure, self._triple, corners)
        # Block (i, j) turns a motion d of node j into d x lever.
        blocks = np.cross(np.eye(3), levers[:, :, :, None, :])
        return blocks.transpose(0, 1, 4, 2, 3).reshape(self.slots.shape)
