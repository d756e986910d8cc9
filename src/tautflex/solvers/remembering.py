"""What steps leave for the next one: the attributes that an object names, out and in again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, ClassVar

import numpy as np

from tautflex.numeric import Array

Memory = dict[str, Any]
"""Arrays and numbers by name, and further ones below a name; None is left out."""


class Remembering:
    """An object whose attributes named in ``MEMORY`` are all that it takes from one step to the next.

    They are numbers, arrays, or objects that remember, alone or in a list; what is None is not remembered.
    """

    MEMORY: ClassVar[tuple[str, ...]] = ()

    def memory(self) -> Memory:
        """Copy of what is remembered."""
        return {name: copied(value) for name in self.MEMORY if (value := getattr(self, name)) is not None}

    def recall(self, memory: Memory) -> None:
        """Remember what another object of this kind did; what it did not stays."""
        for name in self.MEMORY:
            now, then = getattr(self, name), memory.get(name)
            if then is None:
                continue
            if isinstance(now, Remembering):
                now.recall(then)
            elif isinstance(now, list):
                for number, part in enumerate(now):
                    part.recall(then[str(number)])
            elif not isinstance(then, dict):
                setattr(self, name, copied(then))


def copied(value: Any) -> Any:
    """Copy of a value whose parts have names, arrays and numbers as such."""
    if isinstance(value, Remembering):
        return value.memory()
    if isinstance(value, list):
        return {str(number): copied(part) for number, part in enumerate(value)}
    if is_dataclass(value):
        parts = {item.name: getattr(value, item.name) for item in fields(value)}
    elif hasattr(value, "_asdict"):
        parts = value._asdict()
    elif isinstance(value, Mapping):
        parts = dict(value)
    else:
        return (value.item() if value.ndim == 0 else value.copy()) if isinstance(value, np.ndarray) else value
    return {name: copied(part) for name, part in parts.items() if part is not None}


def flat(memory: Memory, above: str = "") -> dict[str, Array]:
    """Memory as arrays whose names are joined by dots."""
    found: dict[str, Array] = {}
    for name, value in memory.items():
        found |= flat(value, f"{above}{name}.") if isinstance(value, dict) else {above + name: np.asarray(value)}
    return found


def nested(arrays: Mapping[str, Array]) -> Memory:
    """Memory from arrays whose names are joined by dots."""
    found: Memory = {}
    for name, array in arrays.items():
        *above, last = name.split(".")
        place = found
        for part in above:
            place = place.setdefault(part, {})
        place[last] = copied(np.asarray(array))
    return found
