"""Inputs of a batch: signals as functions of time and of numbers that may be traced, and what a unit of each does."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import jax.numpy as jnp
import numpy as np

from tautflex.batch.equations.rate_history import Numbers, RateHistory, Spin
from tautflex.batch.library import jax
from tautflex.errors import InputError, UnsupportedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.mechanics.loads.prepared import LinearInput, PatternLoad
from tautflex.mechanics.loads.time_table import TimeTable
from tautflex.numeric import Array

# A few units in the last place: on which side of a jump a function is asked.
_ASIDE = 1e-15

Signal = Callable[[Any, Any, Any], Any]
"""(values, time, an instant inside the stretch) -> numbers of an input."""


class BatchInputs:
    """Inputs that all runs have; amplitudes and tables may differ.

    Number k is multiplied by ``"inputs.k"``; ``"inputs.k.values"`` are its constant numbers, or the rows of its table.

    Parameters
    ----------
    given
        The inputs, bound to the structure.

    Raises
    ------
    UnsupportedError
        If an input is not linear in a few numbers, or a function of time is not one of `jax.numpy`.
    """

    def __init__(self, given: InputSet) -> None:
        self.given, self._signals = given, list[tuple[LinearInput, Signal, str]]()
        self.numbers: Numbers = {}
        for number, (name, item) in enumerate(given.named, 1):
            if not isinstance(item, LinearInput):
                raise UnsupportedError(
                    f"inputs: expected inputs that are linear in a few numbers in a batch, got {name}; simulate one "
                    "by one"
                )
            key = f"inputs.{number}"
            values, signal = _signal(name, item)
            self.numbers[key] = 1.0
            if values is not None:
                self.numbers[f"{key}.values"] = values
            self._signals.append((item, signal, key))

    def __bool__(self) -> bool:
        return bool(self._signals)

    def at(self, numbers: Numbers, time: Any, inside: Any) -> Any:
        """Numbers of all inputs at an instant of one run, shape (n,)."""
        parts = [
            numbers[key] * jnp.broadcast_to(signal(numbers.get(f"{key}.values"), time, inside), (item.count,))
            for item, signal, key in self._signals
        ]
        return jnp.concatenate(parts)

    def driving(self, history: RateHistory) -> RateHistory:
        """The history with these inputs."""
        if not self:
            return history

        def spin(numbers: Numbers, time: Any, inside: Any) -> Spin:
            own = {name: numbers[name] for name in history.numbers}
            return history.spin(own, time, inside)._replace(inputs=self.at(numbers, time, inside))

        def of_maneuver(function: Callable[[Numbers], Any] | None) -> Any:
            return function and (lambda numbers: function({name: numbers[name] for name in history.numbers}))

        return replace(
            history,
            numbers={**history.numbers, **self.numbers},
            key=(history.key, self.key),
            start=of_maneuver(history.start),
            breaks=of_maneuver(history.breaks),
            spin=spin,
            # What jumps at t = 0 has jumped when the run starts.
            jumps=(*history.jumps, *(instant for instant in self.given.breaks if instant > 0.0)),
        )

    def check(self, rows: Iterator[Mapping[str, Any]]) -> None:
        """Raise InputError for parameters with which a cable would push: signals that are numbers or tables."""
        for row in rows:
            for item, _, key in self._signals:
                values = row.get(f"{key}.values", self.numbers.get(f"{key}.values"))
                if values is not None:
                    least = float(np.min(row.get(key, 1.0) * np.asarray(values)))
                    if least < item.lowest:
                        raise InputError(
                            f"parameters: expected {key!r} to leave {item.name} >= {item.lowest:g}, got {least:g}; a "
                            "cable cannot push"
                        )

    @cached_property
    def key(self) -> Hashable:
        """What tells these inputs from others, but for their numbers."""
        columns = tuple((index, column.tobytes()) for index, column in self.given.columns.items())
        tables = tuple(
            np.asarray(item.function.times).tobytes() if isinstance(item.function, TimeTable) else item.function
            for item, _, key in self._signals
            if isinstance(item.function, TimeTable) or f"{key}.values" not in self.numbers
        )
        return self.given.force_at_rest.tobytes(), columns, tables, len(self._signals)

    def push(self, axis: Array, kept: Array) -> tuple[Array, Array]:
        """Torque about an axis through the origin of a unit of each input, shape (n,), and per coordinate, (n, r).

        Changes of stress, and what the spacecraft does to itself, push no hub; ``kept`` are the coordinates' vectors.
        """
        system, model = self.given.system, self.given.system.model
        places = system.place[model.translation_dofs]
        pattern, held, outside = np.zeros((system.size + 1, 0)), np.zeros(0), list[float]()
        for item, _, _ in self._signals:
            pushes = isinstance(item, PatternLoad) and not item.internal
            own = item.pattern if isinstance(item, PatternLoad) else np.zeros((system.size, item.count))
            pattern = np.append(pattern, np.append(own, np.zeros((1, item.count)), axis=0), axis=1)
            held = np.append(held, axis @ item.held[3:] if isinstance(item, PatternLoad) else np.zeros(item.count))
            outside += [float(pushes)] * item.count
        moved = np.append(kept, np.zeros((len(kept), 1)), axis=1)[:, places]
        arms = np.einsum("inb,nbk->ki", np.cross(axis, moved), pattern[places])
        torque = held + np.einsum("nb,nbk->k", np.cross(axis, model.nodes), pattern[places])
        turning = np.flatnonzero(np.diff(model.dof_offset) == 6)
        turned = pattern[system.place[model.dof_offset[turning][:, None] + np.arange(3, 6)]]
        torque = torque + np.einsum("b,nbk->k", axis, turned)
        torque, arms = np.asarray(outside) * torque, np.asarray(outside)[:, None] * arms
        for place, unit in self.given.films.items():
            torque[place] = axis @ unit.wrench(np.zeros(system.size))[3:]
            arms[place] = axis @ unit.wrench_slopes(kept)[3:]
        return torque, arms


def _signal(name: str, item: LinearInput) -> tuple[Any, Signal]:
    """Numbers that a signal is made of, None for a function of time; and what it is."""
    function: Any = item.function
    if isinstance(function, TimeTable):
        times = np.asarray(function.times)

        def tabled(values: Any, time: Any, inside: Any) -> Any:
            # Rows between two ends of steps lie on one straight line.
            row = jnp.searchsorted(times, inside, side="right")
            low, high = jnp.clip(row - 1, 0, len(times) - 1), jnp.clip(row, 0, len(times) - 1)
            left, values = jnp.asarray(times), jnp.asarray(values)
            width = left[high] - left[low]
            share = jnp.where(width > 0.0, (time - left[low]) / jnp.where(width > 0.0, width, 1.0), 0.0)
            return values[low] + share * (values[high] - values[low])

        return np.asarray(function.values), tabled
    if not callable(function):
        return np.asarray(item.values(0.0)), lambda values, time, inside: values

    def asked(values: Any, time: Any, inside: Any) -> Any:
        return jnp.asarray(function(time * (1.0 + _ASIDE * jnp.sign(inside - time))), dtype=float)

    try:
        jax.eval_shape(lambda time: asked(None, time, time), 0.0)
    except Exception as error:
        raise UnsupportedError(
            f"inputs: expected numbers, a TimeTable or a function of jax.numpy in a batch, got a function for {name} "
            f"that is none ({type(error).__name__}); tabulate it: TimeTable(times, values)"
        ) from error
    return None, asked
