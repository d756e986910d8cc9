"""Checks of arguments whose messages say which argument, what was expected, what came and what to try."""

from __future__ import annotations

import contextlib
import difflib
import inspect
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex.errors import InputError
from tautflex.text import shown

T = TypeVar("T")
_MOST = 10**15  # of anything that is counted

# Remedies that fit any number; who knows what the number means may say more.
VAGUE_REMEDIES = ("give a positive value in SI units", "give zero or a positive value in SI units")


def _fail(name: str, expected: str, got: object, remedy: str, error: type[InputError]) -> InputError:
    text = f"{name}: expected {expected}, got {shown(got)}"
    return error(f"{text}; {remedy}" if remedy else text)


def _without_quotes(value: Any) -> str:
    """What to try with a text, or texts, where numbers are meant; empty for anything else."""
    if isinstance(value, list | tuple) and any(map(_without_quotes, value)):
        return "write numbers without quotes"
    if not isinstance(value, str):
        return ""
    with contextlib.suppress(ValueError):
        return f"write it without quotes: {float(value):.6g}"
    return "give a number"


@contextlib.contextmanager
def within(name: str) -> Iterator[None]:
    """Put the name of an argument in front of what is wrong inside it."""
    try:
        yield
    except InputError as error:
        raise error.behind(f"{name}.") from None


def together(*asked: Callable[[], T]) -> list[T]:
    """What all of these give, or one error of the first one's kind with the problems of all that fail."""
    found, errors = list[T](), list[InputError]()
    for ask in asked:
        try:
            found.append(ask())
        except InputError as error:
            errors.append(error)
    if errors:
        problems = dict.fromkeys(problem for error in errors for problem in error.problems)
        raise type(errors[0])(*problems) from errors[0]
    return found


def instance(name: str, value: Any, kind: type[T] | tuple[type[Any], ...], expected: str, *, remedy: str = "") -> T:
    """Return ``value`` if it is of a kind, or raise InputError."""
    if isinstance(value, kind):
        return cast(T, value)
    if isinstance(value, type) and issubclass(value, kind):
        remedy = f"write {value.__name__}(...), an object of that class"
    raise _fail(name, expected, value, remedy, InputError)


def mapping(name: str, given: Mapping[str, Any] | None) -> dict[str, Any]:
    """Copy what was given by name, or nothing; InputError for another object."""
    return dict(instance(name, {} if given is None else given, Mapping, "a mapping, or None"))


def several(name: str, value: Any, kind: type[Any] | tuple[type[Any], ...], example: str) -> tuple[Any, ...]:
    """Return the objects of a kind in a list or tuple, or raise InputError; ``example`` is one of them."""
    expected = f"a list of objects such as {example}"
    if not isinstance(value, Sequence) or isinstance(value, str | bytes):
        raise _fail(name, expected, value, f"write {name}=[...]", InputError)
    return tuple(instance(name, each, kind, expected) for each in value)


def function(name: str, value: Any, *arguments: str) -> None:
    """Raise InputError unless ``value`` can be called with as many arguments."""
    wanted = f"a function of ({', '.join(arguments)})"
    if not callable(value) or isinstance(value, type):
        raise _fail(name, wanted, value, "", InputError)
    try:
        inspect.signature(value).bind(*arguments)
    except TypeError:
        got = f"one of {inspect.signature(value)}"
        raise InputError(f"{name}: expected {wanted}, got {got}; take all {len(arguments)} of them") from None
    except ValueError:  # functions built into the interpreter need not tell
        pass


def teller(progress: Any) -> Callable[[float, str], None]:
    """Who is told the fraction done and a short message: ``progress``, or nobody if it is None; else InputError."""
    if progress is None:
        return _silent
    function("progress", progress, "fraction", "message")
    return cast(Callable[[float, str], None], progress)


def _silent(fraction: float, message: str) -> None:
    """Nobody listens."""


def path(name: str, value: Any) -> Path:
    """Return ``value`` as a path, or raise InputError."""
    given: str | os.PathLike[str] = instance(
        name, value, (str, os.PathLike), "a path", remedy="write it as text or pathlib.Path"
    )
    return Path(given)


def flag(name: str, value: Any) -> bool:
    """Return ``value`` as a bool, or raise InputError."""
    return bool(instance(name, value, (bool, np.bool_), "True or False"))


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
    number = np.nan
    if (isinstance(value, Real) or getattr(value, "shape", None) == ()) and not np.iscomplexobj(value):
        with contextlib.suppress(TypeError, ValueError, OverflowError):
            number = float(value)
    if not np.isfinite(number):
        raise _fail(name, "a finite number", value, remedy or _without_quotes(value), error)
    return number


def whole(name: str, value: Any, lowest: int, *, remedy: str = "") -> int:
    """Return ``value`` as an int >= ``lowest``, or raise InputError."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not lowest <= value <= _MOST:
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
    if not isinstance(value, str) or value not in choices:
        raise _fail(name, "one of " + ", ".join(map(repr, choices)), value, meant(value, choices), InputError)
    return str(value)


def meant(value: Any, choices: Iterable[str]) -> str:
    """Ask whether the choice nearest to a text was meant; "" if none is near."""
    near = difflib.get_close_matches(value, choices, n=1) if isinstance(value, str) else ()
    return f"did you mean {near[0]!r}?" if near else ""


def pick(value: Any, choices: Iterable[str]) -> str:
    """What to try in place of a text that is none of the choices."""
    return meant(value, choices) or "choose one of them"


def vector3(name: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return ``value`` as a finite float array of shape (3,), or raise InputError."""
    return float_array(name, value, (3,))


def vectors3(name: str, values: Sequence[ArrayLike]) -> NDArray[np.float64]:
    """Return as many of the values, from the first on, as `vector3` would take, shape (value, 3)."""
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        array = np.array(values)
        if array.dtype.kind in "biuf" and array.shape == (len(values), 3) and np.all(np.isfinite(array)):
            return array.astype(float)
    found = []
    for value in values:
        try:
            found.append(vector3(name, value))
        except InputError:
            break
    return np.array(found).reshape(-1, 3)


def numbers(name: str, value: Any, *, error: type[InputError] = InputError) -> NDArray[np.float64]:
    """Return ``value`` as a float array of any shape, finite or not, or raise ``error``; texts are no numbers."""
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        array = np.asarray(value)
        if array.dtype.kind in "biufO":
            return np.asarray(array, dtype=float)
    raise _fail(name, "an array of numbers", value, _without_quotes(value) and "give numbers without quotes", error)


def float_array(
    name: str,
    value: ArrayLike,
    shape: tuple[int | None, ...],
    *,
    error: type[InputError] = InputError,
) -> NDArray[np.float64]:
    """Return ``value`` as a finite float array of the given shape (None matches any length)."""
    array = numbers(name, value, error=error)
    if array.ndim != len(shape) or any(
        want is not None and want != have for want, have in zip(shape, array.shape, strict=True)
    ):
        wanted = "(" + ", ".join("any" if want is None else str(want) for want in shape) + ")"
        raise error(f"{name}: expected shape {wanted}, got {array.shape}")
    if not np.all(np.isfinite(array)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise error(f"{name}: expected finite numbers, got {array[where]} at index {where}")
    return array


def spread(name: str, value: ArrayLike, count: int, width: int | None = None) -> NDArray[np.float64]:
    """Return ``value`` as finite floats of shape (count,) or (count, width), one for all or one for each."""
    shape = (count,) if width is None else (count, width)
    array = numbers(name, value)
    single = array.ndim == len(shape) - 1
    return np.array(np.broadcast_to(float_array(name, array, shape[1:] if single else shape), shape))


def rising(name: str, instants: NDArray[np.float64]) -> None:
    """Raise InputError if an instant comes before the one in front of it."""
    falling = np.flatnonzero(np.diff(instants) < 0.0)
    if falling.size:
        before, after = instants[falling[0] : falling[0] + 2]
        raise InputError(f"{name}: expected rising instants, got {after:g} s after {before:g} s; sort them")


def indices(
    name: str, value: Any, limit: int, what: str = "node", *, error: type[InputError] = InputError
) -> NDArray[np.int64]:
    """Return a list of numbers in [0, limit) as an int array, or raise ``error``."""
    try:
        column = np.reshape(np.asarray(value), (-1, 1))
    except (TypeError, ValueError):
        column = np.asarray("")
    if np.ndim(column) != 2 or (np.shape(column)[0] and column.dtype.kind not in "iu"):
        raise _fail(name, f"a list of {what} numbers", value, f"write {name}=[0, 1, ...]", error)
    return index_array(name, column, 1, limit, what=what, error=error)[:, 0]


def index_array(
    name: str,
    value: ArrayLike,
    columns: int,
    limit: int,
    *,
    what: str = "node",
    error: type[InputError] = InputError,
) -> NDArray[np.int64]:
    """Return ``value`` as an int array of shape (any, columns) with entries in [0, limit)."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):
        array = np.asarray("")
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
            f"{name}: expected {what} numbers in 0..{limit - 1}, got {int(array[row, column])} in row {row}; "
            f"count {what}s from 0"
        )
    return array.astype(np.int64)
