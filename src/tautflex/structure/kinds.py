"""Numbers that may differ from one kind of element to another."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tautflex.errors import InputError

KINDS = ["membrane", "cable", "beam"]
"""Kinds of element; registering an element of another kind adds it here."""
# What case files call beams.
_FRAME = "frame"


class ByKind(Mapping[str, Any]):
    """Numbers of some kinds of element, hashable; all other kinds have ``rest``."""

    def __init__(self, values: Mapping[str, Any], rest: float) -> None:
        self._values, self._rest = dict(values), rest

    def __getitem__(self, kind: str) -> Any:
        return self._values.get(kind, self._rest)

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(frozenset(self._values.items()))

    def __repr__(self) -> str:
        return repr(self._values)

    def with_values(self, values: Mapping[str, Any]) -> ByKind:
        """Same numbers with some of them replaced."""
        return ByKind(self._values | dict(values), self._rest)


def by_kind(name: str, value: Any, check: Callable[[str, Any], Any], rest: float) -> Any:
    """One number for all kinds as it is, numbers by kind as a `ByKind`; both checked.

    Parameters
    ----------
    name
        Of the argument, for messages.
    value
        A number, or a mapping from ``"membrane"``, ``"cable"``, ``"frame"`` (or ``"beam"``), or the kind of an element
        from outside, to numbers.
    check
        Raises InputError for a number that is out of range.
    rest
        Number of the kinds that are left out.

    Raises
    ------
    InputError
        If a kind is unknown or a number is out of range.
    """
    if not isinstance(value, Mapping):
        check(name, value)
        return value
    found: dict[str, float] = {}
    for given, number in value.items():
        kind = "beam" if given == _FRAME else given
        if kind not in KINDS or kind in found:
            names = ", ".join(_FRAME if one == "beam" else one for one in KINDS)
            raise InputError(f"{name}: expected kinds of element, each once, of {names}, got {given!r}; correct it")
        check(f"{name}.{given}", number)
        found[kind] = float(number)
    if not found:
        raise InputError(f"{name}: expected a number for some kind of element, got none; give one number for all")
    return ByKind(found, rest)
