"""Numbering of a structure's unknowns: which exist, which are held, and how it moves as a rigid body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.groups import DIRECTIONS, ElementGroup, Support


@dataclass(frozen=True)
class Numbering:
    """Nodes, groups of elements and supports, and the unknowns that follow from them.

    Unknowns are numbered node by node: three translations, then three rotations at nodes that carry beams.
    """

    nodes: Array
    groups: tuple[ElementGroup, ...]
    supports: tuple[Support, ...] = ()

    @cached_property
    def dof_offset(self) -> Indices:
        """First unknown of each node, shape (node + 1,); the last entry is the number of unknowns."""
        per_node = np.full(len(self.nodes), 3)
        for group in self.groups:
            if group.section.rotational:
                per_node[group.connectivity] = 6
        return np.concatenate([[0], np.cumsum(per_node)])

    @property
    def dof_count(self) -> int:
        """Number of unknowns before supports are applied."""
        return int(self.dof_offset[-1])

    def element_dofs(self, group: ElementGroup) -> Indices:
        """Unknowns of each element, shape (element, 3 or 6 per corner)."""
        count = 6 if group.section.rotational else 3
        first = self.dof_offset[group.connectivity]
        return (first[:, :, None] + np.arange(count)).reshape(len(first), -1)

    @cached_property
    def translation_dofs(self) -> Indices:
        """Unknowns of the three translations of each node, shape (node, 3)."""
        return self.dof_offset[:-1, None] + np.arange(3)

    @cached_property
    def fixed_dofs(self) -> Indices:
        """Unknowns held by supports, sorted."""
        fixed: set[int] = set()
        for support in self.supports:
            for direction in support.directions:
                step = DIRECTIONS.index(direction)
                for node in support.nodes:
                    dof = int(self.dof_offset[node]) + step
                    if dof < self.dof_offset[node + 1]:
                        fixed.add(dof)
        return np.array(sorted(fixed), dtype=np.int64)

    @cached_property
    def free_dofs(self) -> Indices:
        """Unknowns that can move, sorted."""
        return np.setdiff1d(np.arange(self.dof_count), self.fixed_dofs)

    @cached_property
    def free_places(self) -> Indices:
        """Place of every unknown in `free_dofs`, their number where it is held, shape (dof,)."""
        places = np.full(self.dof_count, len(self.free_dofs), dtype=np.int64)
        places[self.free_dofs] = np.arange(len(self.free_dofs))
        return places

    @cached_property
    def rigid_motions(self) -> Array:
        """Infinitesimal rigid motions about the origin, shape (dof, 6): three translations, three rotations."""
        motions = np.zeros((self.dof_count, 6))
        x, y, z = self.nodes.T
        dofs = self.translation_dofs
        for axis in range(3):
            motions[dofs[:, axis], axis] = 1.0
        motions[dofs[:, 1], 3], motions[dofs[:, 2], 3] = -z, y
        motions[dofs[:, 0], 4], motions[dofs[:, 2], 4] = z, -x
        motions[dofs[:, 0], 5], motions[dofs[:, 1], 5] = -y, x
        turning = np.flatnonzero(np.diff(self.dof_offset) == 6)
        for axis in range(3):
            motions[self.dof_offset[turning] + 3 + axis, 3 + axis] = 1.0
        return motions

    @cached_property
    def rigid_freedom(self) -> int:
        """Number of independent rigid motions that the supports leave free."""
        return self.freedom_of(np.full(len(self.nodes), True))

    def freedom_of(self, nodes: Mask) -> int:
        """The same of a piece of the structure, given as a flag for each node, shape (node,)."""
        motions = self.rigid_motions / max(1.0, float(np.abs(self.nodes).max()))
        own = np.repeat(nodes, np.diff(self.dof_offset))
        held = motions[self.fixed_dofs[own[self.fixed_dofs]]]
        rank = int(np.linalg.matrix_rank(held, tol=1e-9)) if held.size else 0
        return int(np.linalg.matrix_rank(motions[own], tol=1e-9)) - rank
