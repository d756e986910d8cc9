"""The paper's Tables 1 to 9 as printed; the numbers live in ``tautflex/data/published``."""

from __future__ import annotations

import math
import tomllib
from functools import cache
from importlib.resources import files
from typing import Any

from tautflex.checks import one_of

NUMBERS = (1, 2, 3, 4, 5, 6, 7, 8, 9)
RESPONSE_TABLES = (6, 7, 8, 9)
"""Tables of response frequencies and amplitudes."""


def table(number: int) -> list[dict[str, Any]]:
    """Return the rows of a table, one mapping per printed row.

    Parameters
    ----------
    number
        1 to 9. Table 5 lists parameters, not rows: see :func:`about`.

    Returns
    -------
    list of dict
        Keys and units as the file's comments say. ``rate`` [rad/s] is a number, ``rate_name`` its part of a run's name,
        e.g. ``"pi_100"``; ``padded_duration`` [s] is that of the table, if it has one.

    Raises
    ------
    InputError
        If there is no such table.
    """
    content = _content(number)
    rows = []
    for row in map(dict, content["rows"]):
        if "rate" in row:
            numerator, _, denominator = row["rate"].partition("/")
            row |= {"rate": math.pi / float(denominator), "rate_name": f"{numerator}_{denominator}"}
            row["padded_duration"] = content["padded_duration"]
        rows.append(row)
    return rows


def about(number: int) -> dict[str, Any]:
    """Return everything a table's file says beside its rows: ``title``, ``source``, ``padded_duration`` [s], ...

    Raises
    ------
    InputError
        If there is no such table.
    """
    return {key: value for key, value in _content(number).items() if key != "rows"}


@cache
def _content(number: int) -> dict[str, Any]:
    one_of("table", str(number), tuple(map(str, NUMBERS)))
    text = files("tautflex").joinpath("data", "published", f"table_{number}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
