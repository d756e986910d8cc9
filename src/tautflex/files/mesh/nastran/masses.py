"""Point masses of a Nastran deck."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.coordinates import Systems
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import finite, natural, real, vector
from tautflex.files.mesh.raw import RawMass, shorten
from tautflex.numeric import Array, cross_matrix

MASSES = ("CONM1", "CONM2", "CMASS1", "CMASS2", "PMASS", "PARAM")
_LOWER = np.tril_indices(6)
_SQUARE = 1e-9
_SCALES = ("CK1", "CM1")  # of all stiffness, of all mass


@dataclass
class Masses:
    """What CONM1, CONM2, CMASS1, CMASS2, PMASS and PARAM cards have brought."""

    cards: list[Card] = field(default_factory=list)
    properties: dict[int, float] = field(default_factory=dict)
    factor: float | None = None

    def read(self, card: Card) -> None:
        """Keep a card; of parameters WTMASS, the factor of all masses. MeshError if others scale the structure."""
        if card.name == "PMASS":
            card.require_only(*range(1, 9))
            for place in (1, 3, 5, 7):
                if card.get(place):
                    number = natural(card.get(place), card.where)
                    if number in self.properties:
                        raise MeshError(f"{card.where}: property {number} is defined twice; give it its own number")
                    self.properties[number] = finite(card.get(place + 1), card.where)
        elif card.name != "PARAM":
            self.cards.append(card)
        elif card.get(1).upper() == "WTMASS":
            factor = real(card.get(2), card.where)
            if not 0.0 < factor < np.inf:
                raise MeshError(f"{card.where}: expected a factor > 0, got {factor:g}; correct it")
            if self.factor not in (None, factor):
                raise MeshError(f"{card.where}: expected one WTMASS, got {self.factor:g} before; remove one")
            self.factor = factor
        elif card.get(1).upper() in _SCALES and real(card.get(2), card.where) != 1.0:
            raise MeshError(
                f"{card.where}: expected no factor of the whole structure, got {card.get(1).upper()} = "
                f"{shorten(card.get(2))}, which is not read here; scale the materials"
            )

    def bodies(
        self, systems: Systems, point: Callable[[int, str], Array], axes: Callable[[int], Array | None]
    ) -> list[tuple[int, RawMass]]:
        """Bodies by grid point, their masses times WTMASS.

        ``point`` and ``axes`` are positions of grid points and the directions of their displacement systems.
        """
        found: list[tuple[int, RawMass]] = []
        single: dict[int, Array] = {}
        for card in self.cards:
            if card.name == "CONM2":
                found.append(_conm2(card, systems, point))
            elif card.name == "CONM1":
                found.append(_conm1(card, systems, point))
            else:
                self._direction(card, single)
        for number, values in single.items():
            where = f"CMASS of grid point {number}"
            turn = axes(number)
            if np.ptp(values[:3]) > _SQUARE * values[:3].max():
                raise MeshError(
                    f"{where}: expected the same mass along all three directions, got {values[:3].tolist()}; one that "
                    "depends on the direction is not read here"
                )
            inertia = np.diag(values[3:])
            inertia = inertia if turn is None else turn.T @ inertia @ turn
            found.append((number, RawMass(where, float(values[0]), inertia, np.zeros(3))))
        factor = self.factor or 1.0
        return [
            (number, replace(body, mass=factor * body.mass, inertia=factor * body.inertia)) for number, body in found
        ]

    def _direction(self, card: Card, single: dict[int, Array]) -> None:
        """Add the mass that a CMASS1 or CMASS2 card has in one direction of a point."""
        card.require_only(1, 2, 3, 4)
        value = finite(card.get(2), card.where)
        if card.name == "CMASS1":
            number = natural(card.get(2) or card.get(1), card.where)
            if number not in self.properties:
                raise MeshError(f"{card.where}: expected a PMASS {number}, got none; add it")
            value = self.properties[number]
        direction = natural(card.get(4), card.where)
        if direction > 6:
            raise MeshError(f"{card.where}: expected a component from 1 to 6, got {direction}; correct the card")
        single.setdefault(natural(card.get(3), card.where), np.zeros(6))[direction - 1] += value


def _conm2(card: Card, systems: Systems, point: Callable[[int, str], Array]) -> tuple[int, RawMass]:
    """Mass with an inertia about its centre; products of inertia are written without their minus sign."""
    card.require_only(*range(1, 8), *range(9, 15))
    number = natural(card.get(2), card.where)
    place = point(number, card.where)
    offset = vector([card.get(k) for k in (5, 6, 7)], card.where)
    xx, yx, yy, zx, zy, zz = vector([card.get(k) for k in range(9, 15)], card.where, largest=1e300)
    inertia = np.array([[xx, -yx, -zx], [-yx, yy, -zy], [-zx, -zy, zz]])
    if card.get(3) == "-1":  # the centre itself, in basic coordinates
        offset = offset - place
    else:
        turn = systems.named(card.get(3), card.where).directions(place)
        offset, inertia = offset @ turn, turn.T @ inertia @ turn
    return number, RawMass(card.where, real(card.get(4), card.where), inertia, offset)


def _conm1(card: Card, systems: Systems, point: Callable[[int, str], Array]) -> tuple[int, RawMass]:
    """A 6 x 6 matrix, which must be that of a rigid body."""
    card.require_only(*range(1, 25))
    number = natural(card.get(2), card.where)
    matrix = np.zeros((6, 6))
    matrix[_LOWER] = vector([card.get(k) for k in range(4, 25)], card.where, largest=1e100)
    matrix = np.tril(matrix) + np.tril(matrix, -1).T
    mass = matrix[0, 0]
    lever = matrix[3:, :3] / mass if mass > 0.0 else matrix[3:, :3]
    offset = 0.5 * np.array([lever[2, 1] - lever[1, 2], lever[0, 2] - lever[2, 0], lever[1, 0] - lever[0, 1]])
    rigid = np.block([[mass * np.eye(3), mass * cross_matrix(offset).T], [mass * cross_matrix(offset), matrix[3:, 3:]]])
    if not np.allclose(matrix, rigid, rtol=0.0, atol=_SQUARE * np.abs(matrix).max()):
        raise MeshError(f"{card.where}: expected the matrix of a rigid body, got another; write it as CONM2")
    inertia = matrix[3:, 3:] - mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    turn = systems.named(card.get(3), card.where).directions(point(number, card.where))
    return number, RawMass(card.where, mass, turn.T @ inertia @ turn, offset @ turn)
