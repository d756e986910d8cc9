"""Static loads: follower pressure on the film and dead forces on nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import StructuralSystem

Array = NDArray[np.float64]


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

    It acts along the right-hand normal of each triangle's corner order. Its work is pressure times enclosed volume,
    whose second derivative is the symmetric tangent; that is exact where the film's edge is closed, held, or slides in
    planes through the origin (symmetry planes), and otherwise the symmetric part [Bufler 1984].

    Parameters
    ----------
    system
        The structure.
    pressure
        Pressure [Pa], one number or one per film element, shape (t,).

    Raises
    ------
    InputError
        If there is no film, or the shape is wrong.
    """

    def __init__(self, system: StructuralSystem, pressure: ArrayLike) -> None:
        model = system.model
        if not len(model.triangles):
            raise InputError("pressure: expected a model with a film, got none; give triangles and a membrane section")
        given = np.asarray(pressure, dtype=float)
        values = np.broadcast_to(given, (len(model.triangles),)) if given.ndim == 0 else given
        self.pressure = checks.float_array("pressure", values, (len(model.triangles),))
        self._system = system
        self._reference = model.nodes[model.triangles]
        self._dofs = system.place[model.translation_dofs[model.triangles]]
        flat = self._dofs.reshape(len(self._dofs), 9)
        self._slots = system.pattern.slots(flat[:, :, None], flat[:, None, :])

    def _corners(self, q: Array) -> Array:
        extended = np.append(q, 0.0)
        return self._reference + extended[self._dofs]

    def force(self, q: Array) -> Array:
        """Force on the free unknowns [N], shape (size,): a third of ``p A n`` at each corner."""
        corners = self._corners(q)
        area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        share = np.repeat((self.pressure[:, None] * area / 3.0)[:, None], 3, axis=1)
        force = np.zeros(self._system.size + 1)
        np.add.at(force, self._dofs, share)
        return force[:-1]

    def work(self, q: Array) -> float:
        """Pressure times the volume between the film and the origin, above that of the reference [J]."""
        moved, start = self._corners(q), self._reference
        change = _triple(moved) - _triple(start)
        return float(self.pressure @ change) / 6.0

    def tangent(self, q: Array) -> Array:
        """Second derivative of the work [N/m], values in the pattern, shape (entries,)."""
        corners = self._corners(q)
        blocks = np.zeros((len(corners), 3, 3, 3, 3))
        for i in range(3):
            # d/dx_j of x_i . (x_j x x_k)/6 by x_i: the cross matrix of x_k.
            j, k = (i + 1) % 3, (i + 2) % 3
            cross = _cross_matrices(corners[:, k]) * (self.pressure / 6.0)[:, None, None]
            blocks[:, i, :, j], blocks[:, j, :, i] = -cross, cross
        values = np.zeros(self._system.pattern.entries + 1)
        np.add.at(values, self._slots, blocks.reshape(len(corners), 9, 9))
        return values[:-1]


def _triple(corners: Array) -> Array:
    return np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2]), axis=1)


def _cross_matrices(vectors: Array) -> Array:
    """Matrices S with ``S b = v x b``, shape (n, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
