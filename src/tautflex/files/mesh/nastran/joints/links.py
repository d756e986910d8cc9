"""Rigid elements and multipoint constraints of a Nastran deck."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh.nastran.case_control import Selection
from tautflex.files.mesh.nastran.ranges import ranges
from tautflex.files.mesh.nastran.supports import components
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, real
from tautflex.files.mesh.raw import Numbering, integers, shorten
from tautflex.files.mesh.raw_links import RawLink, equation
from tautflex.files.mesh.systems import global_directions
from tautflex.numeric import Array
from tautflex.structure.links.distributing import DistributingLink
from tautflex.structure.links.link import Link
from tautflex.structure.links.rigid import RigidLink

LINKS = ("RBE1", "RBE2", "RBE3", "RBAR", "MPC", "MPCADD")
_ALL = "123456"
Axes = Callable[[int], Array | None]


@dataclass
class Links:
    """What RBE1, RBE2, RBE3, RBAR, MPC and MPCADD cards join."""

    cards: list[Card] = field(default_factory=list)
    sets: dict[int, list[Card]] = field(default_factory=dict)
    unions: dict[int, set[int]] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Keep a card; multipoint constraints under their set."""
        if card.name == "MPCADD":
            listed = {natural(text, card.where) for text in card.fields[1:] if text}
            self.unions.setdefault(natural(card.get(1), card.where), set()).update(listed)
        elif card.name == "MPC":
            self.sets.setdefault(natural(card.get(1), card.where), []).append(card)
        else:
            self.cards.append(card)

    def links(self, selection: Selection, nodes: Numbering, axes: Axes) -> Iterator[RawLink]:
        """Links between rows of the points; ``axes`` are the directions of the displacement system of a point."""
        kinds = {"RBE1": _rbe1, "RBE2": _rbe2, "RBE3": _rbe3, "RBAR": _rbar}
        numbers = selection.only_or_chosen("MPC", "MPC", self.sets, self.unions)
        chosen = [card for number in sorted(numbers) for card in self.sets[number]]
        for card in [*self.cards, *chosen]:
            try:
                link = _equation(card, nodes, axes) if card.name == "MPC" else kinds[card.name](card, nodes, axes)
            except MeshError:
                raise
            except InputError as error:
                raise MeshError(f"{card.where}: {error}") from None
            yield RawLink(card.where, link)


def _row(text: str, card: Card, nodes: Numbering) -> int:
    return int(nodes.rows(integers([natural(text, card.where)]), card.where)[0])


def _names(text: str, points: list[int], card: Card, axes: Axes) -> tuple[str, ...]:
    """Global directions of components of points, or MeshError if these have turned axes of their own."""
    found = {global_directions(components(text, card.where), axes(point), card.where) for point in points}
    if len(found) > 1:
        raise MeshError(f"{card.where}: expected points with the same displacement axes, got several; split the card")
    return found.pop()


def _points(card: Card, start: int, stop: int) -> list[int]:
    """Points of a list that may hold ranges from one THRU another, of which all must exist."""
    found = [n for one in ranges(card, card.fields[start - 1 : stop - 1]) for n in one.numbers(card)]
    if not found:
        raise MeshError(f"{card.where}: expected grid points, got none; list them, or remove the card")
    return list(dict.fromkeys(found))


def _without_expansion(card: Card) -> int:
    """Place behind the last field of a list, before a coefficient of expansion and its temperature: real numbers."""
    count = len(card.fields)
    while count and (not card.fields[count - 1] or "." in card.fields[count - 1]):
        count -= 1
    return count + 1


def _rbe2(card: Card, nodes: Numbering, axes: Axes) -> Link:
    points = _points(card, 4, _without_expansion(card))
    directions = _names(card.get(3), points, card, axes)
    return RigidLink(_row(card.get(2), card, nodes), nodes.rows(integers(points), card.where).tolist(), directions)


def _rbar(card: Card, nodes: Numbering, axes: Axes) -> Link:
    card.require_only(*range(1, 9))
    first, second = card.get(2), card.get(3)
    leads, follows = (card.get(4), card.get(5)), (card.get(6), card.get(7))
    if sorted(leads[0]) == list(_ALL) and not leads[1]:
        one, other, text = first, second, follows[1]
    elif sorted(leads[1]) == list(_ALL) and not leads[0]:
        one, other, text = second, first, follows[0]
    else:
        raise MeshError(
            f"{card.where}: expected 123456 independent at one end, got {shorten('/'.join(leads))}; write it as RBE2"
        )
    names = _names(text or _ALL, [natural(other, card.where)], card, axes)
    return RigidLink(_row(one, card, nodes), [_row(other, card, nodes)], names)


def _rbe1(card: Card, nodes: Numbering, axes: Axes) -> Link:
    words = [text.upper() for text in card.fields]
    split = words.index("UM") if "UM" in words else len(words)
    leads = [text for text in words[1:split] if text]
    follows = [text for text in words[split + 1 : _without_expansion(card) - 1] if text]
    if len(leads) != 2 or sorted(leads[1]) != list(_ALL) or not follows or len(follows) % 2:
        raise MeshError(
            f"{card.where}: expected one point with 123456 before UM and pairs of points and components behind it, got "
            f"{shorten(' '.join(words))}; write it as RBE2"
        )
    points = [natural(text, card.where) for text in follows[::2]]
    if len(set(follows[1::2])) > 1:
        raise MeshError(f"{card.where}: expected the same components of all points, got several; write it as RBE2")
    directions = _names(follows[1], points, card, axes)
    return RigidLink(_row(leads[0], card, nodes), nodes.rows(integers(points), card.where).tolist(), directions)


def _rbe3(card: Card, nodes: Numbering, axes: Axes) -> Link:
    reference, words = natural(card.get(3), card.where), [text.upper() for text in card.fields]
    stop = next((k for k, text in enumerate(words) if text in ("UM", "ALPHA")), len(words))
    if "UM" in words:
        raise MeshError(f"{card.where}: expected no UM, got one: only the reference follows; remove it")
    directions = _names(card.get(4), [reference], card, axes)
    weights, points, weight = list[float](), list[int](), 0.0
    place = 4
    while place < stop:
        text = card.fields[place]
        if "." in text:
            weight = real(text, card.where)
            given = card.fields[place + 1] if place + 1 < stop else ""
            if components(given, card.where) != {0, 1, 2}:
                raise MeshError(f"{card.where}: expected components 123 of what leads, got {shorten(given)}; write 123")
            place += 1
        elif text:
            points.append(natural(text, card.where))
            weights.append(weight)
        place += 1
    rows = nodes.rows(integers(points), card.where).tolist()
    return DistributingLink(_row(card.get(3), card, nodes), rows, tuple(weights), directions)


def _equation(card: Card, nodes: Numbering, axes: Axes) -> Link:
    """Three fields a term, two terms a line, the first field of each line but the first blank."""
    numbers, terms = dict[int, int](), list[tuple[int, int, float]]()
    for place in range(2, len(card.fields) + 1):
        if (place - 2) % 8 not in (0, 3) or not card.get(place):
            continue
        row, found = _row(card.get(place), card, nodes), components(card.get(place + 1), card.where)
        if len(found) != 1:
            raise MeshError(f"{card.where}: expected one component, got {shorten(card.get(place + 1))}; correct it")
        numbers[row] = natural(card.get(place), card.where)
        terms.append((row, found.pop(), real(card.get(place + 2), card.where)))
    return equation(terms, lambda row: axes(numbers[row]), card.where)
