"""One line of a comparison, and how well a set of them agrees."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tautflex.errors import InputError
from tautflex.writing import written


@dataclass(frozen=True)
class Row:
    """One published number and ours, in the unit the paper prints.

    Attributes
    ----------
    table
        ``"1"`` to ``"9"``, or ``"ablation"``, ``"compression"``, ``"convergence"``, ``"summary"``.
    case
        Antenna and maneuver, or number of a mode.
    quantity
        What is compared.
    paper, ours
        Values; None where the paper prints nothing, or where we have nothing.
    unit
        Unit of both.
    note
        Why they differ, or what the number means.
    variant
        ``"published"``, ``"nearest-node"`` or ``"consistent"``.
    repeats
        Table that printed the same number of the same run before; "" for all others.
    """

    table: str
    case: str
    quantity: str
    paper: float | None
    ours: float | None
    unit: str
    note: str = ""
    variant: str = "published"
    repeats: str = ""

    @property
    def difference(self) -> float | None:
        """Relative difference ours / paper - 1; None without two numbers."""
        if self.paper is None or self.ours is None or self.paper == 0.0:
            return None
        return self.ours / self.paper - 1.0

    @property
    def log_ratio(self) -> float | None:
        """Natural logarithm of ours / paper; None without two positive numbers."""
        if self.paper is None or self.ours is None or min(self.paper, self.ours) <= 0.0:
            return None
        return math.log(self.ours / self.paper)

    def to_si(self) -> dict[str, Any]:
        """Return the row as a mapping with ``paper`` and ``ours`` in SI units; a percentage stays one."""
        unit, factor = ("m", 1e-3) if self.unit == "mm" else (self.unit, 1.0)
        return {
            "case": self.case,
            "quantity": self.quantity,
            "paper": _scaled(self.paper, factor),
            "ours": _scaled(self.ours, factor),
            "unit": unit,
            "difference": self.difference,
            "log_ratio": self.log_ratio,
            "note": self.note,
        }


def mean_log_ratio(rows: Iterable[Row], quantity: str) -> float:
    """Return the mean absolute log ratio of a quantity, every published number counted once.

    Raises
    ------
    InputError
        If no row compares that quantity.
    """
    ratios = (row.log_ratio for row in rows if row.quantity == quantity and not row.repeats)
    return _mean_size(ratios, f"some with quantity {quantity!r}, got none; pass those of Tables 6 to 9")


def mean_difference(rows: Iterable[Row]) -> float:
    """Return the mean absolute relative difference of rows.

    Raises
    ------
    InputError
        If there is nothing to compare.
    """
    return _mean_size((row.difference for row in rows), "some with a published and a computed number, got none")


def _mean_size(values: Iterable[float | None], expected: str) -> float:
    known = [abs(value) for value in values if value is not None]
    if not known:
        raise InputError(f"rows: expected {expected}")
    return math.fsum(known) / len(known)


def write_csv(rows: Sequence[Row], path: str | os.PathLike[str]) -> Path:
    """Write rows as CSV: values in the unit the paper prints, empty where there is none, each published number once.

    Raises
    ------
    NotWrittenError
        If the file cannot be written; what stood there is whole.
    """
    target = Path(path)
    header = ("variant", "table", "case", "quantity", "unit", "paper", "ours", "difference", "log_ratio", "note")
    with written(target) as place, place.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        for row in (row for row in rows if not row.repeats):
            numbers = map(_digits, (row.paper, row.ours, row.difference, row.log_ratio))
            writer.writerow((row.variant, row.table, row.case, row.quantity, row.unit, *numbers, row.note))
    return target


def _digits(value: float | None) -> str:
    return "" if value is None or math.isnan(value) else f"{value:.6g}"


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else float(f"{value * factor:.12g}")
