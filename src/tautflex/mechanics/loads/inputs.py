"""Inputs in time: what one is, and all of a run together.

Every input is a small frozen class in a file of its own that is bound to a system once (`prepare`) and then asked for
its load or its change of the initial stresses at an instant. Tension and temperature act through the initial stress,
so they drive the structure where tension does: in geometric stiffness as well as in force.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.mechanics.loads.time_table import TimeTable
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array


class FollowerForce(Protocol):
    """Force that depends on the free unknowns q, shape (size,)."""

    def force(self, q: Array) -> Array:
        """Force on the free unknowns [N, N m], shape (size,)."""
        ...

    def mean_force(self, start: Array, end: Array) -> Array:
        """Its mean on the straight way between two states, shape (size,)."""
        ...

    def wrench(self, q: Array) -> Array:
        """Force [N], and torque about the origin [N m], on all nodes, held ones too, shape (6,)."""
        ...


class PreparedInput:
    """An input bound to a system; as it stands here, it does nothing."""

    @property
    def idle(self) -> bool:
        """Whether supported directions take up all of its force, so that it matters on a free hub alone."""
        return False

    def load(self, time: float) -> Array | None:
        """Force on the free unknowns [N, N m], shape (size,), or None."""
        return None

    def held_wrench(self, time: float) -> Array | None:
        """Force, and torque about the origin, that supported directions take up [N, N m], shape (6,), or None."""
        return None

    def follower(self, time: float) -> FollowerForce | None:
        """Force that depends on the motion, or None."""
        return None

    def stress(self, time: float) -> dict[int, Array]:
        """Change of initial stress by block number, shapes (element, strain)."""
        return {}


class TimeInput(ABC):
    """Anything that acts on a structure in time: a frozen dataclass that can be bound to a system.

    Where its function of time jumps, ``breaks`` lists the instants [s]: integrators step onto them. Those of a
    `TimeTable` among its fields need not be listed.
    """

    breaks: tuple[float, ...] = ()

    @abstractmethod
    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system; raises InputError where it does not fit."""


def _breaks(item: TimeInput) -> tuple[float, ...]:
    """Instants at which an input jumps, its own and those of its tables [s]."""
    tables = [value for value in vars(item).values() if isinstance(value, TimeTable)]
    return (*item.breaks, *(instant for table in tables for instant in table.breaks))


def earlier(time: float, jump: float) -> float:
    """The time, or the last one before a jump that is not met yet."""
    return min(time, float(np.nextafter(jump, -np.inf)))


class InputSet:
    """All inputs of a run.

    Parameters
    ----------
    system
        The structure.
    inputs
        The inputs.
    """

    def __init__(self, system: StructuralSystem, inputs: Sequence[TimeInput]) -> None:
        for item in checks.several("inputs", inputs, TimeInput, "CableTension(...)"):
            checks.float_array("breaks", item.breaks, (None,))
        self._size, self._given = system.size, inputs
        self.breaks = tuple(instant for item in inputs for instant in _breaks(item))
        self._inputs = [item.prepare(system) for item in inputs]

    def __bool__(self) -> bool:
        return bool(self._inputs)

    def load(self, time: float) -> Array:
        """Force on the free unknowns at an instant [s] [N, N m], shape (size,)."""
        load = np.zeros(self._size)
        for item in self._inputs:
            part = item.load(time)
            if part is not None:
                load += part
        return load

    def loads(self, times: Array, before: float) -> Array:
        """The same at many instants, shape (time, size); a jump at ``before`` [s] is not met yet."""
        return np.array([self.load(earlier(float(time), before)) for time in times])

    def held_wrench(self, time: float) -> Array:
        """Force [N], and torque about the origin [N m], on supported directions at an instant [s], shape (6,)."""
        held = [part for item in self._inputs if (part := item.held_wrench(time)) is not None]
        return np.sum(held, axis=0) if held else np.zeros(6)

    def followers(self, time: float) -> list[FollowerForce]:
        """Forces that depend on the motion, at an instant [s]."""
        return [part for item in self._inputs if (part := item.follower(time)) is not None]

    def stress(self, time: float) -> dict[int, Array]:
        """Change of initial stress at an instant [s] by block number, shapes (element, strain)."""
        change: dict[int, Array] = {}
        for item in self._inputs:
            for index, stress in item.stress(time).items():
                change[index] = change[index] + stress if index in change else stress
        return change

    def functions(self) -> list[tuple[str, Callable[[float], ArrayLike]]]:
        """Names and functions of time of the inputs that have one; of tables steps meet every row."""
        found = []
        for number, (given, item) in enumerate(zip(self._given, self._inputs, strict=True), 1):
            function = getattr(item, "function", None)
            if callable(function) and not isinstance(function, TimeTable):
                found.append((f"{type(given).__name__} number {number}", function))
        return found

    def idle(self) -> list[str]:
        """What a user should know about forces that move nothing where the supports' motion is prescribed."""
        return [
            f"inputs: {type(given).__name__} number {number} acts on supported directions alone; its whole force goes "
            "into the support, whose motion is prescribed, and moves nothing; push nodes that can move, or simulate "
            "on a FreeHub"
            for number, (given, item) in enumerate(zip(self._given, self._inputs, strict=True), 1)
            if item.idle
        ]

    def changes_stress(self) -> bool:
        """Whether an input acts through the initial stress."""
        return any(bool(item.stress(0.0)) for item in self._inputs)
