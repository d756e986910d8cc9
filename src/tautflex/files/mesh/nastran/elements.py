"""Elements of a Nastran deck: films, cables, beams."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.gathered import UNSTATED, Gathered
from tautflex.files.mesh.nastran.joints.ends import ENDS, Turned, offset, placed
from tautflex.files.mesh.nastran.properties import Properties
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.new_ends import NewEnds
from tautflex.files.mesh.numerals import natural, vector
from tautflex.files.mesh.raw import RawGroup, integers, shorten
from tautflex.numeric import Array, Indices

_INTEGER = re.compile(r"\+?\d{1,19}")
_OFFSET_FLAG = re.compile(r"[GB][GO][GO]", re.IGNORECASE)
_OLD_FLAGS = ("1", "2")  # of Nastran's first decks: a vector, a third point


class Layout(NamedTuple):
    """Fields of an element card: its nodes, and those that say nothing about this structure."""

    shape: str
    role: str
    nodes: tuple[int, ...]
    idle: tuple[int, ...] = ()


# Idle: the angle of the material of a film, which is isotropic; the torsion of CONROD. Its section is read apart.
LAYOUTS = {
    "CTRIA3": Layout("triangle3", "membrane", (3, 4, 5), (6,)),
    "CTRIAR": Layout("triangle3", "membrane", (3, 4, 5), (6,)),
    "CQUAD4": Layout("quad4", "membrane", (3, 4, 5, 6), (7,)),
    "CQUADR": Layout("quad4", "membrane", (3, 4, 5, 6), (7,)),
    "CTRIA6": Layout("triangle6", "membrane", (3, 4, 5, 6, 7, 8), (9,)),
    "CQUAD8": Layout("quad8", "membrane", (3, 4, 5, 6, 7, 8, 9, 10), (15,)),
    "CROD": Layout("line2", "cable", (3, 4)),
    "CTUBE": Layout("line2", "cable", (3, 4)),
    "CONROD": Layout("line2", "cable", (2, 3), (4, 5, 6, 7, 8)),
    "CBAR": Layout("line2", "beam", (3, 4)),
    "CBEAM": Layout("line2", "beam", (3, 4)),
}
_DEFAULTS = {"CBAR": "BAROR", "CBEAM": "BEAMOR"}
ORIENTATION = (5, 6, 7, 8)


def section_kind(role: str) -> str:
    """Kind of section that elements of a role have: shells, where they are taken, are membranes."""
    return "membrane" if role == "shell" else role


@dataclass
class Elements(Gathered):
    """What the cards of elements and properties have brought."""

    properties: dict[int, dict[str, list[int]]] = field(default_factory=dict)
    bending: set[int] = field(default_factory=set)
    defaults: dict[str, Card] = field(default_factory=dict)
    beams: list[tuple[int, Card]] = field(default_factory=list)
    cards: list[Card] = field(default_factory=list)
    rods: dict[tuple[str, ...], list[tuple[int, Card]]] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Read an element or a property; MeshError if a field asks for what is not read."""
        if card.name in LAYOUTS:
            self.cards.append(card)
        elif card.name in _DEFAULTS.values():
            card.require_only(2, *ORIENTATION)
            if "O" in card.get(8).upper():
                raise MeshError(f"{card.where}: expected GGG or BGG in field 9, got {shorten(card.get(8))}; correct it")
            if card.name in self.defaults:
                raise MeshError(f"{card.where}: expected one {card.name}, got a second one; remove it")
            self.defaults[card.name] = card
        elif card.name in ("PCOMP", "PCOMPG") or card.get(4) not in ("", "0", "-1"):
            self.bending.add(natural(card.get(1), card.where))

    def finish(self) -> None:
        """Add all elements; a film whose property bends is a shell, which must be asked for."""
        for card in self.cards:
            self._element(card, LAYOUTS[card.name])
        for number in self.bending & self.properties.keys():
            for shape, rows in self.properties[number].items():
                for row in rows:
                    if self.roles[shape][row] == "membrane":
                        self.roles[shape][row] = "shell"

    def _element(self, card: Card, layout: Layout) -> None:
        """Read one element; thicknesses and whatever else is filled is refused by its field."""
        beam = layout.role == "beam"
        own = (1,) if card.name == "CONROD" else (1, 2)
        card.require_only(*own, *layout.nodes, *layout.idle, *((*ORIENTATION, *ENDS) if beam else ()))
        if not all(card.get(place) for place in layout.nodes):
            raise MeshError(f"{card.where}: expected a grid point at every corner and side, got a blank; fill it in")
        numbers = [natural(card.get(place), card.where) for place in (1, *layout.nodes)]
        shape, row = self.add(layout.shape, layout.role, numbers, card.name)
        default = self.defaults.get(_DEFAULTS.get(card.name, ""))
        # A blank property stands for the default, then for the element's own number; CONROD has none.
        number = 0
        if card.name != "CONROD":
            number = natural(card.get(2) or (default.get(2) if default else "") or card.get(1), card.where)
        self.properties.setdefault(number, {}).setdefault(shape, []).append(row)
        if not number:
            self.rods.setdefault(tuple(card.get(place) for place in (4, 5, 8)), []).append((row, card))
        if beam:
            self.beams.append((row, card))

    def owners(self) -> Iterator[tuple[str, int, str, str]]:
        """Shape, row, role and property of every element; of a CONROD its material behind an M."""
        for number, shapes in self.properties.items():
            for shape, rows in shapes.items():
                yield from ((shape, row, self.roles[shape][row], str(number)) for row in rows if number)
        for rods in self.rods.values():
            yield from (("line2", row, "cable", f"M{card.get(4)}") for row, card in rods)

    def groups(self, properties: Properties, factor: float) -> list[RawGroup]:
        """Group of each property with its sections, their masses times ``factor``; CONROD states its own."""
        rods = [properties.rod(members[0][1], factor) for members in self.rods.values()]
        groups = []
        for number, found in sorted(self.properties.items()):
            sections = tuple(properties.sections(number, factor)) if number else tuple(rods if len(rods) == 1 else ())
            name = f"pid{number}" if number else "conrod"
            rows = {kind: integers(rows) for kind, rows in found.items()}
            groups.append(RawGroup(name, rows, sections=sections))
        if len(rods) > 1:
            for place, (section, members) in enumerate(zip(rods, self.rods.values(), strict=True), start=1):
                rows = {"line2": integers(row for row, _ in members)}
                groups.append(RawGroup(f"conrod{place}", rows, sections=(section,)))
        return groups

    def orientations(self, point: Callable[[int, str], Array], turned: Callable[[int, Array, str], Array]) -> Array:
        """Direction of each line's local z axis, shape (line, 3): normal to its axis and to its orientation vector.

        The vector, from the card, from BAROR or BEAMOR, or from the first end to a third point, lies in plane 1, so
        that it is local y, and ``inertia_z`` is I1. ``turned`` takes a vector from the displacement system of a point.
        """
        result = np.array([UNSTATED] * len(self.elements["line2"])).reshape(-1, 3)
        for row, card in self.beams:
            given = [card.get(place) for place in ORIENTATION]
            default = self.defaults.get(_DEFAULTS[card.name])
            if not any(given[:3]) and default is not None:
                given[:3] = [default.get(place) for place in ORIENTATION[:3]]
            given[3] = given[3] or (default.get(8) if default else "")
            first, second = (natural(card.get(place), card.where) for place in (3, 4))
            if given[3] and not _OFFSET_FLAG.fullmatch(given[3]) and given[3] not in _OLD_FLAGS:
                raise MeshError(f"{card.where}: expected GGG or BGG in field 9, got {shorten(given[3])}; correct it")
            if not any(given[:3]):
                continue
            along = point(second, card.where) + offset(card, 1, second, turned)
            along -= point(first, card.where) + offset(card, 0, first, turned)
            third = _INTEGER.fullmatch(given[0]) and not any(given[1:3])
            if given[3] == _OLD_FLAGS[1] or (third and given[3] != _OLD_FLAGS[0]):
                side = point(natural(given[0], card.where), card.where) - point(first, card.where)
            else:
                side = vector(given[:3], card.where)
                side = side if given[3][:1].upper() == "B" else turned(first, side, card.where)
            result[row] = np.cross(along, side)
            if not np.linalg.norm(result[row]) > 1e-9 * np.linalg.norm(along) * np.linalg.norm(side):
                raise MeshError(
                    f"{card.where}: expected an orientation vector across the beam, got one along it; correct it"
                )
        return result

    def moved_ends(self, points: Array, lines: Indices, orientation: Array, turned: Turned) -> tuple[Indices, NewEnds]:
        """Rows of nodes of the lines, with new ones for offset and pinned ends, and these."""
        moved, lines = NewEnds(list(points)), lines.copy()
        for row, card in self.beams:
            if any(card.get(place) for place in ENDS):
                numbers = [natural(card.get(place), card.where) for place in (3, 4)]
                lines[row] = placed(moved, card, lines[row], numbers, orientation[row], turned)
        return lines, moved
