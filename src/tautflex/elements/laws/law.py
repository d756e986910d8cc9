"""What a constitutive law is: numbers, and one compiled function from elastic trial stress to stress [theory.md 2].

A law is one frozen dataclass in one file. Its fields are its options, `Law.parameters` turns them and a material into
the numbers of its compiled function, and `register_law` makes it known by its name. The kernel calls that function by
its address, so that laws from outside stand beside the project's own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, TypeVar

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from tautflex.errors import InputError
from tautflex.numeric import Array, jit
from tautflex.structure.materials import LAW_NAMES, Material, Section

_STRESS, _TANGENT, _VECTOR = types.float64[:, ::1], types.float64[:, :, ::1], types.float64[::1]
_SIGNATURE = types.void(_STRESS, _TANGENT, _VECTOR, _VECTOR, types.int64)


class Point(NamedTuple):
    """What a law makes of one trial stress: stress and tangent [Pa], stored energy [J/m^3]."""

    stress: Array
    tangent: Array
    energy: float


class LawFunction:
    """Compiled ``function(stress, tangent, energy, parameters, count)``; decorate the function of a law with it.

    The first ``count`` columns of ``stress`` (strain, point) hold elastic trial stresses [Pa] and are replaced by the
    law's; ``tangent`` (strain, strain, point) is filled with their derivatives by the strains [Pa], ``energy`` (point,)
    with the stored energy [J/m^3], whose derivative by the strains the stress must be: energies of runs and
    energy-conserving steps integrate the stress, so ``energy`` itself serves tests of the law alone.
    """

    def __init__(self, function: Callable[[Array, Array, Array, Array, int], None]) -> None:
        self.function = function

    @cached_property
    def _compiled(self) -> Any:
        options: dict[str, Any] = {"error_model": "numpy"}
        try:
            return numba.cfunc(_SIGNATURE, cache=True, **options)(self.function)
        except RuntimeError:  # written in a session: no file to keep the compiled function beside
            return numba.cfunc(_SIGNATURE, **options)(self.function)

    @property
    def address(self) -> int:
        """Where the machine code is; good in this process only."""
        return int(self._compiled.address)

    def at(self, trial: Array, parameters: tuple[float, ...]) -> Point:
        """Stress, tangent and energy at one trial stress, shapes (strain,) and (strain, strain)."""
        count = len(trial)
        stress, tangent, energy = np.array(trial, dtype=float)[:, None], np.zeros((count, count, 1)), np.zeros(1)
        call_law_once(self.address, stress, tangent, energy, np.array(parameters, dtype=float))
        return Point(stress[:, 0], tangent[:, :, 0], float(energy[0]))


def _call_law(context: Any, address: Any, stress: Any, tangent: Any, energy: Any, parameters: Any, count: Any) -> Any:
    signature = types.void(types.int64, *_SIGNATURE.args)

    def generate(target: Any, builder: Any, signature: Any, values: Any) -> Any:
        arguments = [target.get_value_type(kind) for kind in signature.args[1:]]
        pointer = builder.inttoptr(values[0], ir.FunctionType(ir.VoidType(), arguments).as_pointer())
        builder.call(pointer, values[1:])
        return target.get_dummy_value()

    return signature, generate


call_law: Any = intrinsic(_call_law)
"""``call_law(address, *arguments of a LawFunction)`` calls a law by its address, inside compiled code."""


@jit
def call_law_once(address: int, stress: Array, tangent: Array, energy: Array, parameters: Array) -> None:
    """Call a law for one point."""
    call_law(address, stress, tangent, energy, parameters, 1)


@dataclass(frozen=True)
class Law(ABC):
    """Base of constitutive laws: subclass it as a frozen dataclass whose fields are the law's options.

    Attributes
    ----------
    name
        How sections and case files call it.
    sections
        Kinds of section that may have it.
    function
        Compiled stress, tangent and energy; None for the elastic law, whose trial stress is the stress.
    average
        Its mean over a step of the energy-conserving method, in closed form and of the same signature. ``stress``
        (2 strain, point) holds the trial stresses at the start above those at the end, and the mean of the law's
        stress along the straight way between them replaces the former; ``tangent`` is filled with twice its derivative
        by the strains at the end, about, because it serves Newton's method only; ``energy`` is left alone. None: the
        mean is integrated numerically from ``function``, to round-off.
    tension_only
        Whether it gives way instead of carrying compression.
    """

    name: ClassVar[str] = ""
    sections: ClassVar[tuple[str, ...]] = ("membrane", "cable")
    function: ClassVar[LawFunction | None] = None
    average: ClassVar[LawFunction | None] = None
    tension_only: ClassVar[bool] = False

    def __init_subclass__(cls, **options: Any) -> None:
        """Take no average from the base along with a function of one's own."""
        super().__init_subclass__(**options)
        if "function" in vars(cls) and "average" not in vars(cls):
            cls.average = None

    @abstractmethod
    def parameters(self, material: Material) -> tuple[float, ...]:
        """Numbers that the compiled function gets."""

    @property
    def share(self) -> float:
        """Share of the elastic law left where this one gives way; 0 if it never does."""
        return 0.0

    def with_share(self, share: float) -> Law:
        """Same law with another share: statics walk from the elastic solution (1) to that of the law."""
        return self


@dataclass(frozen=True)
class TensionOnly(Law):
    """Base of laws that give way instead of carrying compression.

    Parameters
    ----------
    residual
        Share of the elastic law left where it gives way [-], so that Newton's tangent is never singular; the
        compression it leaves is that share of the elastic law's.
    """

    residual: float = 1e-7
    tension_only: ClassVar[bool] = True

    @property
    def share(self) -> float:
        """The residual."""
        return self.residual

    def with_share(self, share: float) -> Law:
        """Same law with another residual."""
        return replace(self, residual=share)


LAWS: dict[str, type[Law]] = {}
"""Laws by name."""

L = TypeVar("L", bound=type[Law])


def register_law(law: L) -> L:
    """Make a law known by its name; also a class decorator.

    Raises
    ------
    InputError
        If it is no `Law`, or its name is empty or another law's.
    """
    if not (isinstance(law, type) and issubclass(law, Law) and law.name):
        raise InputError(f"law: expected a subclass of tautflex.Law with a name, got {law!r}")
    known = LAWS.setdefault(law.name, law)
    if (known.__module__, known.__qualname__) != (law.__module__, law.__qualname__):
        raise InputError(f"law: expected a new name, got {law.name!r}, which {known.__qualname__} has; rename it")
    LAWS[law.name] = law
    for kind in law.sections:
        names = LAW_NAMES.setdefault(kind, [])
        if law.name not in names:
            names.append(law.name)
    return law


def law_of(section: Section) -> Law:
    """Law of a section, from its name or as it is."""
    given = "slack" if getattr(section, "slack", False) else getattr(section, "law", "elastic")
    law = LAWS[given]() if isinstance(given, str) else given
    if not isinstance(law, Law) or section.kind not in law.sections:
        known = ", ".join(LAW_NAMES[section.kind])
        raise InputError(f"law: expected a law for a {section.kind} (by name: {known}), got {given!r}")
    return law
