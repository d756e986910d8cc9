"""What inputs come down to once they are bound to a structure.

Linear ones come in three kinds: a force whose nodal pattern is constant, a change of the initial stresses, or pressure
that follows the film. All are linear in a few numbers u; a stress acts through ``Gᵀ V B(g)ᵀ s u``: a force and a
stiffness for each number.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.loads.signals import Held, Signal, check_signal, value_at
from tautflex.numeric import Array, Indices


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

    def turned(self, q: Array) -> float:
        """Angle by which motion turns a direction that the input keeps [rad]."""
        return 0.0


@dataclass(frozen=True)
class MovedSupport(PreparedInput):
    """Held unknowns of the model that move, shape (n,), by shares, (n,), of a course: s, s' and s'' in time, (3,)."""

    dofs: Indices
    shares: Array
    course: Callable[[float], Array]


@dataclass(frozen=True)
class LinearInput(PreparedInput):
    """Input that is linear in a few numbers u, shape (n,).

    Parameters
    ----------
    function
        The numbers in time; None where a plant commands them.
    name
        Argument that the signal is, for messages.
    labels
        Name and unit of each number, for example ``"force_x [N]"``.
    lowest
        Least number that makes sense: cables cannot push.
    """

    function: Signal | None
    name: str
    labels: tuple[str, ...]
    lowest: float

    def __post_init__(self) -> None:
        check_signal(self.name, self.function)

    @property
    def count(self) -> int:
        """How many numbers there are."""
        return len(self.labels)

    def values(self, time: float) -> Array:
        """The numbers u at an instant [s], shape (n,).

        Raises
        ------
        InputError
            If there is no signal, or it gives too many or too few numbers, or such as make no sense.
        """
        if self.function is None:
            text = f"{self.name}: missing, expected a number, a TimeTable, a function of time, or Held numbers"
            raise InputError(f"{text}; give {self.name}=..., or command it as an actuator of a plant")
        value = value_at(self.name, self.function, time)
        if isinstance(self.function, Held) and value.shape == (self.count,) and value.min() >= self.lowest:
            return value
        if self.count > 1:
            value = checks.float_array(self.name, value, (self.count,))
        elif value.shape not in ((), (1,)) or not np.all(np.isfinite(value)):
            raise InputError(
                f"{self.name}: expected one finite number at t = {time:g} s, got {value.tolist()}; correct it"
            )
        if value.min() < self.lowest:
            text = f"{self.name}: expected numbers >= {self.lowest:g} at t = {time:g} s, got {value.min():g}"
            raise InputError(f"{text}; a cable cannot push")
        return np.atleast_1d(value)


@dataclass(frozen=True)
class PatternLoad(LinearInput):
    """Force whose nodal pattern is constant.

    Parameters
    ----------
    pattern
        Force on the free unknowns per number, shape (size, n).
    held
        Force, and torque about the origin, that supported directions take up per number, shape (6, n).
    internal
        Whether the spacecraft pushes against itself: the whole wrench of the input on it is zero, in any state.
    """

    pattern: Array
    held: Array
    internal: bool = False

    @property
    def idle(self) -> bool:
        """Whether supported directions take up all of the force; of a function of time any number may be one."""
        if self.function is None or callable(self.function):
            return not self.pattern.any()
        return bool(np.any(self.function)) and not self.load(0.0).any()

    def load(self, time: float) -> Array:
        """Force on the free unknowns [N, N m], shape (size,)."""
        return self.pattern @ self.values(time)

    def held_wrench(self, time: float) -> Array:
        """Force, and torque about the origin, that supported directions take up [N, N m], shape (6,)."""
        return self.held @ self.values(time)


@dataclass(frozen=True)
class StressChange(LinearInput):
    """Change of the initial stresses: ``columns[block]`` is that per number, shape (element, strain, n)."""

    columns: dict[int, Array]

    def stress(self, time: float) -> dict[int, Array]:
        """Change of initial stress by block number, shapes (element, strain)."""
        value = self.values(time)
        return {index: column @ value for index, column in self.columns.items()}


@dataclass(frozen=True)
class FilmPressure(LinearInput):
    """Pressure of one number that stays normal to the film; ``unit`` is that of 1 Pa."""

    unit: PressureLoad

    def follower(self, time: float) -> PressureLoad | None:
        """The pressure at an instant [s]."""
        value = float(self.values(time)[0])
        return self.unit.scaled(value) if value else None
