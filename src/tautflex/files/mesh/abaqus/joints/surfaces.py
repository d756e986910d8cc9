"""Surfaces of an Abaqus file: nodes and elements under a name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.sets import Names
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import real
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array, Indices

_WHOLE = ("", "SPOS", "SNEG")


@dataclass(frozen=True)
class Whole:
    """Positions of all nodes, and of each element the place of its shape in ``elements`` and its row there."""

    positions: Array
    shape: Indices
    row: Indices
    elements: Mapping[str, Indices]

    def of(self, found: Indices) -> Iterator[tuple[str, Indices]]:
        """Shapes of some elements, and the rows of their nodes."""
        for place, (name, rows) in enumerate(self.elements.items()):
            own = self.row[found[self.shape[found] == place]]
            if len(own):
                yield name, rows[own]


@dataclass
class Surface:
    """Rows of its nodes with their weights, and of its elements."""

    nodes: dict[int, float] = field(default_factory=dict)
    elements: list[Indices] = field(default_factory=list)


class Surfaces:
    """Surfaces of all scopes, by the name of the scope and their own, in lower case."""

    def __init__(self, whole: Whole) -> None:
        self._whole = whole
        self._found: dict[tuple[str, str], Surface] = {}

    def read(self, scope: str, block: Block, nodes: Names, elements: Names) -> None:
        """Keep a surface that lists nodes, or films by their sides and edges."""
        block.require_options("NAME", "TYPE", "INTERNAL")
        kind = block.option("TYPE").upper() or "ELEMENT"
        surface = Surface()
        for where, line in block.lines:
            target, *rest = fields(line) or [""]
            if kind == "NODE":
                weight = real(rest[0], where) if rest else 1.0
                surface.nodes |= dict.fromkeys(nodes.find(target, where).tolist(), weight)
            elif kind == "ELEMENT":
                found = elements.find(target, where)
                surface.elements.append(found)
                for name, rows in self._whole.of(found):
                    picked = _side(name, rows, "".join(rest).upper(), where)
                    surface.nodes |= dict.fromkeys(picked.ravel().tolist(), 1.0)
            else:
                raise MeshError(f"{block.where}: expected TYPE=NODE or ELEMENT, got {shorten(kind)}; list its nodes")
        key = scope.casefold(), block.option("NAME").casefold()
        if key in self._found:
            raise MeshError(f"{block.where}: expected a surface of a new name, got one there is; rename it")
        self._found[key] = surface

    def find(self, scope: str, name: str, where: str) -> Surface:
        """Surface of a scope, or ``instance.name``; MeshError if there is none."""
        bare = name.strip().strip('"').casefold()
        instance, _, rest = bare.partition(".")
        found = self._found.get((scope.casefold(), bare)) or self._found.get((instance, rest))
        if found is None:
            raise MeshError(f"{where}: expected a *SURFACE, got {shorten(name)}; define it, of TYPE=NODE or ELEMENT")
        return found


def _side(shape: str, rows: Indices, face: str, where: str) -> Indices:
    """Nodes of elements, or of one of their edges E1, E2, ... with a node in its middle if there is one."""
    if face in _WHOLE:
        return rows
    corners = 3 if shape.startswith("triangle") else 4
    edge = int(face[1]) - 1 if face in ("E1", "E2", "E3", "E4") else -1
    if shape[0] not in "tq" or not 0 <= edge < corners:
        raise MeshError(f"{where}: expected SPOS, SNEG or an edge E1 to E4 of film, got {shorten(face)}; list nodes")
    picked = [edge, (edge + 1) % corners, *([corners + edge] if rows.shape[1] >= 2 * corners else [])]
    return np.asarray(rows[:, picked])
