"""How objects are shown: a value on one line, an object as a short card."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

_LINE, _MOST = 82, 12  # characters of a line, lines of a card


def shown(value: object, most: int = 120) -> str:
    """Text of a value on one short line; of a card, its title."""
    text, title = repr(value), type(value).__name__
    if "\n" in text:
        text = title if text.startswith(f"{title}\n") else " ".join(text.split())
    return text if len(text) <= most else f"{text[: most - 3]}..."


def card(thing: object, lines: Mapping[str, object]) -> str:
    """Return the name of an object's class and a line for each thing that is known of it; empty ones are left out."""
    told = {name: " ".join(str(text).split()) for name, text in lines.items() if text not in (None, "")}
    wide = max(map(len, told), default=0)
    rows = [f"  {name:{wide}}  {text}" for name, text in told.items()]
    if len(rows) >= _MOST:
        rows = [*rows[: _MOST - 2], f"  ... and {len(rows) - _MOST + 2} more"]
    rows = [row if len(row) <= _LINE else f"{row[: _LINE - 3]}..." for row in rows]
    return "\n".join([type(thing).__name__, *rows])


def brief(thing: Any) -> str:
    """Return the class and the fields of a dataclass on one line, arrays by their shapes: a ``__repr__``."""
    told = [f"{item.name}={_field(getattr(thing, item.name))}" for item in fields(thing) if item.repr]
    return f"{type(thing).__name__}({', '.join(told)})"


def count(things: Any, word: str) -> str:
    """Return e.g. "2 modes", or "1 mode"."""
    number = things if isinstance(things, int | np.integer) else len(things)
    return f"{number} {word}{'' if number == 1 else 's'}"


def span(values: Any, unit: str) -> str:
    """Return the range of some numbers, e.g. "1 to 2.7 Hz"; "" if there are none."""
    array = np.asarray(values, dtype=float)
    if not array.size:
        return ""
    low, high = f"{array.min():.4g}", f"{array.max():.4g}"
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def _field(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size > 6:
        return f"<array {value.shape}>"
    if isinstance(value, list | tuple) and len(value) > 6:
        return f"<{len(value)} of {shown(value[0], 40)} to {shown(value[-1], 40)}>"
    text = repr(value)
    if callable(value) and " at 0x" in text:
        return f"<function {getattr(value, '__name__', type(value).__name__)}>"
    return text if len(text) <= _LINE and "\n" not in text else f"<{type(value).__name__}>"
