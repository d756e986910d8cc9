"""Which way film elements face: corner orders made to agree across the sides that elements share."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tautflex.errors import MeshError
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup

# Areas of a piece whose corner orders contradict each other count as equal within this part of them.
_EVEN = 1e-9


def facing(nodes: Array, surfaces: tuple[ElementGroup, ...]) -> Array:
    """Sign of each film element: 1 where its corner order shows the way that its piece of film faces, -1 elsewhere.

    Elements belong to one piece where they share a side that no third one has. It faces the way most of its area does;
    of two halves, the way its first element does.

    Parameters
    ----------
    nodes
        Positions [m], shape (node, 3).
    surfaces
        Groups of film elements, in order.

    Returns
    -------
    numpy.ndarray
        Shape (element,).

    Raises
    ------
    MeshError
        If a piece has one side only, as a Moebius strip has.
    """
    area = np.concatenate([group.shape.measure(nodes[group.connectivity]) for group in surfaces])
    count, (first, second, agree) = len(area), _neighbours(surfaces)
    # Every element is there as it is given (i) and turned over (count + i); what faces the same way hangs together.
    turned = np.where(agree, second, second + count), np.where(agree, second + count, second)
    links = np.concatenate([first, first + count]), np.concatenate(turned)
    graph = coo_array((np.ones(len(links[0])), links), shape=(2 * count, 2 * count))
    sides, side = connected_components(graph, directed=False)
    given, other = side[:count], side[count:]
    if np.any(given == other):
        torn = np.flatnonzero(given == other)
        raise MeshError(
            f"film: expected two sides, got a surface with one: film element {torn[0]} and {torn.size - 1} more hang "
            "together so that going around turns them over; cut the strip open"
        )
    weight = np.bincount(given, area, sides)
    lead = weight[given] - weight[other]
    even = np.abs(lead) <= _EVEN * (weight[given] + weight[other])
    return np.where(np.where(even, given < other, lead > 0.0), 1.0, -1.0)


def _neighbours(surfaces: tuple[ElementGroup, ...]) -> tuple[Indices, Indices, Indices]:
    """Pairs of elements with a side that no third one has, and whether their corner orders agree across it."""
    ends, owner, first = [], [], 0
    for group in surfaces:
        ends.append(group.shape.sides(group.connectivity))
        owner.append(first + np.repeat(np.arange(len(group.connectivity)), len(group.shape.edges)))
        first += len(group.connectivity)
    start, element = np.concatenate(ends), np.concatenate(owner)
    _, number, times = np.unique(np.sort(start, axis=1), axis=0, return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    shared = np.flatnonzero(times[number] == 2)
    a, b = shared[np.argsort(number[shared], kind="stable")].reshape(-1, 2).T
    # Neighbours that agree run along their common side in opposite directions.
    return element[a], element[b], start[a, 0] == start[b, 1]
