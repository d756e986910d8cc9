"""Nastran bulk data: grid points, triangles, rods, bars and beams, single-point constraints.

Read are ``GRID``, ``CTRIA3`` (membrane), ``CROD`` and ``CONROD`` (cable), ``CBAR`` and ``CBEAM`` (beam), ``SPC1``
and ``SPC``, in free, small and large field format. Elements are in the group ``pid<N>`` of their property, constraints
in ``spc<N>`` of their set. Properties, materials and everything else is left to the user of the mesh; other elements,
local coordinate systems and included files are refused. Own, because pyNastran (1.4.1) asks for numpy < 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import (
    Budget,
    IntArray,
    Numbering,
    RawGroup,
    RawMesh,
    integer_array,
    require_coordinates,
    shorten,
)
from tautflex.structure.groups import DIRECTIONS

LINES = {"CROD": "cable", "CONROD": "cable", "CBAR": "beam", "CBEAM": "beam"}
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
        content.add(card)
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
class _Content:
    """What the cards read so far have brought."""

    node_numbers: list[int] = field(default_factory=list)
    positions: list[tuple[float, float, float]] = field(default_factory=list)
    triangles: list[tuple[int, ...]] = field(default_factory=list)
    lines: list[tuple[int, ...]] = field(default_factory=list)
    line_roles: list[str] = field(default_factory=list)
    triangle_property: list[int] = field(default_factory=list)
    line_property: list[int] = field(default_factory=list)
    constraints: list[Card] = field(default_factory=list)
    held_points: list[tuple[int, tuple[str, ...]]] = field(default_factory=list)

    def add(self, card: Card) -> None:
        if card.name == "GRID":
            self._add_point(card)
        elif card.name == "CTRIA3":
            self.triangles.append(tuple(natural(card.get(k), card.where) for k in (1, 3, 4, 5)))
            self.triangle_property.append(_property(card))
        elif card.name in LINES:
            self.lines.append(tuple(natural(card.get(k), card.where) for k in _ends(card)))
            self.line_roles.append(LINES[card.name])
            self.line_property.append(0 if card.name == "CONROD" else _property(card))
        elif card.name in ("SPC", "SPC1"):
            self.constraints.append(card)
        elif card.name.startswith(REFUSED):
            raise MeshError(
                f"{card.where}: not read here; mesh with CTRIA3, CROD, CBAR and CBEAM in the basic coordinate system"
            )

    def _add_point(self, card: Card) -> None:
        for place, what in ((2, "definition"), (6, "displacement")):
            if card.get(place) not in ("", "0", "-1"):
                raise MeshError(
                    f"{card.where}: expected no {what} coordinate system, got {card.get(place)!r}; use basic"
                )
        number = natural(card.get(1), card.where)
        self.node_numbers.append(number)
        x, y, z = (real(card.get(k), card.where) for k in (3, 4, 5))
        self.positions.append((x, y, z))
        if card.get(7) not in ("", "0"):
            self.held_points.append((number, _components(card.get(7), card.where)))

    def finish(self) -> RawMesh:
        numbers = np.array(self.node_numbers, dtype=np.int64)
        positions = np.array(self.positions, dtype=float).reshape(-1, 3)
        require_coordinates(positions, numbers)
        nodes = Numbering("grid point", numbers)
        triangles, lines = integer_array(self.triangles, 4), integer_array(self.lines, 3)
        Numbering("element", np.concatenate([triangles[:, 0], lines[:, 0]]))
        return RawMesh(
            positions,
            nodes.rows(triangles[:, 1:], "CTRIA3"),
            nodes.rows(lines[:, 1:], "CROD, CBAR or CBEAM"),
            np.array(self.line_roles, dtype="<U8"),
            (*self._property_groups(), *self._support_groups(nodes)),
            typed=True,
        )

    def _property_groups(self) -> Iterator[RawGroup]:
        of_triangles = np.array(self.triangle_property, dtype=np.int64)
        of_lines = np.array(self.line_property, dtype=np.int64)
        in_triangles, in_lines = _by_value(of_triangles), _by_value(of_lines)
        empty = np.zeros(0, dtype=np.int64)
        for number in sorted(in_triangles.keys() | in_lines.keys()):
            name = f"pid{number}" if number else "conrod"
            yield RawGroup(name, triangles=in_triangles.get(number, empty), lines=in_lines.get(number, empty))

    def _support_groups(self, nodes: Numbering) -> Iterator[RawGroup]:
        for number, directions in self.held_points:
            yield RawGroup("grid", nodes=nodes.rows(np.array([number]), "GRID"), directions=directions)
        budget = Budget()
        for card in self.constraints:
            name = f"spc{natural(card.get(1), card.where)}"
            if card.name == "SPC1":
                numbers, directions = _listed(card, nodes, budget)
                yield RawGroup(name, nodes=nodes.rows(numbers, card.where), directions=directions)
                continue
            for start in (2, 5):
                if start == 2 or card.get(start):
                    point, directions = _single(card, start)
                    yield RawGroup(name, nodes=nodes.rows(np.array([point]), card.where), directions=directions)


def _single(card: Card, start: int) -> tuple[int, tuple[str, ...]]:
    """Point and held directions of one of the two triples of an SPC card."""
    if real(card.get(start + 2), card.where) != 0.0:
        raise MeshError(
            f"{card.where}: expected a held point, got the displacement {card.get(start + 2)!r}; set it to 0"
        )
    return natural(card.get(start), card.where), _components(card.get(start + 1), card.where)


def _listed(card: Card, nodes: Numbering, budget: Budget) -> tuple[IntArray, tuple[str, ...]]:
    """Points and held directions of an SPC1 card: a list, or first THRU last."""
    words = [text for text in card.fields[2:] if text]
    if len(words) == 3 and words[1].upper() == "THRU":
        numbers = nodes.within(natural(words[0], card.where), natural(words[2], card.where))
    else:
        numbers = np.array([natural(word, card.where) for word in words], dtype=np.int64)
    budget.spend(len(numbers) + 1, card.where)
    return numbers, _components(card.get(2), card.where)


def _by_value(values: IntArray) -> dict[int, IntArray]:
    """Rows of each value."""
    order = np.argsort(values, kind="stable")
    numbers, first = np.unique(values[order], return_index=True)
    return dict(zip(numbers.tolist(), np.split(order, first[1:]), strict=True)) if len(numbers) else {}


def _property(card: Card) -> int:
    """Property of an element; blank stands for its own number."""
    return natural(card.get(2) or card.get(1), card.where)


def _ends(card: Card) -> tuple[int, int, int]:
    return (1, 2, 3) if card.name == "CONROD" else (1, 3, 4)


def _components(text: str, where: str) -> tuple[str, ...]:
    digits = text.strip()
    if not digits or set(digits) - set("123456") or len(set(digits)) != len(digits):
        raise MeshError(f"{where}: expected components out of 123456, got {shorten(text)}; correct the card")
    return tuple(DIRECTIONS[int(digit) - 1] for digit in sorted(digits))
