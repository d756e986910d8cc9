"""Lists of numbers on cards of Nastran, with ranges from one THRU another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural

_MOST = 1_000_000


class Range(NamedTuple):
    """Numbers from the first to the last in steps; ``listed`` if it is one number that stands there by itself."""

    first: int
    last: int
    step: int
    listed: bool

    def numbers(self, card: Card) -> range:
        """All of them; MeshError if there are too many."""
        if not self.first <= self.last < self.first + _MOST:
            raise MeshError(f"{card.where}: expected first THRU last, got {self.first} THRU {self.last}; correct them")
        return range(self.first, self.last + 1, self.step)


def ranges(card: Card, listed: Iterable[str]) -> Iterator[Range]:
    """Ranges of a list, blanks left out: numbers, ``first THRU last``, ``first THRU last BY step``."""
    words = [text.upper() for text in listed if text]
    while words:
        first = natural(words[0], card.where)
        if words[1:2] != ["THRU"] or len(words) < 3:
            yield Range(first, first, 1, True)
            words = words[1:]
            continue
        last, step, words = natural(words[2], card.where), 1, words[3:]
        if words[:1] == ["BY"] and len(words) > 1:
            step, words = natural(words[1], card.where), words[2:]
        yield Range(first, last, step, False)
