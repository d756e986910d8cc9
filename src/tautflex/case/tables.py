"""Tables in case files: motion and inputs over time, in CSV files or written out."""

from __future__ import annotations

import csv
import math
from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Self

import numpy as np
from pydantic import Strict, model_validator

from tautflex.case.section import Number, Section, key
from tautflex.errors import CaseError
from tautflex.files.content import read_text
from tautflex.mechanics.loads.time_table import TimeTable
from tautflex.numeric import Array

# Columns of a table file for each argument of `Tabulated`.
COLUMNS = {
    "rates": (("rate",), ("rate_x", "rate_y", "rate_z")),
    "quaternions": (("q_w", "q_x", "q_y", "q_z"),),
    "accelerations": (("acceleration",), ("acceleration_x", "acceleration_y", "acceleration_z")),
}
_LARGEST_FILE = 100_000_000


def read_table(path: str) -> dict[str, Array]:
    """Read the arguments of `Tabulated` from a CSV file.

    It has a header line and one row per instant: a column ``time`` [s]; ``rate`` or ``rate_x``, ``rate_y``, ``rate_z``
    [rad/s], or ``q_w``, ``q_x``, ``q_y``, ``q_z``; perhaps ``acceleration`` or ``acceleration_x``, ... [m/s^2]. Other
    columns are ignored, lines that begin with # too.

    Raises
    ------
    CaseError
        One line with the file, what was expected and what to do.
    """
    used = {"time", *(column for choices in COLUMNS.values() for columns in choices for column in columns)}
    header, numbers = _read(path, used, "time,rate")
    table = {"times": numbers[:, header.index("time")]}
    for name, choices in COLUMNS.items():
        for columns in choices:
            if all(column in header for column in columns):
                found = numbers[:, [header.index(column) for column in columns]]
                table[name] = found[:, 0] if len(columns) == 1 else found
    return table


class TimeTableKeys(Section):
    """Number or vector over time, straight between the rows: ``times`` and ``values``, or a CSV ``file``.

    The file has a header line with a column ``time``; its other columns are the values: x, y and z by these names (or
    names that end in _x, _y, _z), others in their order.
    """

    times: tuple[Number, ...] | None = key("instants of the rows [s], rising", (0.0, 1.0), None)
    values: tuple[Number, ...] | tuple[tuple[Number, ...], ...] | None = key(
        "value at each instant, a number or a list", (0.0, 0.1), None
    )
    file: Annotated[str, Strict()] | None = key("name of a CSV file with the table", "force.csv", None)

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        given = [name for name in ("times", "values") if getattr(self, name) is not None]
        if self.file is not None and given:
            raise ValueError(
                f"file: expected no file beside {given[0]}, got {self.file!r}; keep the file or the numbers"
            )
        if self.file is None and len(given) < 2:
            lacking = "times" if "times" not in given else "values"
            text = f"{lacking}: missing, a table in time expects times and values, or a file"
            raise ValueError(f"{text}; add for example times = [0.0, 1.0], values = [0.0, 0.1]")
        return self

    def table(self) -> TimeTable:
        """Read or make the table; CaseError if the file cannot be read or the rows do not go together."""
        if self.file is None:
            return TimeTable(self.times or (), self.values or ())
        header, numbers = _read(self.file, None, "time,value")
        columns = [number for number, name in enumerate(header) if name != "time"]
        axes = [header[column].lower().rpartition("_")[2] for column in columns]
        if set(axes) & set("xyz"):
            if sorted(axes) != ["x", "y", "z"]:
                text = f"file: expected the columns x, y and z beside time in {self.file!r}"
                raise CaseError(f"{text}, got {', '.join(header)}; give all three, each once")
            columns = [columns[axes.index(axis)] for axis in "xyz"]
        values = numbers[:, columns]
        return TimeTable(numbers[:, header.index("time")], values[:, 0] if values.shape[1] == 1 else values)


def _read(path: str, used: Collection[str] | None, example: str) -> tuple[list[str], Array]:
    """Header and numbers of a CSV file with a column time; None uses all columns."""
    lines = _lines(path)
    header = [name.strip() for name in lines[0]] if lines else []
    if "time" not in header:
        text = f"file: expected a column time in the header of {path!r}, got {', '.join(header)[:60] or 'nothing'}"
        raise CaseError(f"{text}; begin the file with for example {example}")
    if len(set(header)) < len(header):
        text = f"file: expected columns of different names in {path!r}, got {', '.join(header)[:60]}"
        raise CaseError(f"{text}; rename or remove one")
    numbers = np.array([_numbers(path, header, used, row, cells) for row, cells in enumerate(lines[1:], start=2)])
    return header, numbers.reshape(-1, len(header))


def _lines(path: str) -> list[list[str]]:
    """Cells of all lines that are neither empty nor comments."""
    missing = "its name is relative to the case file"
    content = read_text(Path(path), f"file: {path!r}", "CSV file", _LARGEST_FILE, missing, CaseError)
    kept = [line for line in content.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    return list(csv.reader(kept))


def _numbers(path: str, header: list[str], used: Collection[str] | None, row: int, cells: list[str]) -> list[float]:
    """Numbers of the columns that are used; the others may hold anything."""
    if len(cells) != len(header):
        text = f"file: expected {len(header)} cells in row {row} of {path!r}, got {len(cells)}"
        raise CaseError(f"{text}; separate them by commas")
    values = []
    for name, cell in zip(header, cells, strict=True):
        try:
            values.append(float(cell) if used is None or name in used else math.nan)
        except ValueError:
            text = f"file: expected a number in row {row}, column {name} of {path!r}, got {cell[:30]!r}"
            raise CaseError(f"{text}; correct it") from None
    return values
