"""Structured triangulations of a rectangle and checks on any triangulation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tautflex import checks
from tautflex.errors import MeshError

PATTERNS = ("alternating", "regular")


def rectangle_mesh(
    lines_x: NDArray[np.float64], lines_y: NDArray[np.float64], pattern: str = "alternating"
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Triangulate a rectangle in the plane z = 0 along given grid lines.

    Parameters
    ----------
    lines_x, lines_y
        Increasing grid-line coordinates [m], shapes (p,) and (q,), at least two each.
    pattern
        ``"regular"`` splits every cell by the same diagonal (mesh with central symmetry only);
        ``"alternating"`` flips the diagonal like a chess board (mirror symmetry for even divisions).

    Returns
    -------
    nodes
        Node positions [m], shape (p*q, 3); node i*q + j stands at (lines_x[i], lines_y[j], 0).
    triangles
        Node numbers, shape (2 (p-1) (q-1), 3), counter-clockwise.

    Raises
    ------
    InputError
        If the pattern is unknown.
    """
    checks.one_of("pattern", pattern, PATTERNS)
    count_x, count_y = len(lines_x), len(lines_y)
    x, y = np.meshgrid(lines_x, lines_y, indexing="ij")
    nodes = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    i, j = np.meshgrid(np.arange(count_x - 1), np.arange(count_y - 1), indexing="ij")
    lower_left = (i * count_y + j).ravel()
    lower_right, upper_left = lower_left + count_y, lower_left + 1
    upper_right = lower_right + 1
    rising = np.ones(lower_left.size, dtype=bool) if pattern == "regular" else ((i + j) % 2 == 0).ravel()
    first = np.where(
        rising[:, None],
        np.column_stack([lower_left, lower_right, upper_right]),
        np.column_stack([lower_left, lower_right, upper_left]),
    )
    second = np.where(
        rising[:, None],
        np.column_stack([lower_left, upper_right, upper_left]),
        np.column_stack([lower_right, upper_right, upper_left]),
    )
    return nodes, np.stack([first, second], axis=1).reshape(-1, 3)


def graded_lines(length: float, divisions: int, stations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Grid lines on [-length/2, length/2] that pass through every station, cells as equal as possible.

    Parameters
    ----------
    length
        Extent [m].
    divisions
        Number of cells, at least one per interval between stations.
    stations
        Increasing coordinates [m] that must be grid lines, from -length/2 to length/2.

    Returns
    -------
    numpy.ndarray
        Coordinates [m], shape (divisions + 1,).

    Raises
    ------
    MeshError
        If there are fewer divisions than intervals.
    """
    intervals = np.diff(stations)
    if divisions < len(intervals):
        raise MeshError(
            f"divisions: expected at least {len(intervals)} so that a mesh line meets each of the {len(stations)} "
            f"cables, got {divisions}; refine the mesh or use fewer cables"
        )
    cells = np.ones(len(intervals), dtype=int)
    for _ in range(divisions - len(intervals)):
        widest = intervals / cells
        # Ties go to the interval nearest the middle of the edge, mirrored, so that the mesh stays symmetric.
        candidates = np.flatnonzero(widest > widest.max() * (1.0 - 1e-9))
        cells[candidates[len(candidates) // 2]] += 1
    pieces = [np.linspace(a, b, n + 1)[:-1] for a, b, n in zip(stations[:-1], stations[1:], cells, strict=True)]
    lines = np.append(np.concatenate(pieces), stations[-1])
    lines[0], lines[-1] = -0.5 * length, 0.5 * length
    return lines


def check_triangles(nodes: NDArray[np.float64], triangles: NDArray[np.int64]) -> None:
    """Raise MeshError if a triangle has (almost) no area."""
    if not len(triangles):
        return
    corner = nodes[triangles]
    edges = corner - np.roll(corner, 1, axis=1)
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    longest = np.linalg.norm(edges, axis=2).max(axis=1)
    bad = np.flatnonzero(area <= 1e-10 * longest**2)
    if bad.size:
        raise MeshError(
            f"triangles: element {int(bad[0])} (nodes {triangles[bad[0]].tolist()}) is degenerate, area "
            f"{area[bad[0]]:.3g} m2 ({bad.size} such element(s)); remove it or merge its duplicate nodes"
        )


def check_lines(name: str, nodes: NDArray[np.float64], lines: NDArray[np.int64]) -> None:
    """Raise MeshError if a two-node element has no length."""
    if not len(lines):
        return
    length = np.linalg.norm(nodes[lines[:, 1]] - nodes[lines[:, 0]], axis=1)
    bad = np.flatnonzero(length <= 1e-10 * max(float(np.ptp(nodes, axis=0).max()), 1e-300))
    if bad.size:
        raise MeshError(
            f"{name}: element {int(bad[0])} (nodes {lines[bad[0]].tolist()}) has length {length[bad[0]]:.3g} m; "
            "remove it or separate its nodes"
        )


def check_connected(node_count: int, connectivities: list[NDArray[np.int64]]) -> None:
    """Raise MeshError if a node belongs to no element or the elements form more than one piece."""
    pairs = [np.stack([c[:, 0], c[:, k]]) for c in connectivities for k in range(1, c.shape[1]) if len(c)]
    if not pairs:
        raise MeshError("mesh: expected at least one element, got none; give triangles, cables or beams")
    rows, columns = np.concatenate(pairs, axis=1)
    used = np.zeros(node_count, dtype=bool)
    used[rows] = used[columns] = True
    if not used.all():
        loose = np.flatnonzero(~used)
        raise MeshError(
            f"nodes: node {int(loose[0])} belongs to no element ({loose.size} such node(s)); "
            "remove unused nodes or connect them"
        )
    graph = coo_array((np.ones(rows.size), (rows, columns)), shape=(node_count, node_count))
    pieces, label = connected_components(graph, directed=False)
    if pieces > 1:
        sizes = np.bincount(label)
        smallest = int(np.argmin(sizes))
        raise MeshError(
            f"mesh: expected one connected structure, got {pieces} pieces (the smallest has {sizes[smallest]} "
            f"node(s), e.g. node {int(np.flatnonzero(label == smallest)[0])}); merge duplicate nodes or join "
            "the pieces with cables or beams"
        )
