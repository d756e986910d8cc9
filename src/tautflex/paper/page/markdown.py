"""Pieces of the page as Markdown: lists, tables, pictures, and how numbers and differences are written."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path

GOOD, FAIR = 0.05, 0.20
"""Largest relative differences that count as agreement and as a fair one."""
_WORDS = ("quantity", "note")  # columns of words; so is the first one, and all others hold numbers


def bullets(items: Iterable[tuple[str, str]]) -> str:
    """Return a list of (bold beginning, plain text)."""
    return "\n".join(f"- **{lead}** {text}" for lead, text in items)


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; numbers are set to the right."""
    rule = ["---" if place == 0 or title in _WORDS else "---:" for place, title in enumerate(header)]
    lines = [[cell.replace("|", "\\|") for cell in line] for line in (header, *rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in (lines[0], rule, *lines[1:]))


def picture(file: Path, title: str, caption: str, folder: Path) -> str:
    """Return a figure with its title and caption, linked from a folder."""
    place = Path(os.path.relpath(file, folder)).as_posix()
    return f"![{title}](<{place}>)\\\n**{title}** {caption}".rstrip()


def marked(difference: float | None) -> str:
    """Return a relative difference as a signed percentage, marked by its size."""
    if difference is None:
        return "–"  # noqa: RUF001
    size = abs(difference)
    return percent(difference) + ("" if size <= GOOD else " *(!)*" if size <= FAIR else " **(!!)**")


def percent(difference: float) -> str:
    """Return a relative difference as a signed percentage with a typographic minus."""
    text = f"{100 * difference:+.1f} %".replace("-", "−")  # noqa: RUF001
    return "0.0 %" if text[1:] == "0.0 %" else text


def quantity_text(value: float | None, unit: str) -> str:
    """Return a number as the paper prints it: four digits after the point, two for percentages."""
    if value is None or value != value:
        return "–"  # noqa: RUF001
    text = format(value, {"%": ".2f", "Hz": ".4f", "mm": ".4f"}.get(unit, ".4g"))
    text = text.lstrip("-") if not text.strip("-0.") else text  # no minus before a zero
    return text.replace("-", "−")  # noqa: RUF001


def symbols(text: str) -> str:
    """Return text with "pi/5" and "m^2" written as mathematics does."""
    for plain, written in (("pi/", "π/"), ("^2", "²"), ("^3", "³"), ("^4", "⁴")):
        text = text.replace(plain, written)
    return text
