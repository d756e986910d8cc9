"""Nastran bulk data: grid points, triangles, rods, bars and beams, single-point constraints.

Read are ``GRID``, ``CTRIA3`` (membrane), ``CROD`` and ``CONROD`` (cable), ``CBAR`` and ``CBEAM`` (beam), ``SPC1``
and ``SPC``, in free, small and large field format. Elements are in the group ``pid<N>`` of their property, constraints
in ``spc<N>`` of their set. Properties, materials and everything else is left to the user of the mesh; other elements,
local coordinate systems and included files are refused. Own, because pyNastran (1.4.1) asks for numpy < 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from tautflex.errors import MeshError
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Budget, Gathered, Numbering, RawGroup, RawMesh, integers, shorten
from tautflex.numeric import Indices
from tautflex.structure.groups import DIRECTIONS

ROLES = {"CTRIA3": "membrane", "CROD": "cable", "CONROD": "cable", "CBAR": "beam", "CBEAM": "beam"}
_NODES = {"CTRIA3": (3, 4, 5), "CONROD": (2, 3)}  # fields with nodes; of all others the third and fourth
# Cards that connect nodes in a way the readers do not know: leaving them out would change the structure in silence.
REFUSED = (
    *("CQUAD", "CTRIA", "CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CBUSH", "CELAS", "CBEND", "CTUBE", "CSHEAR", "CGAP"),
    *("RBE", "RBAR", "RROD", "MPC", "INCLUDE", "CORD"),
)


@dataclass(frozen=True)
class Card:
    """Bulk data entry: its name and fields, continuation lines joined."""

    name: str
    fields: list[str]
    where: str

    def get(self, place: int) -> str:
        """Field number ``place`` from 1, "" if the card ends before."""
        return self.fields[place - 1] if place <= len(self.fields) else ""


def read_nastran(text: str) -> RawMesh:
    """Read the mesh of a Nastran bulk data file; MeshError if a card is wrong, or uses what is not read here."""
    content = _Content()
    for card in cards(text):
        content.read(card)
    return content.finish()


def cards(text: str) -> Iterator[Card]:
    """Cards of the bulk data section; the whole text if it is not marked."""
    lines = text.splitlines()
    begin = next((k for k, line in enumerate(lines) if line.upper().split()[:2] == ["BEGIN", "BULK"]), -1)
    current: Card | None = None
    for number, raw_line in enumerate(lines[begin + 1 :], start=begin + 2):
        line = raw_line.partition("$")[0].rstrip().expandtabs(8)
        if not line.strip():
            continue
        if line.strip().upper() == "ENDDATA":
            break
        first, fields = _split(line)
        if first[:1] in ("", "+", "*"):
            if current is None:
                raise MeshError(f"line {number}: expected a card, got a continuation; correct the line")
            current.fields.extend(fields)
            continue
        if current is not None:
            yield current
        name = first.rstrip("*").upper()
        current = Card(name, fields, f"line {number} ({shorten(name, 12)})")
    if current is not None:
        yield current


def _split(line: str) -> tuple[str, list[str]]:
    """Name field and data fields of one line: free format has commas, large fields a star behind the name.

    Fields of continuation marks are left out; a line in fixed fields always has 8 (or 4) of them.
    """
    if "," in line:
        first, *rest = (part.strip() for part in line.split(","))
        most = 4 if "*" in first else 8
        return first, _padded(rest[:most], most)
    first = line[:8].strip()
    width, count = (16, 4) if "*" in first else (8, 8)
    return first, [line[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]


def _padded(fields: list[str], count: int) -> list[str]:
    return fields + [""] * (count - len(fields))


@dataclass
class _Content(Gathered):
    """What the cards read so far have brought."""

    properties: dict[int, dict[str, list[int]]] = field(default_factory=dict)
    constraints: list[Card] = field(default_factory=list)
    held_points: list[tuple[int, tuple[str, ...]]] = field(default_factory=list)

    def read(self, card: Card) -> None:
        if card.name == "GRID":
            self._read_point(card)
        elif card.name in ROLES:
            places = (1, *_NODES.get(card.name, (3, 4)))
            kind, row = self.add(ROLES[card.name], [natural(card.get(k), card.where) for k in places])
            # A blank property stands for the element's own number; CONROD has none.
            number = 0 if card.name == "CONROD" else natural(card.get(2) or card.get(1), card.where)
            self.properties.setdefault(number, {}).setdefault(kind, []).append(row)
        elif card.name in ("SPC", "SPC1"):
            self.constraints.append(card)
        elif card.name.startswith(REFUSED):
            raise MeshError(
                f"{card.where}: not read here; mesh with CTRIA3, CROD, CBAR and CBEAM in the basic coordinate system"
            )

    def _read_point(self, card: Card) -> None:
        for place, what in ((2, "definition"), (6, "displacement")):
            if card.get(place) not in ("", "0", "-1"):
                raise MeshError(
                    f"{card.where}: expected no {what} coordinate system, got {card.get(place)!r}; use basic"
                )
        self.node_numbers.append(natural(card.get(1), card.where))
        self.positions.append([real(card.get(k), card.where) for k in (3, 4, 5)])
        if card.get(7) not in ("", "0"):
            self.held_points.append((self.node_numbers[-1], _components(card.get(7), card.where)))

    def finish(self) -> RawMesh:
        nodes, _ = self.numbered("grid point")
        groups = [
            RawGroup(f"pid{number}" if number else "conrod", {kind: integers(rows) for kind, rows in found.items()})
            for number, found in sorted(self.properties.items())
        ]
        words = {"triangles": "CTRIA3", "lines": "CROD, CBAR or CBEAM"}
        return self.mesh(nodes, [*groups, *self._support_groups(nodes)], words)

    def _support_groups(self, nodes: Numbering) -> Iterator[RawGroup]:
        for number, directions in self.held_points:
            yield RawGroup("grid", {"nodes": nodes.rows(integers([number]), "GRID")}, directions)
        budget = Budget()
        for card in self.constraints:
            name = f"spc{natural(card.get(1), card.where)}"
            places = [2, 5] if card.name == "SPC" and card.get(5) else [2]
            for numbers, directions in (
                [_listed(card, nodes, budget)] if card.name == "SPC1" else [_single(card, start) for start in places]
            ):
                yield RawGroup(name, {"nodes": nodes.rows(numbers, card.where)}, directions)


def _single(card: Card, start: int) -> tuple[Indices, tuple[str, ...]]:
    """Point and held directions of one of the two triples of an SPC card."""
    if real(card.get(start + 2), card.where) != 0.0:
        raise MeshError(
            f"{card.where}: expected a held point, got the displacement {card.get(start + 2)!r}; set it to 0"
        )
    return integers([natural(card.get(start), card.where)]), _components(card.get(start + 1), card.where)


def _listed(card: Card, nodes: Numbering, budget: Budget) -> tuple[Indices, tuple[str, ...]]:
    """Points and held directions of an SPC1 card: a list, or first THRU last."""
    words = [text for text in card.fields[2:] if text]
    if len(words) == 3 and words[1].upper() == "THRU":
        numbers = nodes.within(natural(words[0], card.where), natural(words[2], card.where))
    else:
        numbers = integers(natural(word, card.where) for word in words)
    budget.spend(len(numbers) + 1, card.where)
    return numbers, _components(card.get(2), card.where)


def _components(text: str, where: str) -> tuple[str, ...]:
    digits = text.strip()
    if not digits or set(digits) - set("123456") or len(set(digits)) != len(digits):
        raise MeshError(f"{where}: expected components out of 123456, got {shorten(text)}; correct the card")
    return tuple(DIRECTIONS[int(digit) - 1] for digit in sorted(digits))
