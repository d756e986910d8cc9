"""Signals: how much an effect does, and when. A number, a `TimeTable`, a function of time, or numbers that are held."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.text import shown

Signal = Callable[[float], ArrayLike] | ArrayLike
"""Constant, or function of time [s]."""


class Held:
    """Numbers that whoever drives sets: constant until they are set again, so they never jump inside an interval.

    It stands where a function of time stands. Just before the instant of the last change it still has the numbers of
    before, so that a run which goes on from there meets the jump.

    Parameters
    ----------
    values
        Numbers to begin with, a number or shape (n,).

    Raises
    ------
    InputError
        If they are no finite numbers.

    Examples
    --------
    >>> import tautflex as tf
    >>> force = tf.Held(0.0)
    >>> force.hold(0.2, time=1.0)
    >>> float(force(0.5)), float(force(1.0)), float(force(7.0))
    (0.0, 0.2, 0.2)
    """

    def __init__(self, values: ArrayLike) -> None:
        self._before = self._now = _finite("values", values)
        self._since = -np.inf

    def __repr__(self) -> str:
        return f"Held({shown(self._now.tolist())})"

    def __call__(self, time: float) -> Array:
        """Numbers at an instant [s]."""
        return self._now if time >= self._since else self._before

    def hold(self, values: ArrayLike, time: float) -> None:
        """Set the numbers from an instant [s] on; InputError if they are not as many as before, or not finite."""
        self._before, self._now = self._now, checks.float_array("values", values, self._now.shape)
        self._since = checks.finite("time", time)


def _finite(name: str, values: ArrayLike) -> Array:
    array = checks.numbers(name, values)
    return checks.float_array(name, array, array.shape)


def check_signal(name: str, signal: Signal | None) -> None:
    """Raise InputError for a function of anything but the time."""
    if callable(signal):
        checks.function(name, signal, "time")


def value_at(name: str, signal: Signal, time: float) -> Array:
    """Value of a signal at an instant [s]; InputError, with the name of the argument, if it has none there."""
    try:
        value = signal(time) if callable(signal) else signal
    except Exception as error:
        told = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(
            f"{name}: expected numbers at t = {time:g} s, the function failed ({told}); correct it"
        ) from error
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: expected numbers at t = {time:g} s, got {shown(value)}") from None
