"""Axes that turn with the structure, in which an old tangent stays good.

The stiffness of a film, cable or beam is that of its plane or line. Rotating it by a degree couples transverse and
in-plane unknowns anew, which is what makes a kept tangent useless, though in axes that turn with the material it has
hardly changed. With Q the rotation of every node since the tangent was factorized

    K_now ~ Q K_then Q',    K_now^-1 ~ Q K_then^-1 Q'

(the corotational view of a tangent; a node's mass is the same in all directions, so the effective stiffness of a step
turns likewise). Only the iteration's speed depends on it, never its result.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_array

from tautflex.mechanics.products import product
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices, Places, cross_matrix, jit
from tautflex.solvers.remembering import Remembering

# Directions in which the neighbours of a node say nothing about its rotation: along a straight cable or beam.
_SINGULAR = 1e-6
_CROSS_MATRICES = np.array([cross_matrix(axis) for axis in np.eye(3)])


@jit
def turn(places: Places, owner: Places, angle: Array, sign: float, vector: Array) -> None:
    """Rotate every vector of three unknowns by ``sign angle``, in place.

    By Cayley's map, ``v + (t x v + t x (t x v) / 2) / (1 + t't/4)``: orthogonal however large the angle, and its
    transpose is the rotation by ``-angle``.
    """
    for k in range(owner.size):
        i, j, m = places[k, 0], places[k, 1], places[k, 2]
        x, y, z = sign * angle[owner[k], 0], sign * angle[owner[k], 1], sign * angle[owner[k], 2]
        a, b, c = vector[i], vector[j], vector[m]
        share = 1.0 / (1.0 + 0.25 * (x * x + y * y + z * z))
        p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
        vector[i] = a + share * (p + 0.5 * (y * r - z * q))
        vector[j] = b + share * (q + 0.5 * (z * p - x * r))
        vector[m] = c + share * (r + 0.5 * (x * q - y * p))


@jit
def node_angles(start: Indices, column: Places, value: Array, q: Array, then: Array, share: float) -> Array:
    """Rotations of all nodes from ``then`` to ``q``, shape (node, 3)."""
    moved = np.empty(q.size)
    for i in range(q.size):
        moved[i] = share * (q[i] - then[i])
    return product(start, column, value, moved).reshape((-1, 3))


def _neighbours(system: StructuralSystem) -> Indices:
    """Pairs of nodes that share an element, each in both directions, shape (pair, 2)."""
    count, keys = len(system.model.nodes), [np.zeros(0, dtype=np.int64)]
    for group in system.model.groups:
        corners = group.connectivity.T
        keys += [count * corners[i] + corners[j] for i in range(len(corners)) for j in range(len(corners)) if i != j]
    return np.stack(np.divmod(np.unique(np.concatenate(keys)), count), axis=1)


def rotation_operator(system: StructuralSystem, nodes: Indices) -> csr_array:
    """Rotations of nodes that fit the displacements of their neighbours best, linear in the free unknowns.

    Minimises ``sum |d - theta x e|^2 / |e|^2`` over the neighbours, with e their distance and d their relative
    displacement: ``theta = (sum I - e e'/|e|^2)^-1 sum e x d / |e|^2``; exact for a rigid rotation.

    Parameters
    ----------
    system
        The structure.
    nodes
        Node numbers.

    Returns
    -------
    csr_array
        Rotation vectors [rad], node after node, from free unknowns, shape (3 nodes, size).
    """
    model, count = system.model, len(nodes)
    rank = np.full(len(model.nodes), -1)
    rank[nodes] = np.arange(count)
    pairs = _neighbours(system)
    pairs = pairs[rank[pairs[:, 0]] >= 0]
    own, arm = rank[pairs[:, 0]], model.nodes[pairs[:, 1]] - model.nodes[pairs[:, 0]]
    square = np.sum(arm**2, axis=1)[:, None, None]
    normal = np.zeros((count, 3, 3))
    np.add.at(normal, own, np.eye(3) - arm[:, :, None] * arm[:, None, :] / square)
    cross = np.tensordot(arm, _CROSS_MATRICES, 1)
    weight = np.linalg.pinv(normal, rcond=_SINGULAR, hermitian=True)[own] @ cross / square
    rows = np.broadcast_to((3 * own[:, None] + np.arange(3))[:, :, None], weight.shape)
    columns = [np.broadcast_to(model.translation_dofs[pairs[:, end], None, :], weight.shape) for end in (1, 0)]
    values = np.concatenate([weight.ravel(), -weight.ravel()])
    row, column = np.concatenate([rows.ravel()] * 2), np.concatenate([part.ravel() for part in columns])
    operator = csr_array(csr_array((values, (row, column)), shape=(3 * count, model.dof_count)) @ model.expansion)
    operator.sort_indices()
    operator.data[np.abs(operator.data) <= 1e-12 * np.abs(operator.data).max(initial=0.0)] = 0.0
    operator.eliminate_zeros()
    return operator


def still(size: int) -> tuple[Any, ...]:
    """What `Corotation.parts` are where no node turns."""
    none, places, nobody = np.zeros(0), np.zeros((0, 3), dtype=np.uint32), np.zeros(0, dtype=np.uint32)
    return np.zeros(1, dtype=np.int64), nobody, none, places, nobody, np.zeros(size)


class Corotation(Remembering):
    """Rotation of a structure's nodes since its tangent was factorized.

    Parameters
    ----------
    system
        The structure. Nodes with supported translations are not turned.
    """

    MEMORY = ("_then",)

    def __init__(self, system: StructuralSystem) -> None:
        model = system.model
        place = system.place[model.translation_dofs]
        nodes = np.flatnonzero(np.all(place < system.size, axis=1))
        operator = rotation_operator(system, nodes)
        self._operator = operator.indptr.astype(np.int64), operator.indices.astype(np.uint32), operator.data
        # Rotations of beam nodes are vectors that turn as well.
        offset = model.dof_offset
        turned = nodes[np.diff(offset)[nodes] == 6]
        rotations = system.place[offset[turned][:, None] + np.arange(3, 6)]
        free = np.all(rotations < system.size, axis=1)
        owners = [np.arange(len(nodes)), np.searchsorted(nodes, turned[free])]
        self._places = np.concatenate([place[nodes], rotations[free]]).astype(np.uint32)
        self._owner = np.concatenate(owners).astype(np.uint32)
        self._then = np.zeros(system.size)
        self._angle = np.zeros((len(nodes), 3))

    @property
    def parts(self) -> tuple[Any, ...]:
        """Operator of `node_angles`, places and owners of `turn`, and where the tangent was factorized."""
        return *self._operator, self._places, self._owner, self._then

    def restart(self, q: Array) -> None:
        """A tangent was factorized at ``q``, shape (size,)."""
        self._then = q.copy()
        self._angle = np.zeros_like(self._angle)

    def follow(self, q: Array, share: float = 1.0) -> None:
        """Turn with the nodes to ``q``, shape (size,); ``share`` is the part of the stiffness that turns."""
        self._angle = node_angles(*self._operator, q, self._then, share)

    def into(self, vector: Array) -> Array:
        """``Q' vector``: as seen where the tangent was factorized, a new array of shape (size,)."""
        turned = vector.copy()
        turn(self._places, self._owner, self._angle, -1.0, turned)
        return turned

    def out_of(self, vector: Array) -> Array:
        """``Q vector``, in place."""
        turn(self._places, self._owner, self._angle, 1.0, vector)
        return vector
