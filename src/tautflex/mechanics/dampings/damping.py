"""What a damping is asked, and what it is told."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.numeric import Array
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

    @property
    def stiffness_matrix(self) -> csr_array:
        """K, shape (size, size)."""
        return self.system.pattern.symmetric_matrix(self.stiffness_entries)


class Damping(ABC):
    """Viscous damping: a frozen dataclass that gives the matrix C of the force ``C v``.

    Implicit and explicit runs of full, reduced and hyper-reduced models, batches, spinning modes and participation
    take any subclass. In a batch, fields annotated ``float`` may differ from run to run; `matrix` should then be plain
    arithmetic in them, and its vectors must not depend on them.
    """

    @abstractmethod
    def matrix(self, structure: LinearStructure) -> DampingMatrix:
        """Matrix for a structure."""

    @property
    def numbers(self) -> dict[str, Any]:
        """Fields that a batch may vary, by name."""
        return {f.name: getattr(self, f.name) for f in fields(self) if "float" in str(f.type)}  # type: ignore[arg-type]
