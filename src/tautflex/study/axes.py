"""Axes of a study: their values, and where in a case they belong."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from tautflex.case.help.reference import reference
from tautflex.case.reading import change_key
from tautflex.case.section import DEGREES
from tautflex.errors import CaseError
from tautflex.study.sections import Span, Study


def values_of(axis: Span | tuple[Any, ...]) -> tuple[Any, ...]:
    """Values of an axis as a case file would hold them."""
    if isinstance(axis, tuple):
        return axis
    space = np.geomspace if axis.spacing == "log" else np.linspace
    values = space(axis.first, axis.last, axis.count)
    values[0], values[-1] = axis.first, axis.last if axis.count > 1 else axis.first
    return tuple(values.tolist())


def steps_of(study: Study) -> list[list[dict[str, Any]]]:
    """What each group of axes sets at each of its values: group -> value -> key -> value."""
    steps = []
    for group in study.groups:
        columns = [values_of(study.axes[name]) for name in group]
        steps.append([dict(zip(group, row, strict=True)) for row in zip(*columns, strict=True)])
    return steps


def with_keys(values: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Copy of the tables of a case with dotted keys set; numbers among their parts count the tables of a list.

    Raises
    ------
    CaseError
        If a part of a key is no table or list of the case.
    """
    changed = dict(values)
    for key, value in changes.items():
        _set(changed, key.split("."), value, key)
    return changed


def _set(place: Any, parts: list[str], value: Any, key: str) -> None:
    """Set a key in a table or list that is a copy already; what lies between is copied on the way."""
    name: Any = parts[0]
    if isinstance(place, list):
        if not name.isdecimal() or int(name) >= len(place):
            text = f"axes.{key}: expected a number below {len(place)}, of one of its tables, got {name!r}"
            raise CaseError(f"{text}; correct the key")
        name = int(name)
    if len(parts) == 1:
        change_key(place, name, value)
        return
    inner = place[name] if isinstance(place, list) else place.get(name, {})
    if isinstance(inner, tuple | list):
        inner = list(inner)
    elif isinstance(inner, dict):
        inner = dict(inner)
    else:
        raise CaseError(f"axes.{key}: expected the key of a value, got one inside {name!r}, a value; correct the key")
    place[name] = inner
    _set(inner, parts[1:], value, key)


@cache
def unit_of(key: str) -> str:
    """Unit of a dotted key of the case as its help tells it; "" where it tells none."""
    section, _, name = key.rpartition(".")
    if name.endswith(DEGREES):
        return unit_of(key.removesuffix(DEGREES)).replace("rad", "deg")
    try:
        entries = reference(section.split(".")[0])
    except CaseError:
        return ""
    return next((one.unit for entry in entries for one in entry.keys if one.name == name), "")
