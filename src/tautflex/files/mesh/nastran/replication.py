"""Nastran's shorthand for lines that are like the line before."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from tautflex.errors import MeshError
from tautflex.files.mesh.numerals import real
from tautflex.files.mesh.raw import shorten

_COUNT = re.compile(r"=\(?(\d{1,9})\)?")
_STEP = re.compile(r"\*\(?([^()]+)\)?")
_MOST = 2_000_000


class Row(NamedTuple):
    """One line in fields: ``head`` is its first field, ``mark`` the name it gives the line that continues it.

    ``wrong`` is what is wrong with it if its card is read.
    """

    head: str
    fields: list[str]
    mark: str
    where: str
    large: bool
    wrong: str = ""

    @property
    def continues(self) -> bool:
        """Whether this line continues another."""
        return self.head[:1] in ("", "+", "*")


def replicated(rows: Iterable[Row]) -> list[Row]:
    """Lines written out: ``=`` repeats a field of the line before, ``==`` all that follow, ``*(x)`` adds x.

    A line ``=(n)`` repeats the last such line n times more. Lines of cards that are continued cannot be repeated.
    """
    found: list[Row] = []
    pattern: Row | None = None
    for row in rows:
        if not row.head.startswith("="):
            found.append(row)
            pattern = None
            continue
        times = _COUNT.fullmatch(row.head)
        if times is None and row.head != "=":
            raise MeshError(f"{row.where}: expected '=' or '=(count)', got {shorten(row.head)}; write the card out")
        if times is None:
            pattern = row
        if pattern is None or not found or found[-1].continues or found[-1].mark:
            raise MeshError(f"{row.where}: expected a card on one line to repeat, got none before; write the card out")
        count = 1 if times is None else int(times[1])
        if len(found) + count > _MOST:
            raise MeshError(f"{row.where}: expected at most {_MOST} lines by repetition, got more; repeat less")
        for _ in range(count):
            found.append(_next(found[-1], pattern))
    return found


def _next(before: Row, pattern: Row) -> Row:
    return before._replace(fields=list(_fields(before, pattern)), where=pattern.where)


def _fields(before: Row, pattern: Row) -> Iterator[str]:
    given = iter(pattern.fields)
    rest = False
    for old in before.fields:
        new = "" if rest else next(given, "")
        rest = rest or new == "=="
        step = _STEP.fullmatch(new)
        if rest or new == "=":
            yield old
        elif step is not None:
            yield _sum(old, step[1], pattern.where)
        else:
            yield new


def _sum(old: str, step: str, where: str) -> str:
    """Sum of two numbers as text, an integer if both are."""
    if re.fullmatch(r"[+-]?\d{1,18}", old) and re.fullmatch(r"[+-]?\d{1,18}", step):
        return str(int(old) + int(step))
    return repr(real(old, where) + real(step, where))
