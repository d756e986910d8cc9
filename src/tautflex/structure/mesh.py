"""Structured meshes of a rectangle and checks on any mesh."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tautflex import checks
from tautflex.errors import MeshError
from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.shapes import QUAD4, TRIANGLE3, Shape

PATTERNS = ("alternating", "regular")


def rectangle_mesh(
    lines_x: Array,
    lines_y: Array,
    pattern: str = "alternating",
    shape: Shape = TRIANGLE3,
) -> tuple[Array, Indices]:
    """Cover a rectangle in the plane z = 0 with surface elements between given grid lines.

    Parameters
    ----------
    lines_x, lines_y
        Increasing grid-line coordinates [m], shapes (p,) and (q,), at least two each.
    pattern
        Of triangles, quads have none: ``"regular"`` splits every cell by the same diagonal (mesh with central
        symmetry only); ``"alternating"`` flips the diagonal like a chess board (mirror symmetry for even divisions).
    shape
        Shape of the elements; one fills a cell if it has four corners, two if it has three.

    Returns
    -------
    nodes
        Node positions [m], shape (node, 3), by x, then by y; of shapes without nodes beside their corners node
        i*q + j stands at (lines_x[i], lines_y[j], 0).
    elements
        Node numbers, shape (element, node), counter-clockwise.

    Raises
    ------
    InputError
        If the pattern is unknown.
    """
    checks.one_of("pattern", pattern, PATTERNS)
    count_x, count_y = len(lines_x), len(lines_y)
    x, y = np.meshgrid(lines_x, lines_y, indexing="ij")
    nodes = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    i, j = (index.ravel() for index in np.indices((count_x - 1, count_y - 1)))
    cells = (i * count_y + j)[:, None] + np.array([0, count_y, count_y + 1, 1])
    if shape.domain == "triangle":
        rising = np.full(i.size, True) if pattern == "regular" else (i + j) % 2 == 0
        halves = np.where(rising[:, None], [0, 1, 2, 0, 2, 3], [0, 1, 3, 1, 2, 3])
        cells = np.take_along_axis(cells, halves, axis=1).reshape(-1, 3)
    return _with_inner_nodes(nodes, cells, shape, count_y)


def _with_inner_nodes(nodes: Array, corners: Indices, shape: Shape, count_y: int) -> tuple[Array, Indices]:
    """Nodes and elements of a grid with everything that the shape has beside its corners."""
    if len(shape.nodes) == shape.corners:
        return nodes, corners
    weights = (QUAD4 if shape.domain == "quad" else TRIANGLE3).functions(shape.nodes)
    # Nodes that several elements share are told by their place in the grid, in millionths of a cell.
    place = np.stack(np.divmod(corners, count_y), axis=2)
    keys = np.rint(1e6 * np.einsum("ic,nck->nik", weights, place)).astype(np.int64).reshape(-1, 2)
    _, first, numbers = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    positions = np.einsum("ic,nck->nik", weights, nodes[corners]).reshape(-1, 3)
    return positions[first], numbers.reshape(len(corners), -1).astype(np.int64)


def graded_lines(length: float, divisions: int, stations: Array, shape: Shape = TRIANGLE3) -> Array:
    """Grid lines [m] on [-length/2, length/2], shape (divisions + 1,), that meet every station evenly.

    ``stations`` are increasing coordinates [m], from one end to the other, that must be nodes. At least one cell is
    needed per interval between them; one per two intervals where evenly spaced stations can take turns between the ends
    and the middles of the sides of a shape that has nodes there. MeshError if ``divisions`` are fewer.
    """
    least = shape.least_divisions(len(stations) - 1)
    if divisions < least:
        raise MeshError(
            f"divisions: expected at least {least} so that a mesh node meets each of the {len(stations)} "
            f"cables, got {divisions}; refine the mesh or use fewer cables"
        )
    if divisions < len(stations) - 1:
        stations = stations[::2]
    intervals = np.diff(stations)
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


def check_elements(name: str, shape: Shape, nodes: Array, connectivity: Indices) -> None:
    """Raise MeshError if an element (element, node) has almost no length or area, or is folded over."""
    if not len(connectivity):
        return
    corner = nodes[connectivity]
    measure = shape.measure(corner)
    if shape.dimension == 1:
        bad = np.flatnonzero(measure <= 1e-10 * max(float(np.ptp(nodes, axis=0).max()), 1e-300))
        wrong, remedy = "has length {0:.3g} m", "remove it or separate its nodes"
    else:
        ends = corner[:, : shape.corners]
        longest = np.linalg.norm(ends - np.roll(ends, 1, axis=1), axis=2).max(axis=1)
        bad = np.flatnonzero(measure <= 1e-10 * longest**2)
        wrong, remedy = "is degenerate, area {0:.3g} m2 ({1} such element(s))", "remove it or merge its duplicate nodes"
        if not bad.size and len(shape.nodes) > 3:
            bad = np.flatnonzero(_folded(shape, corner))
            wrong, remedy = (
                "is folded over ({1} such element(s))",
                "list its nodes around it, move mid-side nodes inwards",
            )
    if bad.size:
        first = int(bad[0])
        wrong = wrong.format(measure[first], bad.size)
        raise MeshError(f"{name}: element {first} (nodes {connectivity[first].tolist()}) {wrong}; {remedy}")


def _folded(shape: Shape, corner: Array) -> Mask:
    """Whether the normal turns against its mean at a node, shape (element,)."""
    along = shape.tangents(corner, shape.nodes)
    normal = np.cross(along[:, :, 0], along[:, :, 1])
    mean = normal.mean(axis=1)
    against = np.einsum("npk,nk->np", normal, mean).min(axis=1)
    # Corners without an area are fine; halves that cancel each other are not.
    largest = np.sum(normal**2, axis=2).max(axis=1)
    return np.asarray((against < -1e-9 * largest) | (np.sum(mean**2, axis=1) < 1e-9 * largest))


def check_joints(groups: list[tuple[Shape, Indices]]) -> None:
    """Raise MeshError where two elements of surfaces (element, node) share an edge but not the nodes inside it."""
    edges = [connectivity[:, edge] for shape, connectivity in groups for edge in shape.edges]
    if all(edge.shape[1] == 2 for edge in edges):
        return
    # Of each edge: its ends in order, and what lies between them as one number.
    ends = np.sort(np.concatenate([edge[:, [0, -1]] for edge in edges]), axis=1)
    between = np.concatenate(
        [edge[:, 1:-1].sum(axis=1) if edge.shape[1] > 2 else -np.ones(len(edge)) for edge in edges]
    )
    order = np.lexsort((between, ends[:, 1], ends[:, 0]))
    ends, between = ends[order], between[order]
    torn = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1) & (between[1:] != between[:-1]))
    if torn.size:
        a, b = (int(node) for node in ends[torn[0]])
        raise MeshError(
            f"mesh: two elements share the edge between nodes {a} and {b} but not the nodes between them "
            f"({torn.size} such edge(s)); join elements of the same order, and merge duplicate mid-side nodes"
        )


def blend_by_direction(nodes: Array, lines: Indices, along_x: float, across: float) -> Array:
    """Value of each line (line, 2) between that of lines along x and that of lines across, by the squared cosine."""
    along = (nodes[lines[:, 1]] - nodes[lines[:, 0]]) ** 2
    weight = along[:, 0] / along.sum(axis=1)
    return along_x * weight + across * (1.0 - weight)


def connected_pieces(node_count: int, connectivities: list[Indices], linked: Indices | None = None) -> Indices:
    """Number of the connected piece that each node belongs to, shape (node,); MeshError if it belongs to none.

    ``linked`` are pairs of nodes that links join, shape (pair, 2).
    """
    pairs = [np.stack([c[:, 0], c[:, k]]) for c in connectivities for k in range(1, c.shape[1]) if len(c)]
    if not pairs:
        raise MeshError("mesh: expected at least one element, got none; give triangles, cables or beams")
    rows, columns = np.concatenate(pairs if linked is None else [*pairs, linked.T], axis=1)
    used = np.zeros(node_count, dtype=bool)
    used[rows] = used[columns] = True
    if not used.all():
        loose = np.flatnonzero(~used)
        raise MeshError(
            f"nodes: node {int(loose[0])} belongs to no element ({loose.size} such node(s)); "
            "remove unused nodes or connect them"
        )
    return linked_pieces(node_count, np.stack([rows, columns], axis=1))


def linked_pieces(node_count: int, pairs: Indices) -> Indices:
    """Number of the piece that each node belongs to, shape (node,), of those that pairs (pair, 2) join."""
    graph = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(node_count, node_count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
