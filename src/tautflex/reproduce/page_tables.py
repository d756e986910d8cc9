"""Rows of the comparison as tables of the page, and the measures of agreement taken from them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from tautflex.reproduce.page_blocks import Cell, Table, gap_cell, quantity_text

if TYPE_CHECKING:
    from tautflex.reproduce.tables import Row

Rows = Mapping[str, "Sequence[Row]"]

RESPONSE_TABLES = ("6", "7", "8", "9")
CONSISTENT = " consistent"
"""Ending of the key under which a table of the consistent variant stands."""
_WIDEST = 9  # columns of a table whose quantities stand side by side


def difference(row: Row) -> float | None:
    """Return ours relative to the paper's less 1, or None where the paper prints no number."""
    if row.paper is None or row.ours is None or not row.paper or math.isnan(row.ours):
        return None
    return row.ours / row.paper - 1.0


def responses(rows: Rows, unit: str, suffix: str = "") -> list[Row]:
    """List the rows of Tables 6 to 9 in Hz or mm that are results; a run printed twice counts once."""
    found: dict[tuple[float | None, float | None], Row] = {}
    for number in RESPONSE_TABLES:
        for row in rows.get(number + suffix, ()):
            if row.unit == unit and "fundamental" not in row.quantity and difference(row) is not None:
                found.setdefault((row.paper, row.ours), row)
    return list(found.values())


def mean_log_ratio(rows: Sequence[Row]) -> float:
    """Return the mean of |log(ours/paper)|; NaN without rows."""
    values = [abs(math.log(row.ours / row.paper)) for row in rows if row.paper and row.ours and row.ours > 0.0]
    return sum(values) / len(values) if values else math.nan


def mean_difference(rows: Sequence[Row]) -> float:
    """Return the mean of the relative differences' sizes; NaN without rows."""
    values = [abs(gap) for row in rows if (gap := difference(row)) is not None]
    return sum(values) / len(values) if values else math.nan


def comparison(rows: Sequence[Row], consistent: Sequence[Row] = ()) -> Table:
    """Return ours | paper | difference, the consistent variant beside it where there is one, and notes."""
    other = {(row.case, row.quantity): row for row in consistent}
    notes = any(row.note for row in rows)
    header = ["case", "quantity", "ours", "paper", "difference"]
    header += ["consistent variant", "its difference"] * bool(other) + ["note"] * notes
    lines = []
    for row in rows:
        line = [Cell(row.case), Cell(_named(row.quantity, row.unit)), _number(row.ours, row.unit)]
        line += [_number(row.paper, row.unit), gap_cell(difference(row))]
        if other:
            beside = other.get((row.case, row.quantity))
            line.append(_number(beside.ours if beside else None, row.unit))
            line.append(gap_cell(difference(beside) if beside else None))
        lines.append(tuple(line + [Cell(row.note)] * notes))
    return Table(tuple(header), tuple(lines))


def listing(rows: Sequence[Row]) -> Table:
    """Return results that the paper does not print: one line per case, quantities side by side if they fit."""
    quantities = list(dict.fromkeys((row.quantity, row.unit) for row in rows))
    cases = list(dict.fromkeys(row.case for row in rows))
    if len(quantities) >= _WIDEST or len(cases) == len(rows):
        return _long_listing(rows)
    value = {(row.case, row.quantity, row.unit): row.ours for row in rows}
    notes = {
        case: "; ".join(dict.fromkeys(row.note for row in rows if row.case == case and row.note)) for case in cases
    }
    told = any(notes.values())
    lines = [
        (Cell(case), *(_number(value.get((case, *key)), key[1]) for key in quantities), *[Cell(notes[case])] * told)
        for case in cases
    ]
    header = ("case", *(_named(*key) for key in quantities), *["note"] * told)
    return Table(header, tuple(lines))


def _long_listing(rows: Sequence[Row]) -> Table:
    notes = any(row.note for row in rows)
    lines = [
        (Cell(row.case), Cell(_named(row.quantity, row.unit)), _number(row.ours, row.unit), *[Cell(row.note)] * notes)
        for row in rows
    ]
    return Table(("case", "quantity", "ours", *["note"] * notes), tuple(lines))


def _named(quantity: str, unit: str) -> str:
    return f"{quantity} [{unit}]" if unit and unit != "1" else quantity


def _number(value: float | None, unit: str) -> Cell:
    return Cell(quantity_text(value, unit), number=True)
