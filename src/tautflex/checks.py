"""Shape and range checks whose messages say which argument, what was expected, what came and what to try."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex.errors import InputError

# Remedies that fit any number; who knows what the number means may say more.
VAGUE_REMEDIES = ("give a positive value in SI units", "give zero or a positive value in SI units")


def _fail(name: str, expected: str, got: object, remedy: str, error: type[InputError]) -> InputError:
    text = f"{name}: expected {expected}, got {got!r}"
    return error(f"{text}; {remedy}" if remedy else text)


def positive(name: str, value: Any, *, remedy: str = "", error: type[InputError] = InputError) -> float:
    """Return ``value`` as a float > 0, or raise ``error``."""
    number = finite(name, value, remedy=remedy, error=error)
    if number <= 0.0:
        raise _fail(name, "a number > 0", value, remedy or VAGUE_REMEDIES[0], error)
    return number


def non_negative(name: str, value: Any, *, remedy: str = "", error: type[InputError] = InputError) -> float:
    """Return ``value`` as a float >= 0, or raise ``error``."""
    number = finite(name, value, remedy=remedy, error=error)
    if number < 0.0:
        raise _fail(name, "a number >= 0", value, remedy or VAGUE_REMEDIES[1], error)
    return number


def finite(name: str, value: Any, *, remedy: str = "", error: type[InputError] = InputError) -> float:
    """Return ``value`` as a finite float, or raise ``error``."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise _fail(name, "a finite number", value, remedy, error) from None
    if not np.isfinite(number):
        raise _fail(name, "a finite number", value, remedy, error)
    return number


def whole(name: str, value: Any, lowest: int, *, remedy: str = "") -> int:
    """Return ``value`` as an int >= ``lowest``, or raise InputError."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < lowest:
        raise _fail(name, f"an integer >= {lowest}", value, remedy, InputError)
    return int(value)


def between(name: str, value: Any, low: float, high: float, *, remedy: str = "") -> float:
    """Return ``value`` as a float in the closed interval [low, high], or raise InputError."""
    number = finite(name, value, remedy=remedy)
    if not low <= number <= high:
        raise _fail(name, f"a number in [{low:g}, {high:g}]", value, remedy, InputError)
    return number


def poisson_ratio(name: str, value: Any) -> float:
    """Return a Poisson ratio inside (-1, 0.5), the range of stable isotropic solids."""
    number = finite(name, value)
    if not -1.0 < number < 0.5:
        raise _fail(name, "a number inside (-1, 0.5)", value, "films have 0.3 to 0.4", InputError)
    return number


def one_of(name: str, value: Any, choices: Sequence[str]) -> str:
    """Return ``value`` if it is one of ``choices``, or raise InputError."""
    if value not in choices:
        raise _fail(name, "one of " + ", ".join(repr(choice) for choice in choices), value, "", InputError)
    return str(value)


def vector3(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return ``value`` as a finite float array of shape (3,), or raise InputError."""
    return float_array(name, value, (3,))


def float_array(
    name: str,
    value: ArrayLike,
    shape: tuple[int | None, ...],
    *,
    error: type[InputError] = InputError,
) -> NDArray[np.float64]:
    """Return ``value`` as a finite float array of the given shape (None matches any length)."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise _fail(name, "an array of numbers", value, "", error) from None
    if array.ndim != len(shape) or any(
        want is not None and want != have for want, have in zip(shape, array.shape, strict=True)
    ):
        wanted = "(" + ", ".join("any" if want is None else str(want) for want in shape) + ")"
        raise error(f"{name}: expected shape {wanted}, got {array.shape}")
    if not np.all(np.isfinite(array)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise error(f"{name}: expected finite numbers, got {array[where]} at index {where}")
    return array


def rising(name: str, instants: NDArray[np.float64]) -> None:
    """Raise InputError if an instant comes before the one in front of it."""
    falling = np.flatnonzero(np.diff(instants) < 0.0)
    if falling.size:
        before, after = instants[falling[0] : falling[0] + 2]
        raise InputError(f"{name}: expected rising instants, got {after:g} s after {before:g} s; sort them")


def index_array(
    name: str, value: ArrayLike, columns: int, limit: int, *, error: type[InputError] = InputError
) -> NDArray[np.int64]:
    """Return ``value`` as an int array of shape (any, columns) with entries in [0, limit)."""
    array = np.asarray(value)
    if array.size == 0:
        return np.zeros((0, columns), dtype=np.int64)
    if array.ndim != 2 or array.shape[1] != columns or not np.issubdtype(array.dtype, np.integer):
        raise error(
            f"{name}: expected an integer array of shape (any, {columns}), got shape {array.shape} of {array.dtype}"
        )
    bad = np.argwhere((array < 0) | (array >= limit))
    if bad.size:
        row, column = (int(i) for i in bad[0])
        raise error(
            f"{name}: expected node numbers in 0..{limit - 1}, got {int(array[row, column])} in row {row}; "
            "count nodes from 0"
        )
    return array.astype(np.int64)
