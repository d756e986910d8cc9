"""What a person sees of the reproduction: each table ours | paper | difference, then the scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from tautflex.cli.cards import list_files, say

if TYPE_CHECKING:
    from tautflex.paper.tables.rows import Row

_GOOD, _FAIR = 0.05, 0.20  # relative differences shown green and yellow
_WORDS = {
    "published": "published reading, m2-paper",
    "nearest-node": "first reading, m2-nearest-node",
    "consistent": "consistent variant, m2",
}


def show_comparison(
    rows: Mapping[tuple[str, str], Sequence[Row]], summary: Sequence[Row], files: Mapping[str, Path]
) -> None:
    """Print every table, the scores, and where the files are."""
    for (variant, number), table in rows.items():
        _show_table(variant, number, table)
    if summary:
        _show_scores(summary)
    list_files(files)


def _show_table(variant: str, number: str, rows: Sequence[Row]) -> None:
    from tautflex.paper.tables import published

    title = f"Table {number}: {published.about(int(number))['title']}" if number.isdigit() else number.capitalize()
    compared = any(row.paper is not None for row in rows)
    table = Table(title=f"{title} ({_WORDS[variant]})", title_style="bold", title_justify="left")
    table.add_column("case", overflow="fold")
    table.add_column("quantity", overflow="fold")
    for name in ("ours", "paper", "difference") if compared else ("ours",):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    notes = list(dict.fromkeys(row.note for row in rows if row.note))
    if notes:
        table.add_column("note", justify="right")
    for row in rows:
        numbers = (_number(row.ours), _number(row.paper), _difference(row)) if compared else (_number(row.ours),)
        unit = "" if row.unit == "1" else row.unit
        mark = [str(notes.index(row.note) + 1) if row.note else ""] if notes else []
        table.add_row(row.case, row.quantity, *numbers, unit, *mark)
    Console().print(table)
    for k, note in enumerate(notes, start=1):
        say(f"  {k}: {note}")


def _show_scores(summary: Sequence[Row]) -> None:
    table = Table(title="Agreement with the paper", title_style="bold", title_justify="left")
    for name in ("variant", "over", "measure"):
        table.add_column(name, overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    for row in summary:
        value = f"{row.ours:.3f}" + (f" {row.unit}" if row.unit != "1" else "")
        table.add_row(_WORDS[row.variant], row.note, row.quantity, value)
    Console().print(table)


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.4f}" if 0.01 <= abs(value) < 1e4 else f"{value:.4g}"


def _difference(row: Row) -> str:
    if row.difference is None:
        return ""
    size = abs(row.difference)
    color = "green" if size <= _GOOD else "yellow" if size <= _FAIR else "red"
    return f"[{color}]{100 * row.difference:+.1f} %[/{color}]"
