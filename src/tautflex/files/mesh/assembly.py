"""From the groups of a file to the parts of a structure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import MeshError
from tautflex.files.mesh import roles
from tautflex.files.mesh.mesh_data import MeshData
from tautflex.files.mesh.raw import IntArray, RawGroup, RawMesh, shorten
from tautflex.structure.groups import DIRECTIONS, Support
from tautflex.structure.mesh import check_connected, check_elements
from tautflex.structure.shapes import LINE2, QUAD4, TRIANGLE3, TRIANGLE6

_CHOICES = {"triangles": ("membrane",), "quads": ("membrane",), "lines": ("cable", "beam")}


def assemble(raw: RawMesh, names: Mapping[str, str] | None = None, unit_length: float = 1.0) -> MeshData:
    """Give every element its role, leave out what has none, and number nodes anew.

    Parameters
    ----------
    raw
        Content of a file.
    names
        Roles that the user states, by group name; they come before the file's element types and names.
    unit_length
        Length of the file's unit [m].

    Raises
    ------
    MeshError
        If a group has no role, an element two, or what remains is no mesh.
    """
    stated = roles.stated_roles(names)
    roles.require_known(stated, [group.name for group in raw.groups])
    role = {kind: np.full(len(getattr(raw, kind)), "", dtype="<U8") for kind in _CHOICES}
    held: list[tuple[str, IntArray, tuple[str, ...]]] = []
    for group in raw.groups:
        found = _role(raw, group, stated)
        if found in roles.SUPPORTS:
            held.append((group.name, _nodes_of(raw, group), _directions(found, group, stated)))
        elif found is not None and found != "ignore":
            for kind in _CHOICES:
                _assign(role[kind], getattr(group, kind), found, kind, group.name)
    _fill(raw, role)
    for group in raw.groups:  # last, because left out is left out, whatever other groups say
        if _role(raw, group, stated) == "ignore":
            for kind in _CHOICES:
                role[kind][getattr(group, kind)] = "ignore"
    return _collect(raw, role, held, unit_length)


def _role(raw: RawMesh, group: RawGroup, stated: Mapping[str, str]) -> str | None:
    """Role of a group: what the user states, what the file holds, what the name says."""
    own = stated.get(group.name.strip().casefold())
    if own is not None:
        return own
    if group.directions:
        return "clamped"
    named = roles.role_of_name(group.name)
    has_elements = any(len(getattr(group, kind)) for kind in _CHOICES)
    if not has_elements or raw.typed:  # other node sets and, where types decide, element sets are mere selections
        return named if named in roles.SUPPORTS and (len(group.nodes) or has_elements) else None
    if named is None:
        raise roles.unknown_role(group.name)
    return named


def _directions(role: str, group: RawGroup, stated: Mapping[str, str]) -> tuple[str, ...]:
    if group.directions and group.name.strip().casefold() not in stated:
        return group.directions
    return DIRECTIONS if role == "clamped" else DIRECTIONS[:3]


def _nodes_of(raw: RawMesh, group: RawGroup) -> IntArray:
    parts = (getattr(raw, kind)[getattr(group, kind)].ravel() for kind in _CHOICES)
    return np.unique(np.concatenate([group.nodes, *parts]))


def _assign(role: NDArray[np.str_], rows: IntArray, new: str, kind: str, name: str) -> None:
    if not len(rows):
        return
    if new not in _CHOICES[kind]:
        choices = " or ".join(_CHOICES[kind])
        raise MeshError(f"group {shorten(name)}: expected {kind} to be {choices}, got {new}; rename the group")
    clash = (role[rows] != "") & (role[rows] != new)
    if clash.any():
        other = role[rows][clash][0]
        raise MeshError(
            f"group {shorten(name)}: {int(clash.sum())} of its {kind} are {new} here and {other} by another group; "
            "an element has one role, separate the groups"
        )
    role[rows] = new


def _fill(raw: RawMesh, role: dict[str, NDArray[np.str_]]) -> None:
    """Elements without a stated role get what their type says; a file without surfaces in groups is all film."""
    open_lines = role["lines"] == ""
    role["lines"][open_lines] = raw.line_roles[open_lines]
    if raw.typed or not any(len(group.triangles) + len(group.quads) for group in raw.groups):
        for kind in ("triangles", "quads"):
            role[kind][role[kind] == ""] = "membrane"


def _collect(
    raw: RawMesh,
    role: Mapping[str, NDArray[np.str_]],
    held: list[tuple[str, IntArray, tuple[str, ...]]],
    unit_length: float,
) -> MeshData:
    source = {"triangles": "triangles", "quads": "quads", "cables": "lines", "beams": "lines"}
    wanted = {"triangles": "membrane", "quads": "membrane", "cables": "cable", "beams": "beam"}
    chosen = {kind: np.flatnonzero(role[source[kind]] == wanted[kind]) for kind in source}
    elements = {kind: getattr(raw, source[kind])[rows] for kind, rows in chosen.items()}
    for kind, connectivity in elements.items():
        _refuse_copies(kind, connectivity)
    used = np.unique(np.concatenate([connectivity.ravel() for connectivity in elements.values()]))
    if not used.size:
        raise MeshError("mesh: expected triangles, cables or beams, got none; put the elements into named groups")
    new = {kind: _renumbering(rows, len(getattr(raw, source[kind]))) for kind, rows in chosen.items()}
    new["nodes"] = _renumbering(used, len(raw.nodes))
    parts = {kind: new["nodes"][connectivity] for kind, connectivity in elements.items()}
    nodes = raw.nodes[used] * unit_length
    triangle = TRIANGLE6 if parts["triangles"].shape[1] == 6 else TRIANGLE3
    for kind, shape in {"triangles": triangle, "quads": QUAD4, "cables": LINE2, "beams": LINE2}.items():
        check_elements(kind, shape, nodes, parts[kind])
    check_connected(len(nodes), list(parts.values()))
    supports = _supports([(name, new["nodes"][rows], directions) for name, rows, directions in held])
    return MeshData(nodes, **parts, supports=supports, groups=_selections(raw, new))


def _renumbering(rows: IntArray, count: int) -> IntArray:
    """New number of each old row, -1 where it is left out."""
    new = np.full(count, -1, dtype=np.int64)
    new[rows] = np.arange(len(rows))
    return new


def _refuse_copies(kind: str, connectivity: IntArray) -> None:
    ordered = np.sort(connectivity, axis=1)
    copies = len(ordered) - len(np.unique(ordered, axis=0))
    if copies:
        raise MeshError(f"{kind}: {copies} element(s) join the same nodes as another one; remove the copies")


def _supports(held: list[tuple[str, IntArray, tuple[str, ...]]]) -> tuple[Support, ...]:
    """One support for each set of directions, its nodes in order."""
    rows_of: dict[tuple[str, ...], list[IntArray]] = {}
    for name, rows, directions in held:
        there = rows[rows >= 0]
        if not there.size:
            raise MeshError(f"support {shorten(name)}: none of its nodes belongs to an element; correct the group")
        rows_of.setdefault(directions, []).append(there)
    return tuple(
        Support(tuple(np.unique(np.concatenate(parts)).tolist()), directions) for directions, parts in rows_of.items()
    )


def _selections(raw: RawMesh, new: Mapping[str, IntArray]) -> dict[str, dict[str, IntArray]]:
    """Rows that each name selects; groups of the same name count as one."""
    parts: dict[str, dict[str, list[IntArray]]] = {}
    for group in raw.groups:
        found = parts.setdefault(group.name, {})
        for kind, rows in (
            ("triangles", new["triangles"][group.triangles]),
            ("quads", new["quads"][group.quads]),
            ("cables", new["cables"][group.lines]),
            ("beams", new["beams"][group.lines]),
            ("nodes", new["nodes"][group.nodes]),
        ):
            kept = rows[rows >= 0]
            if kept.size:
                found.setdefault(kind, []).append(kept)
    return {
        name: {kind: np.unique(np.concatenate(rows)) for kind, rows in found.items()} for name, found in parts.items()
    }
