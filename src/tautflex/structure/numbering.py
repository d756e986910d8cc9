"""Numbering of a structure's unknowns: which exist, which are held, and how it moves as a rigid body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import qr
from scipy.sparse import csr_array

from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.constraints import Constraints, constraints_of
from tautflex.structure.groups import DIRECTIONS, ElementGroup, Support
from tautflex.structure.links.link import Joined, Link
from tautflex.structure.masses import PointMass
from tautflex.structure.springs import Damper, Spring

_ROUND_OFF = 1e-9
# Elements without links between two with them stay with these: a block of its own costs about as much.
_GAP = 64


@dataclass(frozen=True)
class Numbering:
    """Nodes and all that stands on them, and the unknowns that follow from it.

    Unknowns are numbered node by node: three translations, then three rotations at nodes that carry beams, belong to
    rigid links, or carry a body that turns and are linked.
    """

    nodes: Array
    groups: tuple[ElementGroup, ...]
    supports: tuple[Support, ...] = ()
    masses: tuple[PointMass, ...] = field(default=(), kw_only=True)
    links: tuple[Link, ...] = field(default=(), kw_only=True)
    springs: tuple[Spring, ...] = field(default=(), kw_only=True)
    dampers: tuple[Damper, ...] = field(default=(), kw_only=True)

    @cached_property
    def dof_offset(self) -> Indices:
        """First unknown of each node, shape (node + 1,); the last entry is the number of unknowns."""
        per_node = np.full(len(self.nodes), 3)
        for group in self.groups:
            if group.section.rotational:
                per_node[group.connectivity] = 6
        joined = {node for link in self.links for node in link.joined}
        per_node[[node for link in self.links for node in link.turning]] = 6
        per_node[[body.node for body in self.masses if body.turns and body.node in joined]] = 6
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
    def constraints(self) -> Constraints:
        """What the links make follow."""
        return constraints_of(self.links, Joined(self.nodes, self.groups, self.dof_offset), self.fixed_dofs)

    @cached_property
    def expansion(self) -> csr_array:
        """All unknowns from the free ones, shape (dof, size)."""
        result = csr_array(self.constraints.matrix[:-1][:, self.free_dofs])
        result.sort_indices()
        return result

    @cached_property
    def element_groups(self) -> tuple[ElementGroup, ...]:
        """`groups`, cut where elements at linked nodes begin and end, so that others stay as slim as they are."""
        if not self.links:
            return self.groups
        return tuple(part for group in self.groups for part in self._cut(group))

    def _cut(self, group: ElementGroup) -> Iterator[ElementGroup]:
        linked = np.flatnonzero(self.constraints.follows[self.element_dofs(group)].any(axis=1))
        ends = np.flatnonzero(np.diff(linked) > _GAP)
        cuts = np.stack([linked[np.append(0, ends + 1)], linked[np.append(ends, -1)] + 1]) if linked.size else linked
        places = np.unique(np.concatenate([[0], cuts.T.ravel(), [len(group.connectivity)]])).astype(int)
        for first, last in pairwise(places.tolist()):
            yield group.part(first, last)

    @cached_property
    def _idle_dofs(self) -> Indices:
        """Rotations that move nothing, as that of two linked nodes about their line: they may as well be held."""
        felt = np.zeros(self.dof_count, dtype=bool)
        for group in self.groups:
            felt[self.element_dofs(group)] = True
        ends = [(body.node, body.turns) for body in self.masses]
        ends += [(node, joint.turns) for joint in (*self.springs, *self.dampers) for node in joint.joined]
        for node, turns in ends:
            felt[np.arange(*self.dof_offset[node : node + 2])[: 6 if turns else 3]] = True
        alone = ~felt
        alone[self.constraints.dependent] = alone[self.fixed_dofs] = False
        seen, found = self.constraints.matrix[:-1][felt].tocsc(), list[int]()
        for first in self.dof_offset[:-1][np.diff(self.dof_offset) == 6]:
            own = first + np.arange(3, 6)
            own = own[alone[own]]
            if own.size:
                moved = seen[:, own]
                rows = moved[np.unique(moved.indices)].toarray()
                triangle, order = qr(rows, mode="r", pivoting=True) if len(rows) else (rows, np.arange(own.size))
                sizes = np.abs(np.diag(triangle[:, : own.size]))
                rank = int(np.sum(sizes > _ROUND_OFF * sizes.max(initial=0.0)))
                found += own[order[rank:]].tolist()
        return np.array(sorted(found), dtype=np.int64)

    @cached_property
    def free_dofs(self) -> Indices:
        """Unknowns that can move and follow no other, sorted."""
        bound = self.fixed_dofs
        if self.links:
            bound = np.concatenate([bound, self.constraints.dependent, self._idle_dofs])
        return np.setdiff1d(np.arange(self.dof_count), bound)

    @cached_property
    def free_places(self) -> Indices:
        """Place of every unknown in `free_dofs`, and of one that does not exist behind them, shape (dof + 1,).

        Their number where it is held or follows others.
        """
        places = np.full(self.dof_count + 1, len(self.free_dofs), dtype=np.int64)
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
        """Number of independent rigid motions that supports, links and springs leave free."""
        return self.freedom_of(np.full(len(self.nodes), True))

    def freedom_of(self, nodes: Mask, *, supports_alone: bool = False) -> int:
        """The same of a piece of the structure, given as a flag for each node, shape (node,), or of supports alone."""
        motions = self.rigid_motions / max(1.0, float(np.abs(self.nodes).max()))
        own = np.repeat(nodes, np.diff(self.dof_offset))
        held = motions[self.fixed_dofs[own[self.fixed_dofs]]]
        if self.links and not supports_alone:
            misfit = self.constraints.misfit(motions)
            held = np.concatenate([held, misfit[own[self.constraints.dependent]]])
        for spring in self.springs:  # one to the frame is a support
            if nodes[spring.nodes[0]] and not (supports_alone and len(spring.nodes) == 2):
                held = np.concatenate([held, self._strained(spring, motions)])
        rank = int(np.linalg.matrix_rank(held, tol=1e-9)) if held.size else 0
        return int(np.linalg.matrix_rank(motions[own], tol=1e-9)) - rank

    def _strained(self, spring: Spring, motions: Array) -> Array:
        """What rigid motions (dof, 6) do to a spring along its axes, shape (stiffness, 6)."""
        moved = np.zeros((6, 6))
        for node, sign in zip(spring.nodes, (1.0, -1.0), strict=False):
            own = motions[self.dof_offset[node] : self.dof_offset[node + 1]]
            moved[: len(own)] += sign * own
        if spring.place is not None:  # rigid arms
            moved[:3] = 0.0
        axes = spring.axes_at(self.nodes)
        return np.concatenate([axes @ moved[:3], axes @ moved[3:]])[spring.stiffnesses > 0.0]
