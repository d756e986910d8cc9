"""Inputs in time: forces on nodes and edges, tension of cables, temperature of the film.

Every input is a small frozen class that is bound to a system once (`prepare`) and then asked for its load or its
change of the initial stresses at an instant. Tension and temperature act through the initial stress, so they drive
the structure where tension does: in geometric stiffness as well as in force.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import StructuralSystem

Array = NDArray[np.float64]
TimeFunction = Callable[[float], ArrayLike] | ArrayLike


class PreparedInput(Protocol):
    """An input bound to a system."""

    def load(self, time: float) -> Array | None:
        """Force on the free unknowns [N, N m], shape (size,), or None."""
        ...

    def stress(self, time: float) -> dict[int, Array]:
        """Change of initial stress by block number, shapes (element, strain)."""
        ...


class TimeInput(Protocol):
    """Anything that can be bound to a system.

    Where its function of time jumps, ``breaks`` lists the instants [s]: integrators step onto them.
    """

    breaks: tuple[float, ...]

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system; raises InputError where it does not fit."""
        ...


def _at(function: TimeFunction, time: float) -> Array:
    return np.asarray(function(time) if callable(function) else function, dtype=float)


@dataclass(frozen=True)
class _Load:
    """Force whose nodal pattern is constant.

    ``pattern`` gives the force on the free unknowns, shape (size, 3), ``held`` the wrench of the rest, shape (6, 3).
    """

    pattern: Array
    held: Array
    function: TimeFunction
    name: str

    def load(self, time: float) -> Array:
        return self.pattern @ checks.vector3(self.name, _at(self.function, time))

    def held_wrench(self, time: float) -> Array:
        """Force, and torque about the origin, that supported directions take up, shape (6,)."""
        return self.held @ checks.vector3(self.name, _at(self.function, time))

    def stress(self, time: float) -> dict[int, Array]:
        return {}


@dataclass(frozen=True)
class NodalForce:
    """Dead force on nodes, the same on each.

    Parameters
    ----------
    nodes
        Node numbers.
    force
        Force on every node in floating-frame axes [N], three numbers or a function of time.
    breaks
        Instants at which the function jumps [s].
    """

    nodes: Sequence[int]
    force: TimeFunction
    breaks: tuple[float, ...] = ()

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system."""
        return _Load(*_nodal_pattern(system, self.nodes, np.ones(len(self.nodes))), self.force, "force")


@dataclass(frozen=True)
class EdgeForce:
    """Dead force per length along a chain of nodes.

    Parameters
    ----------
    nodes
        Node numbers in order along the edge, at least two.
    force
        Force per length in floating-frame axes [N/m], three numbers or a function of time.
    breaks
        Instants at which the function jumps [s].
    """

    nodes: Sequence[int]
    force: TimeFunction
    breaks: tuple[float, ...] = ()

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system; each piece gives half of its length to either end (consistent for linear edges)."""
        if len(self.nodes) < 2:
            raise InputError(f"nodes: expected at least two nodes along an edge, got {list(self.nodes)}")
        points = system.model.nodes[_checked_nodes(system, self.nodes)]
        piece = np.linalg.norm(np.diff(points, axis=0), axis=1)
        share = 0.5 * (np.append(piece, 0.0) + np.insert(piece, 0, 0.0))
        return _Load(*_nodal_pattern(system, self.nodes, share), self.force, "force")


@dataclass(frozen=True)
class CableTension:
    """Change of cable tension in time, as an actuator that reels the cable makes it.

    Parameters
    ----------
    change
        Change of tension at unchanged length [N]: a number, one per selected cable, or a function of time.
    cables
        Numbers of the cables (order of ``model.cables``); None selects all.
    breaks
        Instants at which the function jumps [s].
    """

    change: TimeFunction
    cables: Sequence[int] | None = None
    breaks: tuple[float, ...] = ()

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with cables."""
        count = len(system.model.cables)
        if not count:
            raise InputError("CableTension: expected a model with cables, got none; add cables to the model")
        chosen = np.arange(count) if self.cables is None else np.asarray(self.cables)
        if chosen.size and (chosen.min() < 0 or chosen.max() >= count):
            raise InputError(f"cables: expected numbers in 0..{count - 1}, got {chosen.tolist()}")
        return _Stress(self.change, _cable_columns(system, chosen), chosen.size, "change")


@dataclass(frozen=True)
class FilmTemperature:
    """Uniform temperature change of the film.

    Parameters
    ----------
    change
        Temperature above the reference [K], a number or a function of time.
    expansion
        Coefficient of thermal expansion [1/K].
    breaks
        Instants at which the function jumps [s].
    """

    change: TimeFunction
    expansion: float
    breaks: tuple[float, ...] = ()

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film: stress change -D (expansion, expansion, 0) per kelvin."""
        blocks = system.block_index("membrane")
        if not blocks:
            raise InputError("FilmTemperature: expected a model with a film, got none; add triangles to the model")
        strain = checks.finite("expansion", self.expansion) * np.array([1.0, 1.0, 0.0])
        per_kelvin = {index: (-system.blocks[index].elasticity @ strain)[:, :, None] for index in blocks}
        return _Stress(self.change, per_kelvin, 1, "change")


@dataclass(frozen=True)
class _Stress:
    """Stress change linear in a few numbers: ``columns[block]`` has shape (element, strain, number)."""

    function: TimeFunction
    columns: dict[int, Array]
    count: int
    name: str

    def load(self, time: float) -> None:
        return None

    def stress(self, time: float) -> dict[int, Array]:
        value = np.atleast_1d(_at(self.function, time))
        if value.shape not in ((1,), (self.count,)) or not np.all(np.isfinite(value)):
            raise InputError(f"{self.name}: expected one or {self.count} finite numbers, got {value.tolist()}")
        value = np.broadcast_to(value, (self.count,))
        return {index: column @ value for index, column in self.columns.items()}


def _cable_columns(system: StructuralSystem, chosen: NDArray[np.int64]) -> dict[int, Array]:
    """Stress per newton for every cable block, shapes (element, 1, chosen)."""
    columns, first = {}, 0
    for index in system.block_index("cable"):
        group = system.model.groups[index]
        column = np.zeros((len(group.connectivity), 1, chosen.size))
        for number, cable in enumerate(chosen):
            if first <= cable < first + len(column):
                column[cable - first, 0, number] = 1.0 / group.section.area  # type: ignore[union-attr]
        columns[index] = column
        first += len(column)
    return columns


def _checked_nodes(system: StructuralSystem, nodes: Sequence[int]) -> NDArray[np.int64]:
    return checks.index_array("nodes", np.reshape(np.asarray(nodes), (-1, 1)), 1, len(system.model.nodes))[:, 0]


def _nodal_pattern(system: StructuralSystem, nodes: Sequence[int], share: Array) -> tuple[Array, Array]:
    """Forces on the free unknowns, and wrench of the others, where each node gets its share of a force; see `_Load`."""
    pattern, held = np.zeros((system.size + 1, 3)), np.zeros((6, 3))
    for node, part in zip(_checked_nodes(system, nodes), share, strict=True):
        place = system.place[system.model.translation_dofs[node]]
        pattern[place, range(3)] += part
        forces = part * np.diag(place == system.size)
        held += np.concatenate([forces, np.cross(system.model.nodes[node], forces).T])
    return pattern[:-1], held


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
        for item in inputs:
            if not hasattr(item, "prepare"):
                raise InputError(f"inputs: expected objects such as CableTension(...), got {item!r}")
        self._size = system.size
        self.breaks = tuple(instant for item in inputs for instant in item.breaks)
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

    def held_wrench(self, time: float) -> Array:
        """Force [N], and torque about the origin [N m], on supported directions at an instant [s], shape (6,)."""
        held = [item.held_wrench(time) for item in self._inputs if isinstance(item, _Load)]
        return np.sum(held, axis=0) if held else np.zeros(6)

    def stress(self, time: float) -> dict[int, Array]:
        """Change of initial stress at an instant [s] by block number, shapes (element, strain)."""
        change: dict[int, Array] = {}
        for item in self._inputs:
            for index, stress in item.stress(time).items():
                change[index] = change[index] + stress if index in change else stress
        return change

    def changes_stress(self) -> bool:
        """Whether an input acts through the initial stress."""
        return any(bool(item.stress(0.0)) for item in self._inputs)
