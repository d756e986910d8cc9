"""Inputs in time: what one is, and all of a run together.

Every input is a small frozen class in a file of its own that is bound to a system once (`prepare`) and then asked for
its load or its change of the initial stresses at an instant. Tension and temperature act through the initial stress,
so they drive the structure where tension does: in geometric stiffness as well as in force.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from tautflex import checks
from tautflex.errors import InputError, UnsupportedError
from tautflex.mechanics.loads.prepared import (
    FilmPressure,
    FollowerForce,
    LinearInput,
    MovedSupport,
    PatternLoad,
    PreparedInput,
    StressChange,
)
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.loads.time_table import TimeTable
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array


class TimeInput(ABC):
    """Anything that acts on a structure in time: a frozen dataclass that can be bound to a system.

    Where its function of time jumps, ``breaks`` lists the instants [s]: integrators step onto them. Those of a
    `TimeTable` among its fields need not be listed.
    """

    breaks: tuple[float, ...] = ()
    moves_supports: ClassVar[bool] = False

    @abstractmethod
    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system; raises InputError where it does not fit."""

    def equipped(self, system: StructuralSystem) -> StructuralSystem:
        """The structure that the input needs, for example with tendons; the given one itself if it is that already."""
        return system


class Effect(TimeInput):
    """What one unit of an input does to a structure; how much, and when, is its signal.

    The field that ``signal`` names is that signal: a number, a `TimeTable`, a function of time or `Held` numbers. An
    actuator has none (None): the plant commands it.
    """

    signal: ClassVar[str]

    def driven(self, signal: Signal | None) -> Self:
        """The same effect under another signal."""
        changed: dict[str, Any] = {self.signal: signal}
        return replace(self, **changed)  # type: ignore[type-var]


def _breaks(item: TimeInput) -> tuple[float, ...]:
    """Instants at which an input jumps, its own and those of its tables [s]."""
    tables = [value for value in vars(item).values() if isinstance(value, TimeTable)]
    return (*item.breaks, *(instant for table in tables for instant in table.breaks))


def require_equipped(item: TimeInput, system: StructuralSystem) -> None:
    """Raise InputError for a system that has not what the input needs."""
    if item.equipped(system) is not system:
        raise InputError(
            f"inputs: expected a structure equipped for {type(item).__name__}, whose tendons change its stiffness; use "
            "equip(state, inputs) in place of the state"
        )


def require_still(plant: str, inputs: Sequence[TimeInput]) -> Sequence[TimeInput]:
    """Return the inputs, or raise UnsupportedError for supports that move where the plant, in words, knows none."""
    for item in inputs:
        if item.moves_supports:
            raise UnsupportedError(
                f"inputs: expected supports that stand still {plant}, got {type(item).__name__}; simulate the full "
                "state without a hub, or hold the structure by a Spring and push it by a NodalForce"
            )
    return inputs


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

    Raises
    ------
    InputError
        If one of them does not fit the structure, or needs another one than this.
    """

    def __init__(self, system: StructuralSystem, inputs: Sequence[TimeInput]) -> None:
        for item in checks.several("inputs", inputs, TimeInput, "CableTension(...)"):
            checks.float_array("breaks", item.breaks, (None,))
            require_equipped(item, system)
        self.system, self._given = system, inputs
        self.breaks = tuple(instant for item in inputs for instant in _breaks(item))
        self._inputs = [item.prepare(system) for item in inputs]
        self._outside = [item for item in self._inputs if not (isinstance(item, PatternLoad) and item.internal)]

    def __bool__(self) -> bool:
        return bool(self._inputs)

    @property
    def given(self) -> Sequence[TimeInput]:
        """Inputs as they were given."""
        return self._given

    @property
    def named(self) -> list[tuple[str, PreparedInput]]:
        """Inputs bound to the system, each with the name and number of what was given."""
        pairs = zip(self._given, self._inputs, strict=True)
        return [(f"{type(given).__name__} number {number}", item) for number, (given, item) in enumerate(pairs, 1)]

    def load(self, time: float) -> Array:
        """Force on the free unknowns at an instant [s] [N, N m], shape (size,)."""
        return self._load(time, self._inputs)

    @property
    def internal(self) -> bool:
        """Whether the spacecraft pulls at itself, so that not the whole load pushes it."""
        return len(self._outside) < len(self._inputs)

    def outside_load(self, time: float) -> Array:
        """The part of the load that pushes the spacecraft, shape (size,)."""
        return self._load(time, self._outside)

    def _load(self, time: float, inputs: Iterable[PreparedInput]) -> Array:
        load = np.zeros(self.system.size)
        for item in inputs:
            part = item.load(time)
            if part is not None:
                load += part
        return load

    def loads(self, times: Array, before: float) -> Array:
        """The same at many instants, shape (time, size); a jump at ``before`` [s] is not met yet."""
        return np.array([self.load(earlier(float(time), before)) for time in times])

    def held_wrench(self, time: float) -> Array:
        """Force [N], and torque about the origin, on supported directions at an instant [s], shape (6,).

        That of internal forces is left out: what they pull at pulls back.
        """
        held = [part for item in self._outside if (part := item.held_wrench(time)) is not None]
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

    def idle(self) -> list[str]:
        """What a user should know about forces that move nothing where the supports' motion is prescribed."""
        return [
            f"inputs: {name} acts on supported directions alone; its whole force goes "
            "into the support, whose motion is prescribed, and moves nothing; push nodes that can move, or simulate "
            "on a FreeHub"
            for name, item in self.named
            if item.idle
        ]

    @property
    def moved(self) -> list[MovedSupport]:
        """Supports that move."""
        return [item for item in self._inputs if isinstance(item, MovedSupport)]

    @property
    def whole(self) -> StructuralSystem:
        """The system with the unknowns of supports that move behind the free ones."""
        dofs = np.unique(np.concatenate([np.zeros(0, np.int64), *(item.dofs for item in self.moved)]))
        return self.system.with_moved(dofs) if dofs.size else self.system

    def changes_stress(self) -> bool:
        """Whether an input acts through the initial stress."""
        return any(isinstance(item, StressChange) or bool(item.stress(0.0)) for item in self._inputs)

    @cached_property
    def linear(self) -> list[LinearInput]:
        """Inputs that are linear in a few numbers u, in order: `PatternLoad`, `StressChange` or `FilmPressure`."""
        return [item for item in self._inputs if isinstance(item, LinearInput)]

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Name and unit of each number of the linear inputs, for example ``"force_x [N]"``."""
        return tuple(label for item in self.linear for label in item.labels)

    @cached_property
    def all_linear(self) -> bool:
        """Whether the numbers of the linear inputs are all that there is to know of an instant."""
        return all(isinstance(item, PatternLoad | StressChange | FilmPressure) for item in self._inputs)

    @cached_property
    def all_fixed(self) -> bool:
        """Whether all are forces or stresses of fixed patterns, which do not follow the motion."""
        return all(isinstance(item, PatternLoad | StressChange) for item in self._inputs)

    def values(self, time: float) -> Array:
        """Numbers u of the linear inputs at an instant [s], shape (n,)."""
        return np.concatenate([np.zeros(0), *self.each_value(time)])

    def each_value(self, time: float) -> list[Array]:
        """The same, one array for each of the linear inputs."""
        return [item.values(time) for item in self.linear]

    def load_of(self, values: Sequence[Array]) -> Array:
        """Force on the free unknowns, shape (size,), of inputs that are `all_fixed` with these values."""
        load = np.zeros(self.system.size)
        for item, value in zip(self.linear, values, strict=True):
            if isinstance(item, PatternLoad):
                load += item.pattern @ value
        return load

    @property
    def stressing(self) -> NDArray[np.bool_]:
        """Which of the linear inputs' numbers are stresses, shape (n,)."""
        return np.array([isinstance(item, StressChange) for item in self.linear for _ in item.labels], dtype=bool)

    @cached_property
    def pattern(self) -> Array:
        """Constant force on the free unknowns per number of the linear inputs, shape (size, n); 0 where none is."""
        empty = np.zeros((self.system.size, 0))
        parts = [_pattern(item, self.system.size) for item in self.linear]
        return np.concatenate([empty, *parts], axis=1)

    @cached_property
    def films(self) -> dict[int, PressureLoad]:
        """Place among the linear inputs' numbers -> pressure of 1 Pa that follows the film."""
        ends = np.cumsum([0, *(item.count for item in self.linear)])
        pairs = zip(ends.tolist(), self.linear, strict=False)
        return {first: item.unit for first, item in pairs if isinstance(item, FilmPressure)}

    @cached_property
    def force_at_rest(self) -> Array:
        """The same with the forces that follow the motion, as they are at rest, shape (size, n)."""
        force = self.pattern.copy()
        for place, unit in self.films.items():
            force[:, place] = unit.force(np.zeros(self.system.size))
        return force

    @cached_property
    def columns(self) -> dict[int, Array]:
        """Change of initial stress per number of the linear inputs by block, shapes (element, strain, n)."""
        whole: dict[int, Array] = {}
        first = 0
        for item in self.linear:
            for index, column in item.columns.items() if isinstance(item, StressChange) else ():
                filled = whole.setdefault(index, np.zeros((*column.shape[:2], len(self.labels))))
                filled[:, :, first : first + item.count] = column
            first += item.count
        return whole


def _pattern(item: LinearInput, size: int) -> Array:
    return item.pattern if isinstance(item, PatternLoad) else np.zeros((size, item.count))
