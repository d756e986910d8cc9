"""Coordinate systems of a Nastran deck, resolved when a point or a direction needs them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, vector
from tautflex.files.mesh.raw import shorten
from tautflex.files.mesh.systems import System
from tautflex.numeric import Array

_DEEPEST = 50


BASIC = System("R", np.zeros(3), np.eye(3))


class Systems:
    """All systems of a deck by number; a damaged one that nothing uses costs nothing.

    Parameters
    ----------
    point
        Position of a grid point in basic coordinates, for systems that are defined by points.
    """

    def __init__(self, point: Callable[[int, str], Array]) -> None:
        self._point = point
        self._cards: dict[int, tuple[Card, int]] = {}
        self._ready: dict[int, System] = {0: BASIC}
        self._open: list[int] = []

    def add(self, card: Card) -> None:
        """Keep the definition of one system, or of the two of a CORD1 card."""
        starts = (1, 5) if card.name.startswith("CORD1") and card.get(5) else (1,)
        for start in starts:
            number = natural(card.get(start), card.where)
            if number in self._cards:
                raise MeshError(f"{card.where}: coordinate system {number} is defined twice; give it its own number")
            self._cards[number] = card, start

    def named(self, text: str, where: str) -> System:
        """System of a field, blank and 0 being basic."""
        return self.get(0 if text in ("", "0") else natural(text, where), where)

    def get(self, number: int, where: str) -> System:
        """System of a number; MeshError if it is not defined, or by itself."""
        if number in self._ready:
            return self._ready[number]
        if number not in self._cards:
            raise MeshError(f"{where}: expected an existing coordinate system, got {number}; define it by CORD2R")
        if number in self._open or len(self._open) >= _DEEPEST:
            raise MeshError(f"{where}: expected a coordinate system defined by others, got {number} by itself")
        self._open.append(number)
        self._ready[number] = self._defined(*self._cards[number])
        self._open.pop()
        return self._ready[number]

    def _defined(self, card: Card, start: int) -> System:
        if card.name.startswith("CORD1"):
            corners = [self._point(natural(card.get(start + k), card.where), card.where) for k in (1, 2, 3)]
        else:
            card.require_only(*range(1, 12))
            other = self.named(card.get(2), card.where)
            given = vector([card.get(k) for k in range(3, 12)], card.where).reshape(3, 3)
            corners = [other.position(place) for place in given]
        origin, on_z, in_xz = corners
        along, across = on_z - origin, in_xz - origin
        y = np.cross(along, across)
        if not np.linalg.norm(y) > 1e-9 * np.linalg.norm(along) * np.linalg.norm(across):
            raise MeshError(
                f"{card.where}: expected three points that are not on a line, got {shorten(str(corners))}; correct them"
            )
        z, y = along / np.linalg.norm(along), y / np.linalg.norm(y)
        return System(card.name[-1], origin, np.array([np.cross(y, z), y, z]))
