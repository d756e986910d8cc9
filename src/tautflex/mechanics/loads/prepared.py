"""What inputs come down to once they are bound to a structure: a pattern of forces, or a change of initial stresses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import PreparedInput
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.text import shown

TimeFunction = Callable[[float], ArrayLike] | ArrayLike
"""Constant, or function of time [s]."""


def value_at(name: str, function: TimeFunction, time: float) -> Array:
    """Value of a function of time, or of a constant; InputError, with the name of the argument, if it is no number."""
    value = function(time) if callable(function) else function
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: expected numbers at t = {time:g} s, got {shown(value)}") from None


@dataclass(frozen=True)
class PatternLoad(PreparedInput):
    """Force whose nodal pattern is constant.

    ``pattern`` gives the force on the free unknowns, shape (size, 3), ``held`` the wrench of the rest, shape (6, 3).
    """

    pattern: Array
    held: Array
    function: TimeFunction
    name: str

    def __post_init__(self) -> None:
        check_function(self.name, self.function)

    @property
    def idle(self) -> bool:
        """Whether supported directions take up all of the force; of a function of time any direction may be one."""
        if callable(self.function):
            return not self.pattern.any()
        return bool(np.any(self.function)) and not self.load(0.0).any()

    def load(self, time: float) -> Array:
        """Force on the free unknowns [N, N m], shape (size,)."""
        return self.pattern @ checks.vector3(self.name, value_at(self.name, self.function, time))

    def held_wrench(self, time: float) -> Array:
        """Force, and torque about the origin, that supported directions take up [N, N m], shape (6,)."""
        return self.held @ checks.vector3(self.name, value_at(self.name, self.function, time))


@dataclass(frozen=True)
class StressChange(PreparedInput):
    """Stress change linear in a few numbers: ``columns[block]`` has shape (element, strain, number)."""

    function: TimeFunction
    columns: dict[int, Array]
    count: int
    name: str

    def __post_init__(self) -> None:
        check_function(self.name, self.function)

    def stress(self, time: float) -> dict[int, Array]:
        """Change of initial stress by block number, shapes (element, strain)."""
        value = np.atleast_1d(value_at(self.name, self.function, time))
        if value.shape not in ((1,), (self.count,)) or not np.all(np.isfinite(value)):
            several = "" if self.count == 1 else f", or {self.count} of them"
            raise InputError(f"{self.name}: expected one finite number{several}, got {value.tolist()}; correct it")
        value = np.broadcast_to(value, (self.count,))
        return {index: column @ value for index, column in self.columns.items()}


def check_function(name: str, function: TimeFunction) -> None:
    """Raise InputError for a function of anything but the time."""
    if callable(function):
        checks.function(name, function, "time")


def checked_nodes(system: StructuralSystem, nodes: Sequence[int]) -> Indices:
    """Node numbers as an array; InputError if there is none, one is not in the model, or one stands twice."""
    found = checks.indices("nodes", nodes, len(system.model.nodes))
    if not len(found):
        raise InputError("nodes: expected at least one node, got none; give its number")
    if len(np.unique(found)) < len(found):
        raise InputError(f"nodes: expected every node once, got {found.tolist()}; leave repeated ones out")
    return found


def nodal_pattern(system: StructuralSystem, nodes: Sequence[int], share: Array) -> tuple[Array, Array]:
    """Force on free unknowns and wrench of the others (`PatternLoad`), where each node gets its share."""
    pattern, held = np.zeros((system.size + 1, 3)), np.zeros((6, 3))
    for node, part in zip(checked_nodes(system, nodes), share, strict=True):
        place = system.place[system.model.translation_dofs[node]]
        pattern[place, range(3)] += part
        forces = part * np.diag(place == system.size)
        held += np.concatenate([forces, np.cross(system.model.nodes[node], forces).T])
    return pattern[:-1], held
