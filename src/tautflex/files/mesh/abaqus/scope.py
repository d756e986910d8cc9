"""Content of a part, of an instance, or of what stands outside: numbers and names that hold there only."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from tautflex.errors import MeshError
from tautflex.files.mesh.abaqus.joints.links import LINKS
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.gathered import SHAPES, Gathered
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import integers, shorten
from tautflex.numeric import Indices


class Layout(NamedTuple):
    """Shape and role of a type of element."""

    shape: str
    role: str


TYPES = {
    **dict.fromkeys(("M3D3",), Layout("triangle3", "membrane")),
    **dict.fromkeys(("M3D4", "M3D4R"), Layout("quad4", "membrane")),
    **dict.fromkeys(("M3D6",), Layout("triangle6", "membrane")),
    **dict.fromkeys(("M3D8", "M3D8R"), Layout("quad8", "membrane")),
    **dict.fromkeys(("M3D9", "M3D9R"), Layout("quad9", "membrane")),
    **dict.fromkeys(("S3", "S3R", "S3RS", "STRI3"), Layout("triangle3", "shell")),
    **dict.fromkeys(("S4", "S4R", "S4RS", "S4RSW", "S4R5"), Layout("quad4", "shell")),
    **dict.fromkeys(("S6", "STRI65"), Layout("triangle6", "shell")),
    **dict.fromkeys(("S8", "S8R", "S8R5"), Layout("quad8", "shell")),
    **dict.fromkeys(("T3D2", "T3D2H"), Layout("line2", "cable")),
    **dict.fromkeys(("B31", "B31H", "B33", "B33H"), Layout("line2", "beam")),
    "MASS": Layout("point1", "mass"),
    "ROTARYI": Layout("point1", "inertia"),
    "SPRINGA": Layout("spring2", "springa"),
    "SPRING2": Layout("spring2", "spring2"),
    "SPRING1": Layout("spring1", "spring1"),
    "DASHPOTA": Layout("spring2", "dashpota"),
    "DASHPOT2": Layout("spring2", "dashpot2"),
    "DASHPOT1": Layout("spring1", "dashpot1"),
}
_REFUSED = {
    "CONN": "connectors are not read here; join the nodes by stiff beams",
}


@dataclass
class Scope(Gathered):
    """Nodes, elements and sets as their blocks bring them."""

    name: str = ""
    node_parts: list[tuple[str, Indices]] = field(default_factory=list)
    element_parts: list[tuple[str, Indices]] = field(default_factory=list)
    sets: list[Block] = field(default_factory=list)
    sections: list[Block] = field(default_factory=list)
    transforms: list[Block] = field(default_factory=list)
    bodies: list[Block] = field(default_factory=list)
    nonstructural: list[Block] = field(default_factory=list)
    links: list[Block] = field(default_factory=list)
    surfaces: list[Block] = field(default_factory=list)
    ties: list[Block] = field(default_factory=list)
    releases: list[Block] = field(default_factory=list)
    springs: list[Block] = field(default_factory=list)

    def read(self, block: Block) -> None:
        """Read a block of nodes, elements, sets, beam sections, transformed directions, masses, links or springs."""
        if block.keyword == "NODE":
            self._read_nodes(block)
        elif block.keyword == "ELEMENT":
            self._read_elements(block)
        elif block.keyword in ("NSET", "ELSET"):
            self.sets.append(block)
        elif block.keyword == "TRANSFORM":
            self.transforms.append(block)
        elif block.keyword in ("MASS", "ROTARY INERTIA"):
            self.bodies.append(block)
        elif block.keyword == "NONSTRUCTURAL MASS":
            self.nonstructural.append(block)
        elif block.keyword in LINKS:
            self.links.append(block)
        elif block.keyword == "SURFACE":
            self.surfaces.append(block)
        elif block.keyword in ("TIE", "EMBEDDED ELEMENT"):
            self.ties.append(block)
        elif block.keyword == "RELEASE":
            self.releases.append(block)
        elif block.keyword in ("SPRING", "DASHPOT"):
            self.springs.append(block)
        else:
            self.sections.append(block)

    @property
    def has_mesh(self) -> bool:
        """Whether there is a node or an element."""
        return bool(self.node_numbers) or any(self.elements.values())

    def _read_nodes(self, block: Block) -> None:
        block.require_options("NSET")
        first = len(self.node_numbers)
        for where, line in block.lines:
            parts = fields(line)
            if not 2 <= len(parts) <= 4:
                raise MeshError(f"{where}: expected number, x, y, z, got {shorten(line)}; correct the line")
            self.node_numbers.append(natural(parts[0], where))
            self.positions.append([real(part, where) for part in [*parts[1:], "", ""][:3]])
        if block.option("NSET"):
            self.node_parts.append((block.option("NSET"), integers(self.node_numbers[first:])))

    def _read_elements(self, block: Block) -> None:
        block.require_options("TYPE", "ELSET")
        kind = block.option("TYPE").upper()
        layout = TYPES.get(kind)
        if layout is None:
            remedy = "mesh the film with M3D3 or M3D4, cables with trusses, beams with 2-node beams"
            wanted = f"expected an element type of {', '.join(TYPES)}, got {shorten(kind)}; {remedy}"
            known = next((text for word, text in _REFUSED.items() if kind.startswith(word)), wanted)
            raise MeshError(f"{block.where}: {known}")
        count, own, parts = SHAPES[layout.shape] + 1, list[int](), list[str]()
        for where, line in block.lines:
            parts += fields(line)
            if len(parts) < count and line.endswith(","):
                continue
            if len(parts) != count:
                raise MeshError(
                    f"{where}: expected number and {count - 1} nodes, got {shorten(line)}; correct the line"
                )
            numbers = [natural(part, where) for part in parts]
            self.add(layout.shape, layout.role, numbers, kind)
            own.append(numbers[0])
            parts = []
        if parts:
            raise MeshError(f"{block.where}: expected {count - 1} nodes of the last element, got fewer; complete it")
        self.element_parts.append((block.option("ELSET") or kind, integers(own)))
