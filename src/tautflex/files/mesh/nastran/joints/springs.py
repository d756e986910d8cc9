"""Springs and dampers of a Nastran deck."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh.nastran.coordinates import Systems
from tautflex.files.mesh.nastran.supports import components
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import finite, natural, real, vector
from tautflex.files.mesh.raw import Numbering, integers, shorten
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array
from tautflex.structure.springs import Damper, Joint, Spring

SPRINGS = ("CELAS1", "CELAS2", "CBUSH", "PELAS", "PBUSH", "CDAMP1", "CDAMP2", "CVISC", "PDAMP", "PVISC")
# Several properties of a card: places of their numbers, and how many values stand behind each.
_SCALARS = {"PELAS": ((1, 5), 1), "PDAMP": ((1, 3, 5, 7), 1), "PVISC": ((1, 5), 2)}
Point = Callable[[int, str], Array]


@dataclass
class Springs:
    """What CELAS1, CELAS2, CDAMP1, CDAMP2, CVISC and CBUSH cards, with their properties, join."""

    cards: list[Card] = field(default_factory=list)
    values: dict[tuple[str, int], Array] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Keep an element, or the numbers of a property."""
        if card.name in _SCALARS:
            card.require_only(*range(1, 9))
            places, count = _SCALARS[card.name]
            for place in places:
                if card.get(place):
                    given = [card.get(place + 1 + k) or "0." for k in range(count)]
                    self._keep(card, place, np.array([finite(one, card.where) for one in given]))
        elif card.name == "PBUSH":
            self._keep(card, 1, _bush(card))
        else:
            self.cards.append(card)

    def _keep(self, card: Card, place: int, values: Array) -> None:
        number = natural(card.get(place), card.where)
        if (card.name, number) in self.values:
            raise MeshError(f"{card.where}: property {number} is defined twice; give it its own number")
        self.values[card.name, number] = values

    def springs(
        self, nodes: Numbering, point: Point, axes: Callable[[int], Array | None], systems: Systems
    ) -> Iterator[RawLink]:
        """Springs and dampers between rows of the points.

        ``point`` and ``axes`` are positions of points and the directions of their displacement systems.
        """
        for card in self.cards:
            try:
                if card.name == "CBUSH":
                    found = self._bushing(card, nodes, point, systems)
                elif card.name == "CVISC":
                    found = self._line(card, nodes, point)
                else:
                    found = self._scalar(card, nodes, axes)
            except MeshError:
                raise
            except InputError as error:
                raise MeshError(f"{card.where}: {error}") from None
            yield from (RawLink(card.where, one) for one in found)

    def _property(self, card: Card, kind: str) -> Array:
        number = natural(card.get(2) or card.get(1), card.where)
        if (kind, number) not in self.values:
            raise MeshError(f"{card.where}: expected a {kind} {number}, got none; add it")
        return self.values[kind, number]

    def _scalar(self, card: Card, nodes: Numbering, axes: Callable[[int], Array | None]) -> list[Joint]:
        spring = card.name.startswith("CELAS")
        card.require_only(*range(1, 9 if spring else 7))
        own = card.name.endswith("2")
        value = finite(card.get(2), card.where) if own else self._property(card, "PELAS" if spring else "PDAMP")[0]
        ends = [(card.get(k), card.get(k + 1)) for k in (3, 5) if card.get(k) not in ("", "0")]
        parts = {frozenset(components(one, card.where)) for _, one in ends}
        if len(parts) != 1 or len(next(iter(parts))) != 1:
            raise MeshError(
                f"{card.where}: expected the same component at both points, got {shorten(str(ends))}; one that joins "
                "different directions is not read here"
            )
        direction = next(iter(next(iter(parts))))
        numbers = [natural(number, card.where) for number, _ in ends]
        turned = [axes(number) for number in numbers]
        same = turned[0] is turned[-1] or (
            turned[0] is not None and turned[-1] is not None and np.allclose(turned[0], turned[-1])
        )
        if not same:
            raise MeshError(f"{card.where}: expected points with the same displacement axes, got others; use CBUSH")
        if value == 0.0:
            return []
        rows = nodes.rows(integers(numbers), card.where).tolist()
        return [(Spring if spring else Damper)(rows, tuple(value * np.eye(6)[direction]), turned[0])]

    def _line(self, card: Card, nodes: Numbering, point: Point) -> list[Joint]:
        """Damper along, and about, the line between two points."""
        card.require_only(*range(1, 5))
        numbers = [natural(card.get(k), card.where) for k in (3, 4)]
        places = [point(number, card.where) for number in numbers]
        along, about = self._property(card, "PVISC")
        if not along and not about:
            return []
        if not np.linalg.norm(places[1] - places[0]) > 0.0:
            raise MeshError(f"{card.where}: expected points at two places, got one; use CDAMP2 between them")
        rows = nodes.rows(integers(numbers), card.where).tolist()
        return [Damper(rows, (along, 0.0, 0.0, about, 0.0, 0.0), _along(card, places, None))]

    def _bushing(self, card: Card, nodes: Numbering, point: Point, systems: Systems) -> list[Joint]:
        card.require_only(*range(1, 10))
        numbers = [natural(card.get(k), card.where) for k in (3, 4) if card.get(k) not in ("", "0")]
        places = [point(number, card.where) for number in numbers]
        given = self._property(card, "PBUSH")
        if not given.any():
            return []
        apart = len(places) == 2 and np.linalg.norm(places[1] - places[0]) > 0.0
        if card.get(8):
            turn = systems.named(card.get(8), card.where).directions(places[0])
        elif not apart:
            raise MeshError(f"{card.where}: expected CID for points at one place, got none; name the spring's axes")
        elif card.get(5):
            turn = _along(card, places, point)
        elif not given[:, [1, 2, 4, 5]].any():
            turn = _along(card, places, None)
        else:
            raise MeshError(f"{card.where}: expected an orientation vector or CID, got none; add it")
        place = (real(card.get(9), card.where) if card.get(9) else 0.5) if apart else None
        rows = nodes.rows(integers(numbers), card.where).tolist()
        kinds: tuple[type[Spring] | type[Damper], ...] = (Spring, Damper)
        return [kind(rows, tuple(own), turn, place) for kind, own in zip(kinds, given, strict=True) if own.any()]


def _bush(card: Card) -> Array:
    """Six stiffnesses and six numbers of damping, shape (2, 6)."""
    words, place, found = [text.upper() for text in card.fields], 1, np.zeros((2, 6))
    while place < len(words):
        word = words[place]
        if word in ("K", "B"):
            if word in words[1:place]:
                raise MeshError(f"{card.where}: expected {word} once, got it twice; remove one")
            values = vector(card.fields[place + 1 : place + 7], card.where, largest=1e300)
            found["KB".index(word), : len(values)] = values
            place += 7
        elif word in ("GE", "RCV", "M"):
            rest = [text for text in card.fields[place + 1 : place + 7] if text]
            if word == "M" and any(real(text, card.where) != 0.0 for text in rest):
                raise MeshError(f"{card.where}: expected no M, got one, which is not read here; write it as CONM2")
            place += 7
        elif word:
            raise MeshError(f"{card.where}: expected K, B, GE or RCV, got {shorten(word)}; correct the card")
        else:
            place += 1
    return found


def _along(card: Card, places: list[Array], point: Point | None) -> Array:
    """Axes of a spring between two points, as rows: x along it, y towards the orientation vector."""
    x = (places[1] - places[0]) / np.linalg.norm(places[1] - places[0])
    if point is None:
        side = np.eye(3)[int(np.abs(x).argmin())]
    elif card.get(6) or card.get(7) or "." in card.get(5):
        side = vector([card.get(k) for k in (5, 6, 7)], card.where)
    else:
        side = point(natural(card.get(5), card.where), card.where) - places[0]
    z = np.cross(x, side)
    if not np.linalg.norm(z) > 1e-9 * np.linalg.norm(side):
        raise MeshError(f"{card.where}: expected an orientation vector across the spring, got one along it; correct it")
    z /= np.linalg.norm(z)
    return np.array([x, np.cross(z, x), z])
