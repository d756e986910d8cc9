"""Temperatures and given deformations of a Nastran deck, as the strain that elements would take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.case_control import Selection
from tautflex.files.mesh.nastran.elements import Elements, section_kind
from tautflex.files.mesh.nastran.properties import Properties
from tautflex.files.mesh.nastran.ranges import ranges
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import finite, natural
from tautflex.numeric import Array

TEMPERATURES = ("TEMP", "TEMPD", "TEMPP1", "TEMPRB", "DEFORM", "MATT1", "MATT2", "MATT8", "MATT9")
_LARGEST = 1e9


@dataclass
class Temperatures:
    """What TEMP, TEMPD, TEMPP1, TEMPRB, DEFORM and MATTi cards say; those of sets not selected are not looked at."""

    cards: list[Card] = field(default_factory=list)

    def read(self, card: Card) -> None:
        """Keep a card."""
        self.cards.append(card)

    def strain(
        self, selection: Selection, elements: Elements, properties: Properties, lengths: Array
    ) -> dict[str, Array] | None:
        """Strain of free elements by shape, None where the case control selects neither temperatures nor deformations.

        It is the expansion of the material times the temperature of ``TEMPERATURE(LOAD)``, the mean over the element's
        points, above that of ``TEMPERATURE(INITIAL)`` or else of the material; DEFORM is an elongation. ``lengths`` are
        those of the lines, shape (line,).
        """
        warm, cold, given = (
            selection.sets[word] or None for word in ("TEMPERATURE(LOAD)", "TEMPERATURE(INITIAL)", "DEFORM")
        )
        if warm or selection.sets["TEMPERATURE(MATERIAL)"]:
            self._require_constants()
        if not warm and not given:
            return None
        found = {shape: np.zeros(len(own)) for shape, own in elements.elements.items()}
        if warm:
            now = self._field(warm, "LOAD")
            before = self._field(cold, "INITIAL") if cold else None
            for shape, row, kind, number in elements.owners():
                line = elements.elements[shape][row]
                where = f"element {line[0]}"
                expansion, reference = properties.expansion(number, section_kind(kind), where)
                if expansion:
                    if before is not None and reference:
                        raise MeshError(
                            f"{where}: expected a blank TREF of its material beside TEMPERATURE(INITIAL), got "
                            f"{reference:g}; leave one of them out"
                        )
                    start = reference if before is None else before(line)
                    found[shape][row] = expansion * (now(line) - start)
        if given:
            lines = {line[0]: row for row, line in enumerate(elements.elements["line2"])}
            for element, card, text in self._pairs("DEFORM", given):
                if element not in lines:
                    raise MeshError(f"{card.where}: expected rods, bars or beams, got element {element}; correct it")
                row = lines[element]
                if lengths[row] > 0.0:  # one without length is refused when the mesh is checked
                    found["line2"][row] += finite(text, card.where, _LARGEST) / lengths[row]
        return found

    def _require_constants(self) -> None:
        for card in self.cards:
            if card.name.startswith("MATT"):
                raise MeshError(
                    f"{card.where}: expected materials that do not depend on the temperature which the case control "
                    "selects, got one; write what holds at it on the material card"
                )

    def _pairs(self, name: str, number: int) -> list[tuple[int, Card, str]]:
        """Numbers and values of the cards of a set, three pairs each."""
        found = []
        for card in self.cards:
            if card.name == name and natural(card.get(1), card.where) == number:
                card.require_only(*range(1, 8))
                places = [place for place in (2, 4, 6) if card.get(place)]
                found += [(natural(card.get(place), card.where), card, card.get(place + 1)) for place in places]
        if not found and name == "DEFORM":
            raise MeshError(f"expected set {number}, which DEFORM = {number} selects, got none; add its DEFORM")
        return found

    def _field(self, number: int, what: str) -> Callable[[Sequence[int]], float]:
        """Temperature of an element, given its number and those of its points, in a set."""
        points, own, everywhere = dict[int, float](), dict[int, float](), dict[int, float]()
        for point, card, text in self._pairs("TEMP", number):
            _keep(points, point, finite(text, card.where, _LARGEST), card)
        for card in self.cards:
            if card.name == "TEMPD":
                for place in (1, 3, 5, 7):
                    if card.get(place) and natural(card.get(place), card.where) == number:
                        _keep(everywhere, number, finite(card.get(place + 1), card.where, _LARGEST), card)
            elif card.name in ("TEMPP1", "TEMPRB") and natural(card.get(1), card.where) == number:
                for element in _listed(card):
                    _keep(own, element, _mean(card), card)
        if not points and not everywhere and not own:
            raise MeshError(
                f"expected set {number}, which TEMPERATURE({what}) = {number} selects, got none; add its TEMP"
            )

        def mean(line: Sequence[int]) -> float:
            if line[0] in own:
                return own[line[0]]
            values = [points.get(point, everywhere.get(number)) for point in line[1:]]
            if None in values:
                point = line[1 + values.index(None)]
                raise MeshError(
                    f"element {line[0]}: expected a temperature of its grid point {point} in set {number}, got none; "
                    "add TEMPD"
                )
            return float(np.mean(np.array(values, dtype=float)))

        return mean


def _keep(temperatures: dict[int, float], number: int, value: float, card: Card) -> None:
    """Keep a temperature; MeshError if there is another one of the same."""
    if temperatures.setdefault(number, value) != value:
        raise MeshError(
            f"{card.where}: expected one temperature of {number} in a set, got {temperatures[number]:g} and {value:g}; "
            "remove one"
        )


def _mean(card: Card) -> float:
    """Mean temperature of a film, whose gradient bends nothing, or of a beam, which must have none across it."""
    if card.name == "TEMPP1":
        return finite(card.get(3), card.where, _LARGEST)
    if any(text and finite(text, card.where, _LARGEST) for text in card.fields[4:16]):
        raise MeshError(
            f"{card.where}: expected temperatures of both ends, got gradients, which are not read here; leave them out"
        )
    return 0.5 * (finite(card.get(3), card.where, _LARGEST) + finite(card.get(4), card.where, _LARGEST))


def _listed(card: Card) -> list[int]:
    """Elements of a card: its first one, and those listed or ranging behind its values."""
    rest = card.fields[8 if card.name == "TEMPP1" else 16 :]
    return [number for one in ranges(card, [card.get(2), *rest]) for number in one.numbers(card)]
