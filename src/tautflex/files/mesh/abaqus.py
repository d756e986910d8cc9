"""Abaqus input files: nodes, membrane, truss and beam elements, sets, boundary conditions.

Read are ``*NODE``, ``*ELEMENT`` (S3, S3R, STRI3, M3D3: membrane; T3D2: cable; B31, B33: beam), ``*NSET``, ``*ELSET``
(also GENERATE) and ``*BOUNDARY``. Sections, materials and steps are left to the user of the mesh. A mesh spread over
several parts, moved instances and included files are refused: export a flat file instead. Own, because meshio (5.3.5)
reads no boundary conditions, and its own tests fail since NumPy 2.2.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus_sets import NamedSets, element_groups, held_groups, node_groups
from tautflex.files.mesh.abaqus_text import Block, blocks, fields
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Budget, Numbering, RawMesh, integer_array, require_coordinates, shorten

TYPES = {
    **dict.fromkeys(("M3D3", "S3", "S3R", "S3RS", "STRI3"), "membrane"),
    **dict.fromkeys(("T3D2", "T3D2H"), "cable"),
    **dict.fromkeys(("B31", "B31H", "B33", "B33H"), "beam"),
}


def read_abaqus(text: str) -> RawMesh:
    """Read the mesh of an Abaqus input file; MeshError if a line is wrong, or uses what is not read here."""
    content = _Content()
    for block in blocks(text):
        reader = _READERS.get(block.keyword)
        if reader is not None:
            reader(content, block)
    return content.finish()


@dataclass
class _Content:
    """What the blocks read so far have brought."""

    node_numbers: list[int] = field(default_factory=list)
    positions: list[tuple[float, float, float]] = field(default_factory=list)
    elements: dict[str, list[tuple[int, ...]]] = field(default_factory=lambda: {"triangles": [], "lines": []})
    line_roles: list[str] = field(default_factory=list)
    node_sets: NamedSets = field(default_factory=lambda: NamedSets("NSET"))
    element_sets: NamedSets = field(default_factory=lambda: NamedSets("ELSET"))
    set_blocks: list[Block] = field(default_factory=list)
    conditions: list[Block] = field(default_factory=list)
    parts: int = 0

    def finish(self) -> RawMesh:
        numbers = np.array(self.node_numbers, dtype=np.int64)
        nodes = np.array(self.positions, dtype=float).reshape(-1, 3)
        require_coordinates(nodes, numbers)
        triangles = integer_array(self.elements["triangles"], 4)
        lines = integer_array(self.elements["lines"], 3)
        node_rows = Numbering("node", numbers)
        element_rows = Numbering("element", np.concatenate([triangles[:, 0], lines[:, 0]]))
        budget = Budget()
        for block in self.set_blocks:
            sets, rows = {"NSET": (self.node_sets, node_rows)}.get(block.keyword, (self.element_sets, element_rows))
            sets.read(block, rows, budget)
        groups = [
            *element_groups(self.element_sets, element_rows, len(triangles)),
            *node_groups(self.node_sets, node_rows),
            *held_groups(self.conditions, self.node_sets, node_rows, budget),
        ]
        return RawMesh(
            nodes,
            node_rows.rows(triangles[:, 1:], "triangles"),
            node_rows.rows(lines[:, 1:], "lines"),
            np.array(self.line_roles, dtype="<U8"),
            tuple(groups),
            typed=True,
        )


def _read_nodes(content: _Content, block: Block) -> None:
    for option in ("INPUT", "SYSTEM"):
        if option in block.options:
            raise MeshError(f"{block.where}: {option} is not read here; write all nodes into one file, in x, y, z")
    first = len(content.node_numbers)
    for where, line in block.lines:
        parts = fields(line)
        if not 2 <= len(parts) <= 7:
            raise MeshError(f"{where}: expected number, x, y, z, got {shorten(line)}; correct the line")
        content.node_numbers.append(natural(parts[0], where))
        x, y, z = (real(part, where) for part in [*parts[1:4], "", ""][:3])
        content.positions.append((x, y, z))
    if "NSET" in block.options:
        numbers = np.array(content.node_numbers[first:], dtype=np.int64)
        content.node_sets.add(block.options["NSET"], numbers)


def _read_elements(content: _Content, block: Block) -> None:
    kind = block.options.get("TYPE", "").upper()
    role = TYPES.get(kind)
    if role is None:
        raise MeshError(
            f"{block.where}: expected an element type of {', '.join(TYPES)}, got {shorten(kind)}; mesh the film with "
            "3-node triangles, cables with trusses, beams with 2-node beams"
        )
    if "INPUT" in block.options:
        raise MeshError(f"{block.where}: INPUT is not read here; write all elements into one file")
    corners = 3 if role == "membrane" else 2
    kept = content.elements["triangles" if role == "membrane" else "lines"]
    first = len(kept)
    for where, line in block.lines:
        parts = fields(line)
        if len(parts) != corners + 1:
            raise MeshError(f"{where}: expected number and {corners} nodes, got {shorten(line)}; correct the line")
        kept.append(tuple(natural(part, where) for part in parts))
        if role != "membrane":
            content.line_roles.append(role)
    numbers = np.array([element[0] for element in kept[first:]], dtype=np.int64)
    content.element_sets.add(block.options.get("ELSET") or kind, numbers)


def _keep_set(content: _Content, block: Block) -> None:
    content.set_blocks.append(block)


def _keep_condition(content: _Content, block: Block) -> None:
    content.conditions.append(block)


def _count_part(content: _Content, block: Block) -> None:
    content.parts += 1
    if content.parts > 1:
        raise MeshError(f"{block.where}: expected one part, got a second one; export a flat input file")


def _read_instance(content: _Content, block: Block) -> None:
    if block.lines:
        raise MeshError(f"{block.where}: a moved or rotated instance is not read here; export a flat input file")


def _refuse(content: _Content, block: Block) -> None:
    raise MeshError(f"{block.where}: expected one file with everything in global axes; export a flat input file")


_READERS = {
    "NODE": _read_nodes,
    "ELEMENT": _read_elements,
    "NSET": _keep_set,
    "ELSET": _keep_set,
    "BOUNDARY": _keep_condition,
    "PART": _count_part,
    "INSTANCE": _read_instance,
    "INCLUDE": _refuse,
    "SYSTEM": _refuse,
    "NGEN": _refuse,
    "ELGEN": _refuse,
    "NCOPY": _refuse,
    "ELCOPY": _refuse,
}
