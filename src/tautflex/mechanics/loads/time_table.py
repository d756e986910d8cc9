"""Functions of time given as a table: what an input does, row by row."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.text import brief

# A slope that changes by less than this part of the steepest one is round-off of the table.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class TimeTable:
    """Function of time through the rows of a table, straight between them, constant before and after.

    Parameters
    ----------
    times
        Instants of the rows [s], rising, shape (n,). An instant given twice is a jump: the second row counts from
        there on.
    values
        Numbers at the instants, shape (n,), or vectors, shape (n, k).

    Raises
    ------
    InputError
        If the table is empty, disordered, or has not one value per instant.

    Examples
    --------
    >>> import tautflex as tf
    >>> float(tf.TimeTable([0.0, 1.0], [0.0, 2.0])(0.25))
    0.5
    """

    times: ArrayLike
    values: ArrayLike
    __repr__ = brief

    def __post_init__(self) -> None:
        times = checks.float_array("times", self.times, (None,))
        values = checks.float_array(
            "values", self.values, (None,) * max(1, min(2, checks.numbers("values", self.values).ndim))
        )
        if not len(times):
            raise InputError("times: expected at least one instant, got none; give for example [0.0, 1.0]")
        if len(values) != len(times):
            raise InputError(f"values: expected {len(times)} rows, as many as times has, got {len(values)}")
        checks.rising("times", times)
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "values", values)

    def __call__(self, time: float) -> Array:
        """Value at an instant [s], a number or shape (k,)."""
        times, values = np.asarray(self.times), np.asarray(self.values)
        row = int(np.searchsorted(times, time, side="right"))
        if row in (0, len(times)):
            return np.asarray(values[min(row, len(times) - 1)])
        share = (time - times[row - 1]) / (times[row] - times[row - 1])
        return np.asarray(values[row - 1] + share * (values[row] - values[row - 1]))

    @cached_property
    def breaks(self) -> tuple[float, ...]:
        """Instants where the value jumps or its slope changes [s]: integrators step onto them."""
        times = np.asarray(self.times)
        values = np.asarray(self.values).reshape(len(times), -1)
        steps, rises = np.diff(times), np.diff(values, axis=0)
        jump = steps == 0.0
        slopes = np.where(jump[:, None], np.inf, rises / np.where(jump, 1.0, steps)[:, None])
        slopes = np.concatenate([np.zeros((1, values.shape[1])), slopes, np.zeros((1, values.shape[1]))])
        steepest = np.abs(slopes[np.isfinite(slopes)]).max(initial=0.0)
        with np.errstate(invalid="ignore"):
            bends = np.any(~(np.abs(np.diff(slopes, axis=0)) <= _SAME * steepest), axis=1)
        return tuple(dict.fromkeys(times[bends].tolist()))
