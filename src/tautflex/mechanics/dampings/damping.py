"""What a damping is asked, and what it is told."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.numeric import Array
from tautflex.structure.kinds import ByKind
from tautflex.text import brief

if TYPE_CHECKING:  # reading a case file asks for the numbers alone
    from scipy.sparse import csr_array

    from tautflex.mechanics.system import StructuralSystem


@dataclass(frozen=True)
class LinearStructure:
    """Small motion about the prestressed reference at rest, which dampings are made from.

    Parameters
    ----------
    system
        The structure.
    stiffness_entries
        Tangent of the reference in the system's pattern, shape (entries,).
    modes
        ``modes(n)``: angular frequencies of the n lowest natural modes [rad/s], shape (n,), in the order of
        `tautflex.solve_modes`, 0 for rigid and unstable ones; and mass-normalised vectors, shape (n, size).
    """

    system: StructuralSystem
    stiffness_entries: Array
    modes: Callable[[int], tuple[Array, Array]]
    __repr__ = brief

    @property
    def mass_matrix(self) -> csr_array:
        """M, shape (size, size)."""
        return self.system.inertia.mass_matrix

    @cached_property
    def by_kind(self) -> dict[str, tuple[Array, Array]]:
        """Mass M_e and material stiffness K_e of each kind of element in the pattern, shapes (entries,)."""
        material = self.system.material_stiffness()
        return {kind: (self.system.inertia_of(kind).mass_entries, own) for kind, own in material.items()}

    def projected(self, basis: Array) -> dict[str, tuple[Array, Array]]:
        """``Phi' M_e Phi`` and ``Phi' K_e Phi`` of each kind; ``basis`` holds Phi as rows, shape (r, size)."""

        def on_basis(entries: Array) -> Array:
            result: Array = basis @ (self.system.pattern.symmetric_matrix(entries) @ basis.T)
            return result

        return {kind: (on_basis(mass), on_basis(stiffness)) for kind, (mass, stiffness) in self.by_kind.items()}

    def entries(self, matrix: DampingMatrix) -> Array:
        """C without its vectors in the pattern, shape (entries,)."""
        kinds = self.by_kind if matrix.kinds else {}
        result: Array = matrix.proportional(self.system.inertia.mass_entries, self.stiffness_entries, kinds)
        return result


class Damping(ABC):
    """Viscous damping: a frozen dataclass that gives the matrix C of the force ``C v``.

    Implicit and explicit runs of full, reduced and hyper-reduced models, batches, spinning modes and participation
    take any subclass. In a batch, fields annotated ``float`` may differ from run to run, kind by kind of element where
    they do; `matrix` should then be plain arithmetic in them, and its vectors must not depend on them.
    """

    @abstractmethod
    def matrix(self, structure: LinearStructure) -> DampingMatrix:
        """Matrix for a structure, without its dampers."""

    def of(self, structure: LinearStructure) -> DampingMatrix:
        """`matrix` with the dampers of the structure."""
        return self.matrix(structure).joined(*structure.system.dampers)

    @property
    def numbers(self) -> dict[str, Any]:
        """Fields that a batch may vary, by name; ``beta.cable`` is the number of a kind of element."""
        found: dict[str, Any] = {}
        for name in (field.name for field in fields(self) if "float" in str(field.type)):  # type: ignore[arg-type]
            value = getattr(self, name)
            found |= {f"{name}.{kind}": value[kind] for kind in value} if isinstance(value, ByKind) else {name: value}
        return found

    def with_numbers(self, numbers: Mapping[str, Any]) -> Self:
        """Same damping with some of its `numbers` replaced, which are not checked."""
        changed = copy(self)
        for name, value in numbers.items():
            key, _, kind = name.partition(".")
            # Not `replace`: checks cannot look at a traced number.
            new = getattr(changed, key).with_values({kind: value}) if kind else value
            object.__setattr__(changed, key, new)
        return changed
