"""Elements of a file, of any order, as those that a structure has: nothing of the surface or line is left out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import CORNERS, KINDS, RawGroup, RawMass, RawMesh
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array, Indices

WIDTHS = {"line2": 2, "line3": 3, "triangle3": 3, "triangle6": 6, "quad4": 4, "quad8": 8, "quad9": 9}
"""Number of nodes of the shapes that files hold: corners, nodes in the middle of the sides, centre."""
KIND_OF = {shape: {"l": "lines", "t": "triangles", "q": "quads"}[shape[0]] for shape in WIDTHS}
KIND_OF |= {"quad8": "triangles", "quad9": "triangles"}
# Two six-node triangles on either side of a diagonal, from corners, sides and centre of a quadrilateral.
_HALVES = np.array([[[0, 1, 2, 4, 5, 8], [0, 2, 3, 8, 6, 7]], [[0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 6, 8]]])


def simplified(
    nodes: Array,
    elements: Mapping[str, Indices],
    roles: Mapping[str, NDArray[np.str_]],
    orientation: Array,
    groups: Iterable[RawGroup],
    typed: bool,
    masses: Iterable[RawMass] = (),
    links: Iterable[RawLink] = (),
    stress: Mapping[str, Array] | None = None,
    strain: Mapping[str, Array] | None = None,
) -> RawMesh:
    """Mesh of triangles, quads and lines from the shapes of `WIDTHS`.

    A line with a node in its middle becomes two. A quadrilateral of 8 or 9 nodes becomes two six-node triangles that
    share its shorter diagonal; the centre of one of 8 nodes is where its own interpolation has it, at half the sum of
    the nodes on its sides less a quarter of the sum of its corners.

    Parameters
    ----------
    nodes
        Positions, shape (node, 3).
    elements
        Rows of ``nodes`` by shape, shapes (element, width).
    roles
        What the file says each element is, by shape, shapes (element,).
    orientation
        Direction of the local z axis of each ``"line2"``, then each ``"line3"``; nan if not stated, shape (line, 3).
    groups
        Selections, their rows by shape.
    typed
        Whether the format's element types decide about roles.
    masses
        Rigid bodies at nodes.
    links
        Links and springs between nodes.
    stress
        Initial stress (sx, sy, txy) of elements by shape, shapes (element, 3); along lines the first.
    strain
        Strain of free elements by shape, shapes (element,).

    Raises
    ------
    MeshError
        If there are triangles of three nodes beside curved elements.
    """
    pieces: dict[str, Indices] = {}
    for shape, connectivity in elements.items():
        if shape in ("quad8", "quad9"):
            nodes, pieces[shape] = _halved(nodes, connectivity)
        else:
            pieces[shape] = connectivity[:, [[0, 2], [2, 1]]] if shape == "line3" else connectivity[:, None]
    found: dict[str, Indices] = {}
    role: dict[str, NDArray[np.str_]] = {}
    first: dict[str, int] = {}
    stressed: dict[str, Array] = {}
    strained: dict[str, Array] = {}
    for kind in KINDS:
        own = [shape for shape in WIDTHS if KIND_OF[shape] == kind and len(pieces.get(shape, ()))]
        widths = {pieces[shape].shape[2] for shape in own} or {CORNERS[kind]}
        if len(widths) > 1:
            listed = " and ".join(f"{len(elements[shape])} of {WIDTHS[shape]} nodes" for shape in own)
            raise MeshError(
                f"expected film of one order, got elements {listed}; mesh the whole film with the same order"
            )
        count = 0
        for shape in own:
            first[shape] = count
            count += pieces[shape].shape[0] * pieces[shape].shape[1]
        width = widths.pop()
        found[kind] = np.concatenate([np.zeros((0, width), np.int64), *(pieces[s].reshape(-1, width) for s in own)])
        for values, spread, each in ((stress, stressed, (3,)), (strain, strained, ())):
            given = [(values or {}).get(s, np.zeros((len(elements[s]), *each))) for s in own]
            parts = [np.repeat(one, pieces[s].shape[1], 0) for one, s in zip(given, own, strict=True)]
            spread[kind] = np.concatenate([np.zeros((0, *each)), *parts])
        role[kind] = np.concatenate([np.zeros(0, "<U8"), *(np.repeat(roles[s], pieces[s].shape[1]) for s in own)])
    split = [
        np.repeat(part, 2 if k else 1, axis=0)
        for k, part in enumerate(np.split(orientation, [len(elements.get("line2", ()))]))
    ]
    moved = []
    for group in groups:
        rows = {"nodes": [group.of("nodes")]}
        for shape, start in first.items():
            per = pieces[shape].shape[1]
            rows.setdefault(KIND_OF[shape], []).append(
                (start + per * group.of(shape)[:, None] + np.arange(per)).ravel()
            )
        moved.append(replace(group, rows={kind: np.concatenate(parts) for kind, parts in rows.items()}))
    split_orientation = np.concatenate(split)
    return RawMesh(
        nodes, found, role, split_orientation, tuple(moved), typed, tuple(masses), tuple(links), stressed, strained
    )


def _halved(nodes: Array, quads: Indices) -> tuple[Array, Indices]:
    """Nodes and two six-node triangles of each quadrilateral, shape (quad, 2, 6)."""
    if quads.shape[1] == 8:
        corner = nodes[quads]
        centre = 0.5 * corner[:, 4:].sum(axis=1) - 0.25 * corner[:, :4].sum(axis=1)
        quads = np.column_stack([quads, len(nodes) + np.arange(len(quads))])
        nodes = np.concatenate([nodes, centre])
    diagonals = np.linalg.norm(nodes[quads[:, [0, 1]]] - nodes[quads[:, [2, 3]]], axis=2)
    halves = _HALVES[diagonals.argmin(axis=1)]
    return nodes, np.take_along_axis(quads, halves.reshape(-1, 12), axis=1).reshape(-1, 2, 6)
