"""Drives: what becomes of a command before it acts. Pure functions of a memory and a command, once per interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.text import brief


class DriveMemory(NamedTuple):
    """What a drive of n numbers knows between two commands.

    Parameters
    ----------
    waiting
        Commands that are under way, the oldest last, shape (k, n).
    target
        What it is told to give now, shape (n,).
    output
        What it gives at the end of the interval, shape (n,).
    """

    waiting: Array
    target: Array
    output: Array


@dataclass(frozen=True, kw_only=True)
class Drive:
    """From commands to what acts, constant over an interval.

    A command is late, rounded, limited in size, then in its rate; a lag of first order follows it, of which the mean
    over the interval acts, so that its impulse is exact.

    Parameters
    ----------
    limit
        Largest size of each number, in the actuator's unit, > 0; a number, or one each; None is none.
    rate
        Largest change per second, > 0; None is none.
    lag
        Time constant of a first-order lag [s], >= 0.
    delay
        Time until a command acts [s], whole intervals, >= 0.
    resolution
        Step of the numbers, >= 0; 0 is none.
    monitor
        Whether tension or temperature that has pumped vibration up for two periods of the lowest mode is switched off:
        its commands are zero from then on.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    limit: float | Sequence[float] | None = None
    rate: float | None = None
    lag: float = 0.0
    delay: float = 0.0
    resolution: float = 0.0
    monitor: bool = False
    __repr__ = brief

    def __post_init__(self) -> None:
        if self.limit is not None:
            given: Any = self.limit
            several = isinstance(given, Sequence | np.ndarray) and not isinstance(given, str)
            for value in (checks.numbers("limit", given).ravel().tolist() if several else None) or [given]:
                checks.positive("limit", value)
        if self.rate is not None:
            checks.positive("rate", self.rate)
        for name in ("lag", "delay", "resolution"):
            checks.non_negative(name, getattr(self, name))
        checks.flag("monitor", self.monitor)

    def start(self, count: int, interval: float) -> DriveMemory:
        """Memory at rest, for ``count`` numbers; InputError if it does not fit them, or the interval [s]."""
        limit = np.asarray(np.inf if self.limit is None else self.limit)
        if limit.shape not in ((), (count,)):
            raise InputError(
                f"limit: expected one number, or {count} for as many numbers of the actuator, got {limit.size}; give "
                "one for all"
            )
        late = self.delay / interval
        if abs(late - round(late)) > 1e-6:
            raise InputError(
                f"delay: expected whole intervals of {interval:g} s, got {self.delay:g} s; set for example "
                f"delay = {max(1, round(late)) * interval:g}"
            )
        return DriveMemory(np.zeros((round(late), count)), *np.zeros((2, count)))

    def act(self, memory: DriveMemory, command: Array, interval: float) -> tuple[DriveMemory, Array]:
        """Memory behind a command, and what acts during its interval [s], shape (n,)."""
        waiting = np.concatenate([command[None], memory.waiting])
        waiting, target = waiting[:-1], waiting[-1]
        if self.resolution > 0.0:
            target = self.resolution * np.round(target / self.resolution)
        if self.limit is not None:
            limit = np.broadcast_to(np.asarray(self.limit, dtype=float), target.shape)
            target = np.clip(target, -limit, limit)
        if self.rate is not None:
            reach = self.rate * interval
            target = memory.target + np.clip(target - memory.target, -reach, reach)
        if self.lag == 0.0:
            return DriveMemory(waiting, target, target), target
        left = memory.output - target
        decay = np.exp(-interval / self.lag)
        return DriveMemory(waiting, target, target + decay * left), target + left * self.lag / interval * (1.0 - decay)
