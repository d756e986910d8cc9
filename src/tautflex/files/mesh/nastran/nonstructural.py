"""Masses without stiffness that a Nastran deck spreads over elements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.case_control import Selection
from tautflex.files.mesh.nastran.elements import Elements, section_kind
from tautflex.files.mesh.nastran.properties import KINDS
from tautflex.files.mesh.nastran.ranges import ranges
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import RawGroup, RawNonstructural, integers, shorten
from tautflex.numeric import Indices

NONSTRUCTURAL = ("NSM", "NSM1", "NSML", "NSML1", "NSMADD")
_TYPES = {**KINDS, "CONROD": "cable", "ELEMENT": ""}


@dataclass
class Nonstructural:
    """What NSM, NSM1, NSML, NSML1 and NSMADD cards add, by set."""

    sets: dict[int, list[Card]] = field(default_factory=dict)
    unions: dict[int, set[int]] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Keep a card under its set."""
        number = natural(card.get(1), card.where)
        if card.name == "NSMADD":
            listed = {natural(text, card.where) for text in card.fields[1:] if text}
            self.unions.setdefault(number, set()).update(listed)
        else:
            self.sets.setdefault(number, []).append(card)

    def groups(self, selection: Selection, elements: Elements, factor: float) -> Iterator[RawGroup]:
        """Group ``nsmN`` of each selected set, one for each of its masses, which are taken times ``factor``."""
        for number in sorted(selection.only_or_chosen("NSM", "NSM", self.sets, self.unions)):
            for card in self.sets[number]:
                for rows, value in _spread(card, elements):
                    films = sum(len(own) for shape, own in rows.items() if not shape.startswith("line"))
                    if films and "line2" in rows:
                        raise MeshError(f"{card.where}: expected films or lines, got both; split the card")
                    # The lumped kinds state the whole mass of what they name.
                    per = "shared" if card.name.startswith("NSML") else "membrane" if films else "line"
                    yield RawGroup(
                        f"nsm{number}", rows, nonstructural=(RawNonstructural(card.where, per, factor * value),)
                    )


def _spread(card: Card, elements: Elements) -> Iterator[tuple[dict[str, Indices], float]]:
    """Rows of elements by shape, and the mass that they get."""
    kind = card.get(2).upper()
    if kind not in _TYPES:
        raise MeshError(f"{card.where}: expected a type of {', '.join(_TYPES)}, got {shorten(kind)}; correct the card")
    if card.name in ("NSM1", "NSML1"):
        yield _rows(card, elements, kind, card.fields[3:]), real(card.get(3), card.where)
        return
    for place in range(3, len(card.fields) + 1, 2):
        if card.get(place):
            yield _rows(card, elements, kind, [card.get(place)]), real(card.get(place + 1), card.where)


def _rows(card: Card, elements: Elements, kind: str, listed: list[str]) -> dict[str, Indices]:
    """Rows by shape of the elements, or of those of the properties, that a list of numbers and ranges names."""
    everything = [text.upper() for text in listed] == ["ALL"]
    wanted = [] if everything else list(ranges(card, listed))
    left, found = {one for one in wanted if one.listed}, dict[str, Indices]()
    for shape, owners in _owners(elements, kind).items():
        numbers = integers(owner for owner, _ in owners)
        takes = np.full(len(numbers), everything)
        for one in wanted:
            own = (numbers >= one.first) & (numbers <= one.last) & ((numbers - one.first) % one.step == 0)
            if own.any():
                left.discard(one)
            takes |= own
        rows = integers(row for (_, row), taken in zip(owners, takes.tolist(), strict=True) if taken)
        if len(rows):
            found[shape] = rows
    if left or not found:
        missing = ", ".join(str(one.first) for one in sorted(left)) or "none"
        raise MeshError(
            f"{card.where}: expected elements or properties of {kind}, got no elements of {missing}; correct the card"
        )
    return found


def _owners(elements: Elements, kind: str) -> dict[str, list[tuple[int, int]]]:
    """Number that a type of card names, and row, of the elements of each shape: of the property, or their own."""
    role = _TYPES[kind]
    found: dict[str, list[tuple[int, int]]] = {}
    if kind in ("ELEMENT", "CONROD"):
        for shape, own in elements.elements.items():
            found[shape] = [(line[0], row) for row, line in enumerate(own)]
        if kind == "CONROD":
            rods = set(elements.properties.get(0, {}).get("line2", ()))
            found = {"line2": [(number, row) for number, row in found["line2"] if row in rods]}
        return found
    for number, shapes in elements.properties.items():
        for shape, rows in shapes.items():
            own_role = [section_kind(elements.roles[shape][row]) for row in rows]
            found.setdefault(shape, []).extend(
                (number, row) for row, one in zip(rows, own_role, strict=True) if number and one == role
            )
    return found
