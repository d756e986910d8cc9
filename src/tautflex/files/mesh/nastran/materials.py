"""Materials of a Nastran deck."""

from __future__ import annotations

from dataclasses import dataclass, field

from tautflex.errors import MeshError
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, real, vector
from tautflex.files.mesh.raw import shorten

MATERIALS = ("MAT1", "MAT2", "MAT3", "MAT8", "MAT9", "MAT10", "MATHP", "MATPOR")
_CONSISTENT = 1e-3  # of G = E / (2 (1 + nu)): decks round it


@dataclass
class Materials:
    """Material cards by number."""

    cards: dict[int, Card] = field(default_factory=dict)

    def read(self, card: Card) -> None:
        """Keep a card; MeshError if its number is taken."""
        number = natural(card.get(1), card.where)
        if number in self.cards:
            raise MeshError(f"{card.where}: material {number} is defined twice; give it its own number")
        self.cards[number] = card

    def expansion(self, number: str, where: str) -> tuple[float, float]:
        """Coefficient of expansion and temperature of reference of a MAT1; MeshError if it is none."""
        card = self.cards.get(natural(number, where)) if number else None
        if card is None or card.name != "MAT1":
            raise MeshError(
                f"{where}: expected a MAT1 beside temperatures, got material {shorten(number)}; state the prestress in "
                "the case, and leave TEMPERATURE out of the case control"
            )
        expansion, reference = vector([card.get(6), card.get(7)], card.where).tolist()
        return expansion, reference

    def values(self, number: str, kind: str, where: str) -> tuple[dict[str, float], str]:
        """Modulus, ratio and density of a material for elements of a kind, and why they are not all it says.

        Of modulus E, shear modulus G and ratio nu two make the third. Lines need E and G only; if all three are given
        of a beam, the ratio is that of E and G.
        """
        if number in ("", "0"):
            return {}, ""
        card = self.cards.get(natural(number, where))
        if card is None:
            return {}, f"material {number} is not there"
        if card.name != "MAT1":
            return {}, f"its material {number} is a {card.name}, expected the isotropic MAT1"
        young, shear, ratio = (real(card.get(place), card.where) for place in (2, 3, 4))
        found = {"density": real(card.get(5), card.where)}
        stated = [bool(card.get(place)) for place in (2, 3, 4)]
        if not stated[0] and stated[1] and stated[2]:
            young = 2.0 * shear * (1.0 + ratio)
        if young > 0.0 and shear > 0.0 and (kind == "beam" or not stated[2]):
            ratio, stated[2] = 0.5 * young / shear - 1.0, True
        if young:
            found["youngs_modulus"] = young
        if stated[2]:
            found["poisson_ratio"] = ratio
        doubt = ""
        if kind == "membrane" and stated[1] and abs(2.0 * shear * (1.0 + ratio) - young) > _CONSISTENT * abs(young):
            doubt = f"G = {shear:g} of MAT1 {number} is not E / (2 (1 + nu))"
        return {name: value for name, value in found.items() if name != "density" or value}, doubt
