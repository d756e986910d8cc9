"""Supports of a Nastran deck."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.case_control import Selection
from tautflex.files.mesh.nastran.ranges import ranges
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Budget, Numbering, RawGroup, integers, shorten
from tautflex.files.mesh.systems import held_directions
from tautflex.numeric import Array

Held = dict[int, set[int]]
"""Directions 0 to 5 that are held, by grid point."""


def components(text: str, where: str) -> set[int]:
    """Directions 0 to 5 of a field like 123, or MeshError."""
    digits = text.strip()
    if not digits or set(digits) - set("123456") or len(set(digits)) != len(digits):
        raise MeshError(f"{where}: expected components out of 123456, got {shorten(text)}; correct the card")
    return {int(digit) - 1 for digit in digits}


@dataclass
class Supports:
    """What SPC, SPC1 and SPCADD cards hold, by set."""

    sets: dict[int, list[Card]] = field(default_factory=dict)
    unions: dict[int, set[int]] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Keep a card under its set."""
        number = natural(card.get(1), card.where)
        if card.name == "SPCADD":
            listed = {natural(text, card.where) for text in card.fields[1:] if text}
            self.unions.setdefault(number, set()).update(listed)
        else:
            self.sets.setdefault(number, []).append(card)

    def groups(self, selection: Selection, nodes: Numbering, axes: Callable[[int], Array | None]) -> Iterator[RawGroup]:
        """Group ``spcN`` of each set; one that is not selected is a mere selection of points.

        ``axes`` are the directions of the displacement system of a point, None where they are global.
        """
        budget = Budget()
        chosen = selection.chosen("SPC", "SPC1", self.sets, self.unions)
        for number, cards in sorted(self.sets.items()):
            name = f"spc{number}"
            doubt = "" if chosen is not None else "a case control that selects one of them (SPC = number)"
            held: Held = {}
            for card in cards:
                for points, directions in _read(card, nodes, budget):
                    for point in points:
                        held.setdefault(point, set()).update(directions)
            if chosen is not None and number not in chosen:
                yield RawGroup(name, {"nodes": nodes.rows(integers(held), name)})
            else:
                yield from held_groups(name, held, nodes, axes, doubt)


def held_groups(
    name: str, held: Held, nodes: Numbering, axes: Callable[[int], Array | None], doubt: str = ""
) -> Iterator[RawGroup]:
    """Groups of points that are held in the same global directions, and of each that is held in others."""
    alike: dict[tuple[str, ...], list[int]] = {}
    for point, directions in held.items():
        row = nodes.rows(integers([point]), name)
        found, links = held_directions(directions, axes(point), int(row[0]), f"{name}: grid point {point}")
        if found:
            alike.setdefault(found, []).append(point)
        if links:
            yield RawGroup(name, {"nodes": row}, (), doubt, links=tuple(links))
    for found, points in alike.items():
        yield RawGroup(name, {"nodes": nodes.rows(integers(points), name)}, found, doubt)


def _read(card: Card, nodes: Numbering, budget: Budget) -> Iterator[tuple[list[int], set[int]]]:
    """Points and directions of a card."""
    if card.name == "SPC1":
        numbers = np.concatenate(list(_listed(card, nodes))).tolist()
        budget.spend(len(numbers) + 1, card.where)
        yield numbers, components(card.get(2), card.where)
        return
    for start in (2, 5) if card.get(5) else (2,):
        if real(card.get(start + 2), card.where) != 0.0:
            raise MeshError(
                f"{card.where}: expected a held point, got the displacement {card.get(start + 2)!r}; set it to 0"
            )
        number = natural(card.get(start), card.where)
        nodes.rows(integers([number]), card.where)
        yield [number], components(card.get(start + 1), card.where)
    card.require_only(*range(1, 8))


def _listed(card: Card, nodes: Numbering) -> Iterator[np.ndarray]:
    """Points of an SPC1 card: numbers, and ranges from one THRU another, of which those hold that exist."""
    if not any(card.fields[2:]):
        raise MeshError(f"{card.where}: expected grid points, got none; list them, or remove the card")
    for one in ranges(card, card.fields[2:]):
        if one.listed:
            nodes.rows(integers([one.first]), card.where)
        yield nodes.within(one.first, one.last, one.step)
