"""What a control law is, what linear ones share, and how laws add."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from tautflex import checks
from tautflex.control.signals import LoopSpec, Reference
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.text import brief, shown

T = TypeVar("T")


class ControlLaw(ABC):
    """From measurements to commands, once per interval: a frozen dataclass of pure functions.

    Laws add: the commands of ``a + b`` are the sums of theirs. A function (time, measurement) -> command may stand in
    place of a law.
    """

    follows_reference: ClassVar[bool] = True
    """Whether what the hub is to follow changes its commands, so that a shaper can stand before it."""

    @abstractmethod
    def start(self, spec: LoopSpec) -> Any:
        """Memory before the first measurement.

        Raises
        ------
        InputError
            If the loop has not what the law needs.
        """

    @abstractmethod
    def act(self, memory: Any, measurement: Array, reference: Reference) -> tuple[Any, Array]:
        """New memory, and the command until the next measurement, shape (commands,)."""

    def matrices(self, spec: LoopSpec) -> LawMatrices | None:
        """The law as matrices at the interval of a loop, which compiled loops can run; None if it is not linear."""
        return None

    def __add__(self, other: ControlLaw | Callable[[float, Array], ArrayLike]) -> ControlLaw:
        return added(self, law_of("law", other))

    def __radd__(self, other: ControlLaw | Callable[[float, Array], ArrayLike]) -> ControlLaw:
        return added(law_of("law", other), self)


def own_memory(given: Any, kind: type[T]) -> T:
    """Memory of a law if it is of its kind, or InputError."""
    return checks.instance(
        "memory", given, kind, "what start(spec) of this law gave", remedy="go on from what act gave last"
    )


class LawMatrices(NamedTuple):
    """A linear law in discrete time: ``u = C x + D z + d``, then ``x <- A x + B z + b``, x = 0 at the start.

    z holds the measurement, then the reference's attitude, rate and acceleration.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    b: Array
    d: Array

    @classmethod
    def of(cls, a: Array, b: Array, c: Array, d: Array, level: Array | None = None) -> LawMatrices:
        """Matrices whose z is counted from a level, the first numbers of which are given, shape (measurement,)."""
        shift = np.zeros(d.shape[1])
        if level is not None:
            shift[: len(level)] = level
        return cls(a, b, c, d, -b @ shift, -d @ shift)

    @classmethod
    def static(cls, gain: Array) -> LawMatrices:
        """``u = gain z``."""
        return cls.of(np.zeros((0, 0)), np.zeros((0, gain.shape[1])), np.zeros((len(gain), 0)), gain)


class LinearMemory(NamedTuple):
    """Matrices of a law, and its state x."""

    matrices: LawMatrices
    x: Array


class LinearLaw(ControlLaw):
    """Law that is nothing but its `matrices`."""

    @abstractmethod
    def matrices(self, spec: LoopSpec) -> LawMatrices:
        """Matrices at the interval of a loop."""

    def start(self, spec: LoopSpec) -> LinearMemory:
        """Matrices, and x = 0."""
        found = self.matrices(spec)
        return LinearMemory(found, np.zeros(len(found.A)))

    def act(self, memory: LinearMemory, measurement: Array, reference: Reference) -> tuple[LinearMemory, Array]:
        """One product with each of the four matrices."""
        (matrices, x), z = own_memory(memory, LinearMemory), np.concatenate([measurement, reference.numbers])
        if len(z) != matrices.D.shape[1]:
            raise InputError(
                f"measurement: expected {matrices.D.shape[1]} numbers with those of the reference, got {len(z)}; give "
                "what the sensors and axes of the loop tell, which the law was started for"
            )
        command = matrices.C @ x + matrices.D @ z + matrices.d
        return LinearMemory(matrices, matrices.A @ x + matrices.B @ z + matrices.b), command


@dataclass(frozen=True)
class FunctionLaw(ControlLaw):
    """A function of yours as a law.

    Parameters
    ----------
    function
        (time [s], measurement) -> command, one number or one per command.
    """

    function: Callable[[float, Array], ArrayLike]
    follows_reference: ClassVar[bool] = False
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.function("function", self.function, "time", "measurement")

    def start(self, spec: LoopSpec) -> int:
        """Remember the number of commands."""
        return len(spec.commanded)

    def act(self, memory: int, measurement: Array, reference: Reference) -> tuple[int, Array]:
        """What the function gives."""
        given = checks.numbers("command", self.function(reference.time, measurement))
        count = own_memory(memory, int)
        return memory, checks.spread("command", given.ravel() if given.size > 1 else given.reshape(()), count)


@dataclass(frozen=True)
class SumOfLaws(ControlLaw):
    """Several laws whose commands add.

    Parameters
    ----------
    laws
        Their order does not matter.
    """

    laws: tuple[ControlLaw, ...]

    def start(self, spec: LoopSpec) -> tuple[Any, ...]:
        """Memories of all."""
        return tuple(law.start(spec) for law in self.laws)

    def act(self, memory: tuple[Any, ...], measurement: Array, reference: Reference) -> tuple[tuple[Any, ...], Array]:
        """Sum of their commands."""
        if len(own_memory(memory, tuple)) != len(self.laws):
            raise InputError(f"memory: expected one for each of the {len(self.laws)} laws, got {len(memory)}")
        pairs = [law.act(own, measurement, reference) for law, own in zip(self.laws, memory, strict=True)]
        return tuple(own for own, _ in pairs), np.sum([command for _, command in pairs], axis=0)

    def matrices(self, spec: LoopSpec) -> LawMatrices | None:
        """All side by side, if all are linear."""
        parts = [found for law in self.laws if (found := law.matrices(spec)) is not None]
        if len(parts) < len(self.laws):
            return None
        return LawMatrices(
            block_diag(*(part.A for part in parts)),
            np.concatenate([part.B for part in parts]),
            np.concatenate([part.C for part in parts], axis=1),
            np.sum([part.D for part in parts], axis=0),
            np.concatenate([part.b for part in parts]),
            np.sum([part.d for part in parts], axis=0),
        )


def added(*laws: ControlLaw) -> ControlLaw:
    """Sum of laws."""
    parts: list[ControlLaw] = []
    for law in laws:
        parts += law.laws if isinstance(law, SumOfLaws) else (law,)
    return SumOfLaws(tuple(parts))


def law_of(name: str, given: Any) -> ControlLaw:
    """Law that was given as such or as a function; InputError if it is neither."""
    if isinstance(given, ControlLaw):
        return given
    if callable(given) and not isinstance(given, type):
        return FunctionLaw(given)
    raise InputError(
        f"{name}: expected a control law such as PD(...), or a function (time, measurement) -> command, got "
        f"{shown(given)}; write the law's name with its numbers in brackets"
    )
