"""Links as one map: what follows is eliminated, so that no solver knows of it [theory.md 16].

Displacements that follow are sums of independent ones, ``q = T q_independent``, with a sparse constant T. Elements,
loads and readings see T instead of q; links among links are followed through to what leads them. Arms that rotations
swing add their second order, ``theta x (theta x d)/2``, to the strains and inertial forces of elements alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, diags_array

from tautflex.errors import MeshError
from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Arm, Follows, Joined, Link, Place


@dataclass(frozen=True)
class Constraints:
    """What follows what.

    Parameters
    ----------
    dependent
        Unknowns that follow others, sorted.
    matrix
        All unknowns, and one that does not exist behind them, from the independent ones among them, shape (dof + 1, dof
        + 1): rows and columns of 1 where one is its own, no columns of those that follow.
    arms
        Vectors d of arms [m], shape (arm, 3).
    turns
        Unknowns theta that swing them, shape (arm, 3).
    swing
        Shares of all unknowns in the components of ``theta x (theta x d)/2``, shape (dof + 1, 3 arms).
    """

    dependent: Indices
    matrix: csr_array
    arms: Array
    turns: Indices
    swing: csr_array

    @cached_property
    def follows(self) -> Mask:
        """Whether each unknown follows others, shape (dof + 1,)."""
        found = np.zeros(self.matrix.shape[0], dtype=bool)
        found[self.dependent] = True
        return found

    def misfit(self, motions: Array) -> Array:
        """What motions (dof, n) that ignore the links leave of each displacement that follows, (dependent, n)."""
        return np.asarray(motions[self.dependent] - self.matrix[self.dependent, :-1] @ motions)

    def by_element(self, dofs: Indices) -> tuple[Indices, Array]:
        """Independent unknowns behind those of elements (element, dof), and weights (element, dof, own).

        Unknowns that lead come in the order of those that they stand for; rows that have fewer than others end with the
        unknown that does not exist.
        """
        count, width = dofs.shape
        rows = self.matrix[dofs.ravel()].tocoo()
        order = np.lexsort((rows.col, rows.row))
        local, column, value = rows.row[order], rows.col[order].astype(np.int64), rows.data[order]
        element = local // width
        keys, first, which = np.unique(element * self.matrix.shape[0] + column, return_index=True, return_inverse=True)
        owner = keys // self.matrix.shape[0]
        # Place of every pair of element and unknown among those of its element, in the order of their first use.
        order = np.lexsort((first, owner))
        starts = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])
        place = np.empty(len(keys), dtype=np.int64)
        place[order] = np.arange(len(keys)) - starts[owner[order]]
        own = np.full((count, int(place.max(initial=-1)) + 1), self.matrix.shape[0] - 1)
        own[owner, place] = keys % self.matrix.shape[0]
        weights = np.zeros((count, width, own.shape[1]))
        weights[element, local % width, place[which]] = value
        return own, weights

    def bends(self, dofs: Indices) -> tuple[Indices, Array]:
        """Second order of the unknowns of elements (element, dof): ``1/2 sum_r theta_r' B_r theta_r``.

        Unknowns theta of the nodes that swing their arms, shape (element, r, 3), the one that does not exist where
        there are fewer, and B, shape (element, dof, r, 3, 3).
        """
        count, width = dofs.shape
        found = self.swing[dofs.ravel()].tocoo()
        arm, axis = np.divmod(found.col, 3)
        element = found.row // width
        keys, which = np.unique(element * self.matrix.shape[0] + self.turns[arm, 0], return_inverse=True)
        owner, leads = np.divmod(keys, self.matrix.shape[0])
        place = np.arange(len(keys)) - np.searchsorted(owner, owner)
        most = int(place.max(initial=-1)) + 1
        turns = np.full((count, most, 3), self.matrix.shape[0] - 1)
        turns[owner, place] = leads[:, None] + np.arange(3)
        # Component c of theta (theta.d) - d theta^2 as a quadratic form.
        vector, unit = self.arms[arm], np.eye(3)[axis]
        forms = 0.5 * (unit[:, :, None] * vector[:, None] + vector[:, :, None] * unit[:, None])
        forms -= vector[np.arange(len(axis)), axis][:, None, None] * np.eye(3)
        bends = np.zeros((count, width, most, 3, 3))
        np.add.at(bends, (element, found.row % width, place[which]), found.data[:, None, None] * forms)
        return turns, bends


def constraints_of(links: Sequence[Link], structure: Joined, held: Indices) -> Constraints:
    """Follow links through; ``held`` are the unknowns that supports hold.

    Raises
    ------
    MeshError
        If a displacement follows two links or itself, is held, or does not exist.
    """
    offset, owner = structure.dof_offset, dict[int, int]()
    size, bound = int(offset[-1]) + 1, set(held.tolist())
    rows, columns, values = list[int](), list[int](), list[float]()
    swung, arms = list[tuple[int, int]](), dict[Arm, int]()

    def unknown(place: Place) -> int:
        node, direction = place
        found = int(offset[node]) + direction
        if found >= offset[node + 1]:
            raise MeshError(
                f"links[{number}]: expected a node with rotations for {DIRECTIONS[direction]}, got node {node}, which "
                "no beam or rigid link turns; leave the direction out"
            )
        return found

    for number, link in enumerate(links):
        try:
            found = [Follows(*each) for each in link.follows(structure)]
        except MeshError as error:
            raise MeshError(f"links[{number}]: {error}") from None
        for (node, direction), others, arm in found:
            one = unknown((node, direction))
            if one in owner:
                raise MeshError(
                    f"links[{number}]: expected {DIRECTIONS[direction]} of node {node} to follow one link, got a "
                    f"second one beside links[{owner[one]}]; leave it out of one of them"
                )
            leads = [unknown(place) for place, _ in others]
            if one in bound and bound.issuperset(leads):
                continue  # held with what leads it
            owner[one] = number
            rows += [one] * len(leads)
            columns += leads
            values += [weight for _, weight in others]
            if arm is not None:
                swung.append((one, 3 * arms.setdefault(arm, len(arms)) + direction))
    both = np.intersect1d(held, list(owner))
    if both.size:
        node = int(np.searchsorted(offset, both[0], side="right")) - 1
        raise MeshError(
            f"links[{owner[int(both[0])]}]: expected {DIRECTIONS[both[0] - offset[node]]} of node {node} to follow the "
            "link alone, got it held by a support too; hold the node that leads, or leave the direction out"
        )
    dependent = np.array(sorted(owner), dtype=np.int64)
    alone = np.ones(size)
    alone[dependent] = 0.0
    step = csr_array((values, (rows, columns)), shape=(size, size))
    through = csr_array(diags_array(alone) + step)
    direct = step
    follows = np.flatnonzero(alone == 0.0)
    for _ in range(len(links) + 1):
        if not np.any(np.isin(step.indices, follows)):
            break
        step = csr_array(step @ through)
        step.eliminate_zeros()
    else:
        around = step.indices[np.isin(step.indices, follows)][0]
        node = int(np.searchsorted(offset, around, side="right")) - 1
        raise MeshError(
            f"links[{owner[int(around)]}]: expected links that lead to nodes of their own, got node {node} following "
            "itself through others; turn one of them round"
        )
    matrix = csr_array(diags_array(alone) + step)
    matrix.sort_indices()
    more = csr_array((np.ones(len(swung)), np.reshape(swung, (-1, 2)).T.astype(int)), shape=(size, 3 * len(arms)))
    swing = more
    while more.nnz:  # what follows swings with what leads it
        more = csr_array(direct @ more)
        swing = csr_array(swing + more)
    turns = offset[[arm.node for arm in arms]][:, None] + np.arange(3, 6)
    return Constraints(dependent, matrix, np.reshape([arm.vector for arm in arms], (-1, 3)), turns, swing)
