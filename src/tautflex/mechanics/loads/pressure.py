"""Static loads: follower pressure on the film and dead forces on nodes."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.elements.linked import led_dofs
from tautflex.errors import InputError
from tautflex.mechanics.system import HasSystem, StructuralSystem, system_of
from tautflex.numeric import Array, Places
from tautflex.structure.groups import ElementGroup
from tautflex.structure.orientation import facing
from tautflex.text import count, span

# What leaves the range of numbers makes no step of any solver, which says so.
_QUIETLY = np.errstate(over="ignore", invalid="ignore")


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
    return system.on_free(full)


class PressureLoad:
    """Pressure that stays normal to the film while it moves.

    It acts along the right-hand normal of the corner order and is integrated over the interpolated surface. Elements
    that are listed the other way round than most of their piece of film are turned over first.

    Parameters
    ----------
    system
        Prestressed state, or its system.
    pressure
        Pressure [Pa], one number or one per film element, shape (t,).

    Raises
    ------
    InputError
        If there is no film, an argument has the wrong type or shape, or a value is not finite.
    MeshError
        If the film has one side only.

    Notes
    -----
    The derivative of the force is symmetric where the film's edge is closed, held, or slides in planes through the
    origin (symmetry planes); its work is then pressure times enclosed volume. A free edge takes and gives work on the
    way round a closed path: the derivative has a skew part there, and no potential exists [Bufler 1984].
    """

    def __init__(self, system: StructuralSystem | HasSystem, pressure: ArrayLike) -> None:
        system = system_of("system", system)
        model = system.model
        if not model.membrane_count:
            raise InputError("pressure: expected a model with a film, got none; give triangles and a membrane section")
        self.pressure, self._system = checks.spread("pressure", pressure, model.membrane_count), system
        sign = facing(model.nodes, model.surfaces)
        films = [group for group in model.element_groups if group.shape.dimension == 2]
        ends = np.cumsum([len(group.connectivity) for group in films])[:-1]
        self._patches = [_Patch(system, group, own) for group, own in zip(films, np.split(sign, ends), strict=True)]

    def __repr__(self) -> str:
        return f"PressureLoad({span(self.pressure, 'Pa')} on {count(self.pressure, 'film element')})"

    def scaled(self, pressure: ArrayLike) -> PressureLoad:
        """Another pressure [Pa] on the same film, one number or one per film element, shape (t,)."""
        other = copy(self)
        other.pressure = checks.spread("pressure", pressure, len(self.pressure))
        return other

    def belongs_to(self, system: StructuralSystem) -> bool:
        """Whether the film is that of a system, in whatever state."""
        own, other = self._system, system
        return own.pattern.entries == other.pattern.entries and np.array_equal(own.model.nodes, other.model.nodes)

    def _parts(self) -> Iterator[tuple[_Patch, Array]]:
        first = 0
        for patch in self._patches:
            yield patch, self.pressure[first : first + patch.count]
            first += patch.count

    @_QUIETLY
    def force(self, q: Array) -> Array:
        """Force on the free unknowns [N], shape (size,): ``p n`` weighted with each node's interpolation function."""
        force, extended = np.zeros(self._system.size + 1), np.append(q, 0.0)
        for patch, pressure in self._parts():
            np.add.at(force, patch.dofs, patch.led(patch.forces(pressure, extended)))
        return force[:-1]

    @_QUIETLY
    def wrench(self, q: Array) -> Array:
        """Force [N], and torque about the origin [N m], on all nodes, held ones too, shape (6,)."""
        total, extended = np.zeros(6), np.append(q, 0.0)
        for patch, pressure in self._parts():
            forces, places = patch.forces(pressure, extended), patch.places(extended)
            total += np.concatenate([forces.sum(axis=(0, 1)), np.cross(places, forces).sum(axis=(0, 1))])
        return total

    def wrench_slopes(self, vectors: Array) -> Array:
        """Derivative of the wrench by motion from rest along vectors (r, size), shape (6, r).

        Forces are quadratic in the places of nodes, so that their central differences are exact.
        """
        slopes, still = np.zeros((6, len(vectors))), np.zeros(self._system.size + 1)
        for patch, pressure in self._parts():
            here, force = patch.places(still), patch.forces(pressure, still)
            for column, vector in enumerate(np.append(vectors, np.zeros((len(vectors), 1)), axis=1)):
                change = 0.5 * (patch.forces(pressure, vector) - patch.forces(pressure, -vector))
                torque = np.cross(patch.places(vector) - here, force) + np.cross(here, change)
                slopes[:, column] += np.concatenate([change.sum(axis=(0, 1)), torque.sum(axis=(0, 1))])
        return slopes

    def mean_force(self, start: Array, end: Array) -> Array:
        """Mean of the force on the straight way between two states [N], shape (size,); exact, it is quadratic in q."""
        return (self.force(start) + 4.0 * self.force(0.5 * (start + end)) + self.force(end)) / 6.0

    def work(self, q: Array) -> float:
        """Work on the straight way from the reference [J]: pressure times the volume that the film sweeps."""
        return float(self.mean_force(np.zeros_like(q), q) @ q)

    def stiffness(self, q: Array) -> Array:
        """Symmetric part of `tangent`: all of it where the film's edge is held; see Notes."""
        values = self.tangent(q)
        return np.asarray(0.5 * (values + values[self._system.pattern.transpose_slots]))

    def tangent(self, q: Array) -> Array:
        """Derivative of the force [N/m], values in the pattern, shape (entries,)."""
        values, extended = np.zeros(self._system.pattern.entries + 1), np.append(q, 0.0)
        for patch, pressure in self._parts():
            np.add.at(values, patch.slots, patch.derivative(pressure, extended))
        return values[:-1]


class _Patch:
    """Film elements of one shape under pressure; ``sign`` is -1 for those to be turned over, shape (element,)."""

    def __init__(self, system: StructuralSystem, group: ElementGroup, sign: Array) -> None:
        self.count, self._sign = len(sign), sign
        dofs = system.model.translation_dofs[group.connectivity].reshape(len(sign), -1)
        dofs, self._shares = led_dofs(dofs, system.model.constraints)
        self.dofs = system.place[dofs]
        self._reference = system.model.nodes[group.connectivity]
        self._system, shape = system, group.shape
        points, weights = shape.product_rule
        slopes = shape.slopes(points)
        # Force of node i: sum over j, k of weight[i, j, k] x_j x x_k, skew in j and k.
        one = np.einsum("p,pi,pj,pk->ijk", weights, shape.functions(points), slopes[:, :, 0], slopes[:, :, 1])
        self._weight = 0.5 * (one - one.swapaxes(1, 2))

    @cached_property
    def slots(self) -> Places:
        """Place of every entry of the elements' matrices in the pattern, shape (element, dof, dof)."""
        return self._system.pattern.slots(self.dofs[:, :, None], self.dofs[:, None, :])

    def places(self, extended: Array) -> Array:
        """Where the nodes are [m], shape (element, node, 3)."""
        moved = extended[self.dofs]
        if self._shares is not None:
            moved = np.einsum("nij,nj->ni", self._shares, moved)
        return np.asarray(self._reference + moved.reshape(self._reference.shape))

    def led(self, forces: Array) -> Array:
        """Nodal forces (element, node, 3) as they act on what leads the nodes, shape (element, dof)."""
        flat = forces.reshape(self.count, -1)
        return flat if self._shares is None else np.einsum("nij,ni->nj", self._shares, flat)

    def _levers(self, pressure: Array, places: Array) -> Array:
        """Of nodes i, j: the force on i is the sum over j of x_j x lever [N/m], shape (element, i, j, 3)."""
        return np.einsum("n,ijk,nkx->nijx", pressure * self._sign, self._weight, places, optimize=True)

    def forces(self, pressure: Array, extended: Array) -> Array:
        """Nodal forces [N], shape (element, node, 3)."""
        places = self.places(extended)
        return np.cross(places[:, None], self._levers(pressure, places)).sum(axis=2)

    def derivative(self, pressure: Array, extended: Array) -> Array:
        """Of the forces by the displacements [N/m], shape (element, dof, dof)."""
        # A motion d of node j changes both factors, each by the same: it turns into d x (2 lever).
        blocks = np.cross(np.eye(3), 2.0 * self._levers(pressure, self.places(extended))[:, :, :, None, :])
        width = 3 * self._reference.shape[1]
        matrices = blocks.transpose(0, 1, 4, 2, 3).reshape(self.count, width, width)
        return matrices if self._shares is None else self._shares.swapaxes(1, 2) @ matrices @ self._shares
