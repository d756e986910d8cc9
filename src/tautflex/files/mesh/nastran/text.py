"""Text of a Nastran deck: lines to fields, fields to cards, before any card has a meaning."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from tautflex.errors import MeshError
from tautflex.files.mesh.include import Line
from tautflex.files.mesh.nastran.replication import Row, replicated
from tautflex.files.mesh.numerals import NUMBER
from tautflex.files.mesh.raw import shorten

_END = re.compile(r"\s*enddata\b", re.IGNORECASE)
_BEGINNING = re.compile(r"\s*include\b[\s,=]*", re.IGNORECASE)


@dataclass(frozen=True)
class Card:
    """Bulk data entry: its name and fields, continuation lines joined; ``wrong`` if it is not to be read so."""

    name: str
    fields: list[str]
    where: str
    wrong: str = ""

    def get(self, place: int) -> str:
        """Field number ``place`` from 1, "" if the card ends before."""
        return self.fields[place - 1] if place <= len(self.fields) else ""

    def require_right(self) -> None:
        """Raise MeshError if its lines are wrong."""
        if self.wrong:
            raise MeshError(self.wrong)

    def require_only(self, *places: int) -> None:
        """Raise MeshError if a field is filled, and not with zero, that is none of ``places``."""
        for place, text in enumerate(self.fields, start=1):
            if text and place not in places and text.strip("+-0.") != "":
                raise MeshError(
                    f"{self.where}: expected field {place + 1 + 2 * ((place - 1) // 8)} to be blank, got "
                    f"{shorten(text)}, which is not read here and may change the structure; remove it"
                )


def included(where: str, text: str, more: Iterator[Line]) -> str | None:
    """Name of the file of an INCLUDE statement, which may run over lines until its quotes close."""
    begun = _BEGINNING.match(text)
    if begun is None:
        return None
    name = text[begun.end() :].strip()
    quote = name[:1]
    if quote not in ("'", '"') or not quote:
        return name.partition("$")[0].strip()
    while quote not in name[1:]:
        line = next(more, None)
        if line is None:
            raise MeshError(f"{where}: expected {quote} at the end of the file's name, got none; close the quotes")
        name += line[1].strip()
    return name[1:].partition(quote)[0]


def cards(lines: Iterable[Line]) -> Iterator[Card]:
    """Cards of the bulk data, in the order of their first lines.

    A continuation belongs to the line before if that gives its mark, else to the one line that does, wherever it
    stands; without a mark, or if neither gives one, to the line before.
    """
    rows = replicated(_rows(lines))
    after = _continuations(rows)
    taken = {_bare(rows[number].head) for number in after.values()}
    seen = 0
    for number, row in enumerate(rows):
        if row.continues:
            continue
        name = row.head.strip("*").upper()
        fields, seen, line = list(row.fields), seen + 1, after.get(number)
        wrong = row.wrong or _lost(row, taken)
        while line is not None:
            own = rows[line]
            fields += [""] * (-len(fields) % (4 if own.large else 8)) + own.fields
            wrong = wrong or own.wrong or _lost(own, taken)
            seen += 1
            line = after.get(line)
        yield Card(name, fields, f"{row.where} ({shorten(name, 12)})", wrong)
    if seen < len(rows):
        stray = next(row for row in rows if row.continues)
        raise MeshError(f"{stray.where}: expected continuations of a card, got some that continue each other only")


def _continuations(rows: list[Row]) -> dict[int, int]:
    """Line that continues each line."""
    marked: dict[str, list[int]] = {}
    others: dict[str, list[int]] = {}
    for number, row in enumerate(rows):
        if row.mark:
            marked.setdefault(_bare(row.mark), []).append(number)
            others.setdefault(row.mark[1:].upper(), []).append(number)  # the first column of a mark is free
    after: dict[int, int] = {}
    for number, row in enumerate(rows):
        if not row.continues:
            continue
        own = _bare(row.head)
        before = number - 1
        found = marked.get(own) or others.get(own, [])
        if own and before not in found and (found or before < 0 or rows[before].mark):
            if len(found) != 1:
                got = "none" if not found else f"{len(found)} of them"
                raise MeshError(
                    f"{row.where}: expected one line that is continued by {shorten(row.head)}, got {got}; correct the "
                    "mark in its last field"
                )
            before = found[0]
        if before < 0:
            raise MeshError(f"{row.where}: expected a card, got a continuation; correct the line")
        if before in after:
            raise MeshError(f"{row.where}: expected one continuation of a line, got a second one; correct the marks")
        after[before] = number
    return after


def _lost(row: Row, taken: set[str]) -> str:
    """What is wrong with a number where the mark of a continuation stands, if nothing continues it."""
    if not NUMBER.fullmatch(row.mark) or _bare(row.mark) in taken:
        return ""
    return (
        f"{row.where}: expected at most 8 fields and a continuation mark, got {shorten(row.mark)} in the tenth; go on "
        "in a continuation line"
    )


def _bare(mark: str) -> str:
    return mark.lstrip("+*").strip().upper()


def _rows(lines: Iterable[Line]) -> Iterator[Row]:
    mark = ""
    for where, raw in lines:
        line = raw.partition("$")[0].rstrip().expandtabs(8)
        if not line.strip():
            continue
        if _END.match(line):
            return
        row = _row(line, where, mark)
        mark = row.mark
        yield row


def _row(line: str, where: str, mark: str) -> Row:
    """Name, fields and continuation mark of one line.

    Free format has commas or, where the name field alone would hold two words, blanks, unless these are in the ``mark``
    of the line before; large fields have a star in the first field, and are 4 instead of 8.
    """
    if "," in line:
        parts = [part.strip() for part in line.split(",")]
        if any(" " in part for part in parts):
            parts = [word for part in parts for word in (part.split() or [""])]
    elif (len(line[:8].split()) > 1 and not (mark and _bare(line[:8].rstrip()) == _bare(mark))) or re.match(
        r"=\(?\d", line
    ):
        parts = line.split()
    else:
        large = "*" in line[:8]
        width, count = (16, 4) if large else (8, 8)
        fields = [line[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]
        return Row(line[:8].strip(), fields, line[72:80].strip(), where, large)
    head, *rest = parts
    large = "*" in head and not head.startswith("=")
    most = 4 if large else 8
    wrong = ""
    if any(rest[most + 1 :]):
        wrong = (
            f"{where} ({shorten(head, 12)}): expected at most {most} fields and a continuation mark, got {len(rest)}; "
            "go on in a continuation line"
        )
    own = rest[most] if len(rest) > most else ""
    return Row(head, rest[:most] + [""] * (most - len(rest)), own, where, large, wrong)
