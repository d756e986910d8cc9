"""Points of a study: which values each has, and its case; those of a grid, or a list of cases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from tautflex.case.reading import parse_case
from tautflex.case.schema import Case
from tautflex.case.section import Section
from tautflex.study.axes import steps_of, with_keys
from tautflex.study.reading import base_values
from tautflex.study.sections import Study


class Points(Protocol):
    """Numbered points, each with a case; other processes can be sent them."""

    def __len__(self) -> int: ...

    def case(self, number: int) -> Case:
        """Case of a point; CaseError if it is not valid."""

    def name(self, number: int) -> str:
        """Point in words."""


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of the axes of a study, the last axis fastest.

    Parameters
    ----------
    base
        Tables of the case that the study starts from.
    steps
        Keys and values that each group of axes sets at each of its values.
    """

    base: dict[str, Any]
    steps: list[list[dict[str, Any]]]

    @classmethod
    def of(cls, study: Study) -> Grid:
        """Points of a study; CaseError if its case cannot be read."""
        return cls(base_values(study), steps_of(study))

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each group of axes."""
        return tuple(len(values) for values in self.steps)

    @cached_property
    def start(self) -> Case:
        """Case that the study starts from."""
        return Case(**self.base)

    @cached_property
    def _sections(self) -> dict[str, Any]:
        """Sections of the base that no point need check again; its prestress has defaults that depend on others."""
        case = self.start
        return {
            name: own
            for name in self.base
            if isinstance(own := getattr(case, name, None), Section) and name != "prestress"
        }

    def __len__(self) -> int:
        return math.prod(self.shape)

    def values(self, number: int) -> dict[str, Any]:
        """Keys and values of a point."""
        found: dict[str, Any] = {}
        for values in reversed(self.steps):
            number, place = divmod(number, len(values))
            found = values[place] | found
        return found

    def case(self, number: int) -> Case:
        """Case of a point; CaseError if it is not valid."""
        values = self.values(number)
        same = self._sections.keys() - {key.partition(".")[0] for key in values}
        return Case(**with_keys(self.base, values) | {name: self._sections[name] for name in same})

    def name(self, number: int) -> str:
        """Point in words."""
        return ", ".join(f"{key} = {value!r}" for key, value in self.values(number).items()) or "the case itself"


@dataclass(frozen=True)
class Listing:
    """Cases by name."""

    names: Sequence[str]
    texts: Sequence[str]
    """Their case files: cheap to send."""

    def __len__(self) -> int:
        return len(self.names)

    def case(self, number: int) -> Case:
        """Case of a point."""
        return parse_case(self.texts[number])

    def name(self, number: int) -> str:
        """Its name."""
        return self.names[number]
