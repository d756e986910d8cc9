"""Abaqus input files: nodes, membrane, truss and beam elements, sets, boundary conditions.

Read are ``*NODE``, ``*ELEMENT`` (S3, S3R, STRI3, M3D3: membrane; T3D2: cable; B31, B33: beam), ``*NSET``, ``*ELSET``
(also GENERATE) and ``*BOUNDARY``. Sections, materials and steps are left to the user of the mesh. A mesh spread over
several parts, moved instances and included files are refused: export a flat file instead. Own, because meshio (5.3.5)
reads no boundary conditions, and its own tests fail since NumPy 2.2.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus_sets import NamedSets, element_groups, held_groups, node_groups
from tautflex.files.mesh.abaqus_text import Block, blocks, fields
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Budget, Gathered, RawMesh, integers, shorten

TYPES = {
    **dict.fromkeys(("M3D3", "S3", "S3R", "S3RS", "STRI3"), "membrane"),
    **dict.fromkeys(("T3D2", "T3D2H"), "cable"),
    **dict.fromkeys(("B31", "B31H", "B33", "B33H"), "beam"),
}


_REFUSED = ("INCLUDE", "SYSTEM", "NGEN", "ELGEN", "NCOPY", "ELCOPY")


def read_abaqus(text: str) -> RawMesh:
    """Read the mesh of an Abaqus input file; MeshError if a line is wrong, or uses what is not read here."""
    content = _Content()
    for block in blocks(text):
        content.read(block)
    return content.finish()


@dataclass
class _Content(Gathered):
    """What the blocks read so far have brought."""

    node_sets: NamedSets = field(default_factory=lambda: NamedSets("NSET"))
    element_sets: NamedSets = field(default_factory=lambda: NamedSets("ELSET"))
    set_blocks: list[Block] = field(default_factory=list)
    conditions: list[Block] = field(default_factory=list)
    parts: int = 0

    def read(self, block: Block) -> None:
        if block.keyword == "NODE":
            self._read_nodes(block)
        elif block.keyword == "ELEMENT":
            self._read_elements(block)
        elif block.keyword in ("NSET", "ELSET"):
            self.set_blocks.append(block)
        elif block.keyword == "BOUNDARY":
            self.conditions.append(block)
        elif block.keyword == "PART":
            self.parts += 1
            if self.parts > 1:
                raise MeshError(f"{block.where}: expected one part, got a second one; export a flat input file")
        elif block.keyword == "INSTANCE" and block.lines:
            raise MeshError(f"{block.where}: a moved or rotated instance is not read here; export a flat input file")
        elif block.keyword in _REFUSED:
            raise MeshError(
                f"{block.where}: expected one file with everything in global axes; export a flat input file"
            )

    def _read_nodes(self, block: Block) -> None:
        for option in ("INPUT", "SYSTEM"):
            if option in block.options:
                raise MeshError(f"{block.where}: {option} is not read here; write all nodes into one file, in x, y, z")
        first = len(self.node_numbers)
        for where, line in block.lines:
            parts = fields(line)
            if not 2 <= len(parts) <= 7:
                raise MeshError(f"{where}: expected number, x, y, z, got {shorten(line)}; correct the line")
            self.node_numbers.append(natural(parts[0], where))
            self.positions.append([real(part, where) for part in [*parts[1:4], "", ""][:3]])
        if "NSET" in block.options:
            self.node_sets.add(block.options["NSET"], integers(self.node_numbers[first:]))

    def _read_elements(self, block: Block) -> None:
        kind = block.options.get("TYPE", "").upper()
        role = TYPES.get(kind)
        if role is None:
            raise MeshError(
                f"{block.where}: expected an element type of {', '.join(TYPES)}, got {shorten(kind)}; mesh the film "
                "with 3-node triangles, cables with trusses, beams with 2-node beams"
            )
        if "INPUT" in block.options:
            raise MeshError(f"{block.where}: INPUT is not read here; write all elements into one file")
        corners, own = 3 if role == "membrane" else 2, []
        for where, line in block.lines:
            parts = fields(line)
            if len(parts) != corners + 1:
                raise MeshError(f"{where}: expected number and {corners} nodes, got {shorten(line)}; correct the line")
            numbers = [natural(part, where) for part in parts]
            self.add(role, numbers)
            own.append(numbers[0])
        self.element_sets.add(block.options.get("ELSET") or kind, integers(own))

    def finish(self) -> RawMesh:
        nodes, elements = self.numbered("node")
        budget = Budget()
        for block in self.set_blocks:
            sets, rows = (self.node_sets, nodes) if block.keyword == "NSET" else (self.element_sets, elements)
            sets.read(block, rows, budget)
        groups = [
            *element_groups(self.element_sets, elements, len(self.elements["triangles"])),
            *node_groups(self.node_sets, nodes),
            *held_groups(self.conditions, self.node_sets, nodes, budget),
        ]
        return self.mesh(nodes, groups, {})
