"""Equations between displacements."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from tautflex import checks
from tautflex.errors import InputError
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.link import Follows, Joined, Link
from tautflex.text import brief


@dataclass(frozen=True)
class LinkEquation(Link):
    """Sum of displacements times coefficients that stays zero; the first displacement follows the others.

    Parameters
    ----------
    terms
        Node number, direction (``"x", "y", "z", "rx", "ry", "rz"``) and coefficient of each, for example
        ``[(11, "y", 1.0), (6, "y", -1.0)]``.

    Raises
    ------
    InputError
        If there are no terms, a displacement stands twice, or the first coefficient is 0.
    """

    terms: Sequence[tuple[int, str, float]]
    kind: ClassVar[str] = "equation"
    __repr__ = brief

    def __post_init__(self) -> None:
        places = [(checks.whole("terms", node, 0), one) for node, one, _ in self._checked]
        if not places or len(set(places)) < len(places):
            raise InputError(f"terms: expected every displacement once, got {places}; add up its coefficients")
        if self.terms[0][2] == 0.0:
            raise InputError("terms: expected a first coefficient other than 0, got 0; begin with what shall follow")

    @property
    def _checked(self) -> list[tuple[int, str, float]]:
        terms = checks.several("terms", self.terms, (tuple, list), "(11, 'y', 1.0)")
        for term in terms:
            if len(term) != 3:
                raise InputError(f"terms: expected node, direction and coefficient, got {term!r}; write (11, 'y', 1.0)")
            checks.one_of("terms", term[1], DIRECTIONS)
            checks.finite("terms", term[2])
        return [tuple(term) for term in terms]

    @property
    def joined(self) -> tuple[int, ...]:
        """Numbers of all nodes that it names."""
        return tuple(dict.fromkeys(node for node, _, _ in self.terms))

    def follows(self, structure: Joined) -> Iterator[Follows]:
        """The first displacement from the others."""
        (node, direction, first), *rest = self.terms
        others = tuple(((int(n), DIRECTIONS.index(one)), -float(c) / first) for n, one, c in rest if c != 0.0)
        yield Follows((node, DIRECTIONS.index(direction)), others)
