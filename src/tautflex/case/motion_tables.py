"""Motion tables in CSV files."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import CaseError

# Columns of a table file for each argument of `Tabulated`.
COLUMNS = {
    "rates": (("rate",), ("rate_x", "rate_y", "rate_z")),
    "quaternions": (("q_w", "q_x", "q_y", "q_z"),),
    "accelerations": (("acceleration",), ("acceleration_x", "acceleration_y", "acceleration_z")),
}
_LARGEST_FILE = 100_000_000


def read_table(path: str) -> dict[str, NDArray[np.float64]]:
    """Read a motion table from a CSV file.

    Parameters
    ----------
    path
        File with a header line and one row per instant: a column ``time`` [s]; ``rate`` or ``rate_x``, ``rate_y``,
        ``rate_z`` [rad/s], or ``q_w``, ``q_x``, ``q_y``, ``q_z``; perhaps ``acceleration`` or ``acceleration_x``, ...
        [m/s^2]. Other columns are ignored, lines that begin with # too.

    Returns
    -------
    dict
        ``times`` and whichever of ``rates``, ``quaternions``, ``accelerations`` the file has.

    Raises
    ------
    CaseError
        One line with the file, what was expected and what to do.
    """
    lines = _lines(path)
    header = [name.strip() for name in lines[0]] if lines else []
    if "time" not in header:
        text = f"file: expected a column time in the header of {path!r}, got {', '.join(header)[:60] or 'nothing'}"
        raise CaseError(f"{text}; begin the file with for example time,rate")
    numbers = np.array([_numbers(path, header, row, cells) for row, cells in enumerate(lines[1:], start=2)])
    numbers = numbers.reshape(-1, len(header))
    table = {"times": numbers[:, header.index("time")]}
    for name, choices in COLUMNS.items():
        for columns in choices:
            if all(column in header for column in columns):
                found = numbers[:, [header.index(column) for column in columns]]
                table[name] = found[:, 0] if len(columns) == 1 else found
    return table


def _lines(path: str) -> list[list[str]]:
    """Cells of all lines that are neither empty nor comments."""
    try:
        if Path(path).stat().st_size > _LARGEST_FILE:
            raise CaseError(
                f"file: expected a table of at most {_LARGEST_FILE / 1e6:g} MB, got more in {path!r}; thin it"
            )
        content = Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise CaseError(f"file: no such file {path!r}; its name is relative to the case file") from None
    except (OSError, UnicodeDecodeError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise CaseError(f"file: cannot read {path!r} ({reason}); expected a CSV file") from None
    kept = [line for line in content.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    return list(csv.reader(kept))


def _numbers(path: str, header: list[str], row: int, cells: list[str]) -> list[float]:
    """Numbers of the columns that are used; the others may hold anything."""
    used = {"time", *(column for choices in COLUMNS.values() for columns in choices for column in columns)}
    if len(cells) != len(header):
        text = f"file: expected {len(header)} cells in row {row} of {path!r}, got {len(cells)}"
        raise CaseError(f"{text}; separate them by commas")
    values = []
    for name, cell in zip(header, cells, strict=True):
        try:
            values.append(float(cell) if name in used else math.nan)
        except ValueError:
            text = f"file: expected a number in row {row}, column {name} of {path!r}, got {cell[:30]!r}"
            raise CaseError(f"{text}; correct it") from None
    return values
