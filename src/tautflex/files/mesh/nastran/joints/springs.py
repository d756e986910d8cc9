"""Springs of a Nastran deck."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh.nastran.coordinates import Systems
from tautflex.files.mesh.nastran.supports import components
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, real, vector
from tautflex.files.mesh.raw import Numbering, integers, shorten
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array
from tautflex.structure.springs import Spring

SPRINGS = ("CELAS1", "CELAS2", "CBUSH", "PELAS", "PBUSH")
Point = Callable[[int, str], Array]


@dataclass
class Springs:
    """What CELAS1, CELAS2 and CBUSH cards, with PELAS and PBUSH, join."""

    cards: list[Card] = field(default_factory=list)
    stiffness: dict[int, Array] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Keep an element, or the stiffness of a property."""
        if card.name == "PELAS":
            card.require_only(*range(1, 9))
            for place in (1, 5):
                if card.get(place):
                    self._keep(card, place, np.array([real(card.get(place + 1), card.where)]))
        elif card.name == "PBUSH":
            self._keep(card, 1, _bush(card))
        else:
            self.cards.append(card)

    def _keep(self, card: Card, place: int, stiffness: Array) -> None:
        number = natural(card.get(place), card.where)
        if number in self.stiffness:
            raise MeshError(f"{card.where}: property {number} is defined twice; give it its own number")
        self.stiffness[number] = stiffness

    def springs(
        self, nodes: Numbering, point: Point, axes: Callable[[int], Array | None], systems: Systems
    ) -> Iterator[RawLink]:
        """Springs between rows of the points.

        ``point`` and ``axes`` are positions of points and the directions of their displacement systems.
        """
        for card in self.cards:
            try:
                bush = card.name == "CBUSH"
                found = self._bushing(card, nodes, point, systems) if bush else self._scalar(card, nodes, axes)
            except MeshError:
                raise
            except InputError as error:
                raise MeshError(f"{card.where}: {error}") from None
            if found is not None:
                yield RawLink(card.where, found)

    def _property(self, card: Card, count: int) -> Array:
        number = natural(card.get(2) or card.get(1), card.where)
        found = self.stiffness.get(number)
        if found is None or len(found) != count:
            kind = "PELAS" if count == 1 else "PBUSH"
            raise MeshError(f"{card.where}: expected a {kind} {number}, got none; add it")
        return found

    def _scalar(self, card: Card, nodes: Numbering, axes: Callable[[int], Array | None]) -> Spring | None:
        card.require_only(*range(1, 9))
        value = self._property(card, 1)[0] if card.name == "CELAS1" else real(card.get(2), card.where)
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
            return None
        return Spring(
            nodes.rows(integers(numbers), card.where).tolist(), tuple(value * np.eye(6)[direction]), turned[0]
        )

    def _bushing(self, card: Card, nodes: Numbering, point: Point, systems: Systems) -> Spring | None:
        card.require_only(*range(1, 10))
        numbers = [natural(card.get(k), card.where) for k in (3, 4) if card.get(k) not in ("", "0")]
        places = [point(number, card.where) for number in numbers]
        stiffness = self._property(card, 6)
        if not stiffness.any():
            return None
        apart = len(places) == 2 and np.linalg.norm(places[1] - places[0]) > 0.0
        if card.get(8):
            turn = systems.named(card.get(8), card.where).directions(places[0])
        elif not apart:
            raise MeshError(f"{card.where}: expected CID for points at one place, got none; name the spring's axes")
        elif card.get(5):
            turn = _along(card, places, point)
        elif not stiffness[[1, 2, 4, 5]].any():
            turn = _along(card, places, None)
        else:
            raise MeshError(f"{card.where}: expected an orientation vector or CID, got none; add it")
        place = (real(card.get(9), card.where) if card.get(9) else 0.5) if apart else None
        return Spring(nodes.rows(integers(numbers), card.where).tolist(), tuple(stiffness), turn, place)


def _bush(card: Card) -> Array:
    """Six stiffnesses; damping is the case's to state."""
    words, place, found = [text.upper() for text in card.fields], 1, np.zeros(6)
    while place < len(words):
        word = words[place]
        if word == "K":
            found = vector(card.fields[place + 1 : place + 7], card.where, largest=1e300)
            found = np.concatenate([found, np.zeros(6 - len(found))])
            place += 7
        elif word in ("B", "GE", "RCV", "M"):
            rest = [text for text in card.fields[place + 1 : place + 7] if text]
            if word in ("B", "M") and any(real(text, card.where) != 0.0 for text in rest):
                raise MeshError(f"{card.where}: expected no {word}, got one, which is not read here; remove it")
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
