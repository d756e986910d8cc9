"""A structure compiled for computation: free unknowns, one kernel call per block, one sparsity pattern."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from tautflex.elements import ElementBlock, element_blocks
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.mechanics.kernel import add_average_forces, add_forces, restart_energy, smallest_principal_value
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.mechanics.store import build_store, python_view
from tautflex.mechanics.tangent import add_tangent
from tautflex.structure.model import Model

Array = NDArray[np.float64]


class StructuralSystem:
    """Elastic forces, tangents and inertia of a model on its free unknowns.

    Parameters
    ----------
    model
        The structure.
    initial_stress
        Stress of each block at zero unknowns; by default the prestress given with the model.

    Notes
    -----
    Vectors of free unknowns have shape (size,) in the order of ``model.free_dofs``.
    """

    def __init__(self, model: Model, initial_stress: list[Array] | None = None) -> None:
        self.model = model
        self.blocks: tuple[ElementBlock, ...] = element_blocks(model)
        self.size = len(model.free_dofs)
        place = np.full(model.dof_count, self.size, dtype=np.int64)
        place[model.free_dofs] = np.arange(self.size)
        self.place = place
        self._dofs = [place[block.dofs] for block in self.blocks]
        self._places = [np.ascontiguousarray(dofs.T).astype(np.uint32) for dofs in self._dofs]
        self.pattern = SparsityPattern.from_elements(self.size, self._dofs)
        self._slots = [self.pattern.upper_slots(dofs) for dofs in self._dofs]
        self._set_stress(initial_stress or [block.initial_stress for block in self.blocks])

    def _set_stress(self, initial_stress: list[Array]) -> None:
        self.initial_stress = initial_stress
        self.store: tuple[NDArray[Any], ...] = tuple(build_store(self.blocks, self._places, initial_stress))
        self._current_stress = [python_view(self.store, block).initial_stress for block in range(len(self.blocks))]
        for block in range(len(self.blocks)):
            restart_energy(self.store, block)
        self.stresses = np.concatenate([np.zeros(0), *(stress.ravel() for stress in self._current_stress)])
        ends = np.cumsum([stress.size for stress in self._current_stress])[:-1]
        pieces = np.split(self.stresses, ends) if self.blocks else []
        self._stress = [piece.reshape(stress.shape) for piece, stress in zip(pieces, self._current_stress, strict=True)]
        self._extended = np.zeros(self.size + 1)
        self._changed: set[int] = set()
        # What samples of a run look at: current stresses, as views, and constants of the films and cables.
        self.films = [
            (self._stress[i], self.blocks[i].material.poisson_ratio, self.blocks[i].measure / thickness, thickness)
            for i in self.block_index("membrane")
            for thickness in (self.model.groups[i].section.thickness,)  # type: ignore[union-attr]
        ]
        self.cables = [
            (self._stress[i][0], self.model.groups[i].section.area, not self.blocks[i].law.tension_only)  # type: ignore[union-attr]
            for i in self.block_index("cable")
        ]

    def with_initial_stress(
        self, initial_stress: list[Array], blocks: tuple[ElementBlock, ...] | None = None
    ) -> StructuralSystem:
        """Same structure with other initial stresses (and, if given, blocks of the same shape); the rest is shared."""
        twin = object.__new__(StructuralSystem)
        twin.__dict__.update(self.__dict__)
        twin.blocks = blocks or self.blocks
        twin._set_stress(initial_stress)
        return twin

    def change_initial_stress(self, change: dict[int, Array]) -> None:
        """Add to the initial stresses of some blocks, in place of any earlier change.

        Parameters
        ----------
        change
            Block number -> stress added to ``initial_stress``, shape (element, strain); blocks that are left out get
            their initial stress back.
        """
        for index in self._changed | set(change):
            current = self._current_stress[index]
            current[:] = self.initial_stress[index].T
            if index in change:
                current += change[index].T
            restart_energy(self.store, index)
        self._changed = set(change)

    def linear_strain(self, q: Array) -> list[Array]:
        """Linear part of the strains of each block at free unknowns ``q``, shapes (element, strain)."""
        extended = self.extended(q)
        return [
            np.einsum("nij,nj->ni", block.gradient, extended[dofs]) @ block.linear.T
            for block, dofs in zip(self.blocks, self._dofs, strict=True)
        ]

    @property
    def element_places(self) -> list[NDArray[np.int64]]:
        """Place of every element unknown among the free ones, ``size`` where it is held, shapes (element, dof)."""
        return self._dofs

    @property
    def stress(self) -> list[Array]:
        """Stress of each block at the last `force` call, shapes (element, strain)."""
        return [stress.T for stress in self._stress]

    @cached_property
    def inertia(self) -> InertiaOperator:
        """Inertia operator on the free unknowns."""
        return self._inertia_of(range(len(self.blocks)))

    def inertia_of(self, kind: str) -> InertiaOperator:
        """Inertia operator of the blocks of one kind, on all free unknowns."""
        return self._inertia_of(self.block_index(kind))

    def _inertia_of(self, chosen: Iterable[int]) -> InertiaOperator:
        chosen = list(chosen)
        blocks, places = [self.blocks[i] for i in chosen], [self._places[i] for i in chosen]
        slots = [self.pattern.element_slots(self._dofs[i]) for i in chosen]
        return InertiaOperator.from_blocks(blocks, places, slots, self.pattern)

    def extended(self, q: Array) -> Array:
        """Free unknowns with the zero of all supported ones behind them (a reused buffer)."""
        self._extended[:-1] = q
        return self._extended

    def force(self, q: Array) -> tuple[Array, float]:
        """Internal force and strain energy; the stresses of all elements are then in ``stress``.

        Parameters
        ----------
        q
            Free unknowns [m, rad], shape (size,).

        Returns
        -------
        force
            Internal force [N, N m], shape (size,).
        energy
            Work of the stresses from zero unknowns [J].
        """
        force = np.zeros(self.size + 1)
        energy = add_forces(self.store, self.extended(q), force, self.stresses, True, True)
        return force[:-1], energy

    def strain_energy(self, q: Array) -> float:
        """Work of the stresses from zero unknowns [J]; the stresses of all elements are then in ``stress``."""
        return float(add_forces(self.store, self.extended(q), self._extended, self.stresses, False, True))

    def average_force(self, start: Array, end: Array) -> Array:
        """Internal force [N, N m] of the average stress between two states, shape (size,).

        Its work on ``end - start`` is the change of the strain energy [theory.md 8].
        """
        before, after = np.append(start, 0.0), np.append(end, 0.0)
        force = np.zeros(self.size + 1)
        add_average_forces(self.store, before, after, force)
        return force[:-1]

    def upper_tangent(self, q: Array) -> Array:
        """Upper triangle of the tangent stiffness [N/m ...] at free unknowns ``q``, shape (upper entries,)."""
        extended, values = self.extended(q), np.zeros(len(self.pattern.upper[0]) + 1)
        for block, slots in enumerate(self._slots):
            add_tangent(self.store, block, extended, slots, values)
        return values[:-1]

    def tangent(self, q: Array) -> Array:
        """Values of the tangent stiffness [N/m ...] at free unknowns ``q`` in the pattern, shape (entries,)."""
        values: Array = self.upper_tangent(q)[self.pattern.from_upper]
        return values

    def matrix(self, values: Array) -> csc_array:
        """Sparse matrix of values in the pattern."""
        return self.pattern.matrix(values)

    def full(self, q: Array) -> Array:
        """All unknowns of the model from the free ones, shape (..., dof)."""
        result = np.zeros((*q.shape[:-1], self.model.dof_count))
        result[..., self.model.free_dofs] = q
        return result

    def translations(self, q: Array) -> Array:
        """Nodal displacements [m] from free unknowns, shape (..., node, 3)."""
        return self.full(q)[..., self.model.translation_dofs]

    def block_index(self, kind: str) -> list[int]:
        """Positions of the blocks of one kind."""
        return [index for index, block in enumerate(self.blocks) if block.kind == kind]

    def stress_of(self, kind: str, stress: list[Array] | None = None) -> Array:
        """Stresses of all elements of a kind at the last `force` call, shape (element, strain)."""
        source = self.stress if stress is None else stress
        found = [source[index] for index in self.block_index(kind)]
        return np.concatenate(found) if found else np.zeros((0, 1))

    def smallest_principal_resultant(self) -> float:
        """Smallest principal film resultant [N/m] at the last `force` call; NaN without a film."""
        smallest = [
            smallest_principal_value(stress) * group.section.thickness  # type: ignore[union-attr]
            for group, stress in zip(self.model.groups, self._stress, strict=True)
            if group.section.kind == "membrane"
        ]
        return min(smallest, default=float("nan"))

    def principal_resultants(self, stress: list[Array] | None = None) -> Array:
        """Smaller and larger principal membrane resultant [N/m] of each film element, shape (element, 2)."""
        source = self.stress if stress is None else stress
        found = []
        for group, block, values in zip(self.model.groups, self.blocks, source, strict=True):
            if block.kind == "membrane":
                found.append(principal_values(values) * group.section.thickness)  # type: ignore[union-attr]
        return np.concatenate(found) if found else np.zeros((0, 2))


def principal_values(stress: Array) -> Array:
    """Smaller and larger principal value of plane stresses (sx, sy, txy), shape (element, 3) -> (element, 2)."""
    mean = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    return np.stack([mean - radius, mean + radius], axis=1)
