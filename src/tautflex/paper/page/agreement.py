"""Rows of the comparison as tables of the page, and the measures of agreement taken from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from tautflex.paper.page.markdown import marked, quantity_text, symbols, table
from tautflex.paper.tables.rows import Row

Rows: TypeAlias = Mapping[str, Sequence[Row]]

RESPONSE_TABLES = ("6", "7", "8", "9")
CONSISTENT, NEAREST_NODE = " consistent", " nearest-node"
"""Endings of the key under which a table of the consistent variant and of the first reading stands."""


def sorted_rows(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Return rows by table, those beside the published reading under ``"6 consistent"`` and the like."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.table if row.variant == "published" else f"{row.table} {row.variant}", []).append(row)
    return found


def responses(rows: Rows, quantity: str, suffix: str = "", tables: Sequence[str] = RESPONSE_TABLES) -> list[Row]:
    """List the rows of Tables 6 to 9 that compare ``"response frequency"`` or ``"amplitude"``, repeated ones too."""
    listed = [row for number in tables for row in rows.get(number + suffix, ())]
    return [row for row in listed if row.quantity == quantity and gap(row) is not None]


def gap(row: Row) -> float | None:
    """Return the relative difference of a measured quantity; None for a number that only names something."""
    return None if row.unit == "1" else row.difference


def both(row: Row) -> str:
    """Return ours and the paper's value in words."""
    return f"ours {quantity_text(row.ours, row.unit)} {row.unit}, paper {quantity_text(row.paper, row.unit)} {row.unit}"


def comparison(rows: Sequence[Row], others: Mapping[str, Sequence[Row]] | None = None) -> str:
    """Return ours | paper | difference, other variants by their headings beside it, and notes.

    A quantity that all rows share stands in the header.
    """
    beside = {name: {(row.case, row.quantity): row for row in found} for name, found in (others or {}).items()}
    quantities = {_named(row.quantity, row.unit) for row in rows}
    mixed = len(quantities) > 1
    notes = any(row.note for row in rows)
    header = ["case", "quantity"] if mixed else [f"{next(iter(quantities))} of"]
    header += ["ours", "paper", "difference", *(word for name in beside for word in (name, "difference"))]
    header += ["note"] * notes
    lines = []
    for row in rows:
        line = [symbols(row.case), *[_named(row.quantity, row.unit)] * mixed]
        line += [quantity_text(row.ours, row.unit), quantity_text(row.paper, row.unit), marked(gap(row))]
        for other in (found.get((row.case, row.quantity)) for found in beside.values()):
            line.append(quantity_text(other.ours if other else None, row.unit))
            line.append(marked(gap(other) if other else None))
        lines.append([*line, *[symbols(row.note)] * notes])
    return table(header, lines)


def listing(rows: Sequence[Row]) -> list[str]:
    """Return results that the paper does not print: a line per case, a column per quantity.

    Cases that begin with different quantities tell different things and stand in different tables.
    """
    by_case: dict[str, list[Row]] = {}
    for row in rows:
        by_case.setdefault(row.case, []).append(row)
    groups: dict[str, list[list[Row]]] = {}
    for line in by_case.values():
        groups.setdefault(line[0].quantity, []).append(line)
    return [_wide(lines) for lines in groups.values()]


def _wide(lines: Sequence[Sequence[Row]]) -> str:
    """Lines of rows, each of one case; a unit that all share stands in the header, else in the cell."""
    units: dict[str, set[str]] = {}
    for row in (row for line in lines for row in line):
        units.setdefault(row.quantity, set()).add(row.unit)
    shared = {quantity: next(iter(found)) if len(found) == 1 else "" for quantity, found in units.items()}
    told = any(row.note for line in lines for row in line)
    body = []
    for line in lines:
        cells = {row.quantity: _number(row, with_unit=not shared[row.quantity]) for row in line}
        notes = "; ".join(dict.fromkeys(row.note for row in line if row.note))
        body.append([symbols(line[0].case), *(cells.get(quantity, "") for quantity in units), *[symbols(notes)] * told])
    header = ["case", *(_named(quantity, shared[quantity]) for quantity in units), *["note"] * told]
    return table(header, body)


def _named(quantity: str, unit: str) -> str:
    return symbols(f"{quantity} [{unit}]" if unit and unit != "1" else quantity)


def _number(row: Row, with_unit: bool) -> str:
    text = quantity_text(row.ours, row.unit)
    return f"{text} {row.unit}" if with_unit and row.ours is not None and row.unit != "1" else text
