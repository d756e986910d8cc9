"""What the page of the reproduction is made of; Markdown and HTML are two ways to write it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

GOOD, FAIR = 0.05, 0.20
"""Largest relative differences that count as agreement and as a fair one."""


@dataclass(frozen=True)
class Heading:
    """Title of a part, ``level`` 2 or 3; ``anchor`` is what a table of contents links to."""

    text: str
    anchor: str
    level: int = 2


@dataclass(frozen=True)
class Paragraph:
    """Plain text; ``lead`` is a bold beginning."""

    text: str
    lead: str = ""


@dataclass(frozen=True)
class Bullets:
    """A list of (bold beginning, plain text)."""

    items: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Command:
    """Something to type."""

    text: str


@dataclass(frozen=True)
class Cell:
    """Text of a table's cell; ``level`` is "", "good", "fair" or "poor"; numbers are set to the right."""

    text: str
    level: str = ""
    number: bool = False


@dataclass(frozen=True)
class Table:
    """Header and rows of equal length."""

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True)
class Picture:
    """A figure: its PNG file, title and caption."""

    file: Path
    title: str
    caption: str = ""


Block: TypeAlias = Heading | Paragraph | Bullets | Command | Table | Picture


def gap_cell(difference: float | None) -> Cell:
    """Return a relative difference as a signed percentage, coloured by its size."""
    if difference is None:
        return Cell("–", number=True)  # noqa: RUF001
    size = abs(difference)
    level = "good" if size <= GOOD else "fair" if size <= FAIR else "poor"
    return Cell(percent(difference), level, number=True)


def percent(difference: float) -> str:
    """Return a relative difference as a signed percentage with a typographic minus."""
    text = f"{100 * difference:+.1f} %".replace("-", "−")  # noqa: RUF001
    return "0.0 %" if text[1:] == "0.0 %" else text


def quantity_text(value: float | None, unit: str) -> str:
    """Return a number as the paper prints it: four digits after the point, two for percentages."""
    if value is None or value != value:
        return "–"  # noqa: RUF001
    if unit == "%":
        text = f"{value:.2f}"
    elif unit in ("Hz", "mm"):
        text = f"{value:.4f}"
    else:
        text = f"{value:.4g}"
    text = text.lstrip("-") if not text.strip("-0.") else text  # no minus before a zero
    return text.replace("-", "−")  # noqa: RUF001


def symbols(text: str) -> str:
    """Return text with "pi/5" and "m^2" written as mathematics does."""
    for plain, written in (("pi/", "π/"), ("^2", "²"), ("^3", "³"), ("^4", "⁴")):
        text = text.replace(plain, written)
    return text
