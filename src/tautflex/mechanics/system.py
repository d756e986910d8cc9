"""A structure compiled for computation: free unknowns, element blocks, one pattern. Frozen: runs may share it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, hstack

from tautflex import checks
from tautflex.elements import ElementBlock, element_blocks
from tautflex.elements.laws import Elastic
from tautflex.mechanics.inertia import InertiaOperator, WeighedMoments
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.mechanics.point_masses import KIND as BODIES
from tautflex.mechanics.point_masses import BodyBlock, body_block
from tautflex.mechanics.springs import damper_rates, spring_block
from tautflex.mechanics.store import build_store
from tautflex.mechanics.surface import FilmSurface
from tautflex.mechanics.workspace import Workspace
from tautflex.numeric import Array, Indices, Places
from tautflex.structure.model import Model


@dataclass(frozen=True)
class StructuralSystem:
    """Elastic forces, tangents and inertia of a model on its free unknowns, as pure functions.

    What calls them over and over (a run, an iteration) takes a `workspace` of its own instead. ``blocks`` and
    ``initial_stress``, the stresses at zero unknowns, shapes (row, strain), follow ``model.element_groups``, springs
    behind them; ``pattern`` holds all square operators on the free unknowns, ``upper_slots`` the rows' places in its
    upper triangle, by block. Vectors of free unknowns have shape (size,) in the order of ``model.free_dofs``; held ones
    that somebody moves, ``moved``, stand behind these as if they were free (`with_moved`).
    """

    model: Model
    blocks: tuple[ElementBlock, ...]
    initial_stress: tuple[Array, ...]
    pattern: SparsityPattern
    upper_slots: list[Places]
    moved: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __repr__(self) -> str:
        return f"StructuralSystem({self.size} unknowns, {len(self.blocks)} groups of elements)"

    @classmethod
    def from_model(cls, model: Model) -> StructuralSystem:
        """Compile a model with the prestress given with it."""
        blocks = (*element_blocks(model), *([spring_block(model)] if model.springs else []))
        places = [model.free_places[block.dofs] for block in blocks]
        # Bodies on linked nodes couple what no element does.
        bodies = [model.free_places[body_block(model).dofs]] if model.masses and model.links else []
        pattern = SparsityPattern.from_elements(len(model.free_dofs), [*places, *bodies])
        slots = [pattern.upper_slots(block.rows_of(own)) for block, own in zip(blocks, places, strict=True)]
        return cls(model, blocks, tuple(block.initial_stress for block in blocks), pattern, slots)

    def with_initial_stress(
        self, initial_stress: Iterable[Array], blocks: tuple[ElementBlock, ...] | None = None
    ) -> StructuralSystem:
        """Same structure with other initial stresses (and, if given, blocks of the same shape); the rest is shared."""
        return replace(self, initial_stress=tuple(initial_stress), blocks=blocks or self.blocks)

    def with_moved(self, dofs: Indices) -> StructuralSystem:
        """Same structure with some held unknowns of the model, shape (n,), behind the free ones."""
        size = len(self.model.free_dofs) + len(dofs)
        places = [_place(self.model, dofs)[block.dofs] for block in self.blocks]
        bodies = [_place(self.model, dofs)[body.dofs] for body in self._bodies]
        pattern = SparsityPattern.from_elements(size, [*places, *bodies])
        slots = [pattern.upper_slots(block.rows_of(own)) for block, own in zip(self.blocks, places, strict=True)]
        return replace(self, pattern=pattern, upper_slots=slots, moved=dofs)

    @property
    def size(self) -> int:
        """Number of free unknowns."""
        return self.pattern.size

    @cached_property
    def place(self) -> Indices:
        """Free unknown of every unknown of the model, ``size`` where it is held or linked, shape (dof + 1,)."""
        return _place(self.model, self.moved)

    @cached_property
    def expansion(self) -> csr_array:
        """All unknowns of the model from the free ones, shape (dof, size)."""
        if not self.moved.size:
            return self.model.expansion
        result = csr_array(hstack([self.model.expansion, self.model.constraints.matrix[:-1][:, self.moved]]))
        result.sort_indices()
        return result

    @cached_property
    def row_places(self) -> list[Indices]:
        """The same for the unknowns of every row (integration point) of the blocks, shapes (row, dof)."""
        return [block.rows_of(self.place[block.dofs]) for block in self.blocks]

    @cached_property
    def surface(self) -> FilmSurface:
        """The film as a reflecting surface."""
        return FilmSurface(self.model, self.expansion)

    @cached_property
    def inertia(self) -> InertiaOperator:
        """Inertia operator on the free unknowns."""
        return self._inertia([*self.blocks, *self._bodies])

    def inertia_of(self, kind: str) -> InertiaOperator:
        """Inertia operator of the blocks of one kind, or of the point masses, on all free unknowns."""
        own = [self.blocks[index] for index in self.block_index(kind)]
        return self._inertia([*own, *(self._bodies if kind == BODIES else ())])

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of element, ``"mass"`` for point masses last."""
        return tuple(dict.fromkeys([*(block.kind for block in self.blocks), *([BODIES] if self._bodies else [])]))

    @cached_property
    def _bodies(self) -> tuple[BodyBlock, ...]:
        """Point masses of the model, if it has some."""
        return (body_block(self.model),) if self.model.masses else ()

    @cached_property
    def dampers(self) -> tuple[Array, Array]:
        """Dampers as ``sum_k c_k v_k v_k'``: v on the free unknowns, shape (rank, size), and c, shape (rank,)."""
        vectors, coefficients = damper_rates(self.model)
        return np.ascontiguousarray(self.on_free(vectors.T).T), coefficients

    def material_stiffness(self) -> dict[str, Array]:
        """Stiffness of each kind of element at zero unknowns less the part of its stress, shapes (entries,).

        Together with the stiffness of the prestress they make the tangent.
        """
        still = np.zeros(self.size)
        soft = (replace(block, elasticity=np.zeros_like(block.elasticity), law=Elastic()) for block in self.blocks)
        whole = self.workspace()
        stressed = self.with_initial_stress(self.stress(still), tuple(soft)).workspace()
        index = {kind: self.block_index(kind) for kind in self.kinds}
        none = np.zeros(self.pattern.entries)
        return {
            kind: whole.tangent(still, own) - stressed.tangent(still, own) if own else none
            for kind, own in index.items()
        }

    def load_moments(self, factors: Mapping[str, float]) -> WeighedMoments:
        """Load moments of all blocks, those of each kind times its factor."""
        loads = np.zeros((12, self.size))
        for kind in self.kinds:
            inertia = self.inertia_of(kind)
            loads += factors[kind] * np.concatenate([inertia.first_moment.reshape(9, -1), inertia.zeroth_moment])
        return WeighedMoments(loads)

    def _inertia(self, blocks: Sequence[ElementBlock | BodyBlock]) -> InertiaOperator:
        return InertiaOperator.from_blocks(
            [block.inertia for block in blocks], [self.place[block.dofs] for block in blocks], self.pattern
        )

    @cached_property
    def store(self) -> tuple[NDArray[Any], ...]:
        """All blocks as compiled code reads them; never written to."""
        slots = [places.T.astype(np.uint32) for places in self.row_places]
        return tuple(build_store(self.blocks, slots, list(self.initial_stress)))

    def __getstate__(self) -> dict[str, Any]:
        # Addresses of compiled laws mean nothing in another process.
        return {name: value for name, value in self.__dict__.items() if name != "store"}

    def workspace(self) -> Workspace:
        """Make buffers for repeated evaluations; every run has its own."""
        return Workspace(self.store, self.initial_stress, self.pattern, self.upper_slots)

    def force(self, q: Array) -> tuple[Array, float]:
        """Internal force [N, N m], shape (size,), and work of the stresses from zero unknowns [J]."""
        return self.workspace().force(q)

    def stress(self, q: Array) -> list[Array]:
        """Stress of each block at free unknowns ``q``, shapes (row, strain)."""
        workspace = self.workspace()
        workspace.strain_energy(q)
        return workspace.stress

    def tangent(self, q: Array) -> Array:
        """Values of the tangent stiffness [N/m ...] at free unknowns ``q`` in the pattern, shape (entries,)."""
        return self.workspace().tangent(q)

    def linear_strain(self, q: Array) -> list[Array]:
        """Linear part of the strains of each block at free unknowns ``q``, shapes (row, strain)."""
        extended = np.append(q, 0.0)
        return [
            np.einsum("nij,nj->ni", block.gradient, extended[places]) @ block.linear.T
            for block, places in zip(self.blocks, self.row_places, strict=True)
        ]

    def matrix(self, values: Array) -> csc_array:
        """Sparse matrix of values in the pattern."""
        return self.pattern.matrix(values)

    def full(self, q: Array) -> Array:
        """All unknowns of the model from the free ones, shape (..., dof)."""
        if self.moved.size:
            return np.asarray(self.expansion @ q.reshape(-1, self.size).T).T.reshape(*q.shape[:-1], -1)
        result = np.zeros((*q.shape[:-1], self.model.dof_count))
        result[..., self.model.free_dofs] = q
        if self.model.links:
            follows = self.model.constraints.dependent
            result[..., follows] = (self.model.expansion[follows] @ q.reshape(-1, self.size).T).T.reshape(
                *q.shape[:-1], len(follows)
            )
        return result

    def on_free(self, forces: Array) -> Array:
        """Forces on all unknowns, shape (dof, ...), as they act on the free ones, shape (size, ...)."""
        if self.model.links:
            return np.asarray(self.model.expansion.T @ forces)
        return forces[self.model.free_dofs]

    def translations(self, q: Array) -> Array:
        """Nodal displacements [m] from free unknowns, shape (..., node, 3)."""
        return self.full(q)[..., self.model.translation_dofs]

    def block_index(self, kind: str) -> list[int]:
        """Positions of the blocks of one kind."""
        return [index for index, block in enumerate(self.blocks) if block.kind == kind]

    def stress_of(self, kind: str, stress: Iterable[Array]) -> Array:
        """Stresses of all elements of a kind, from those of all blocks, shape (element, strain)."""
        every = list(stress)
        found = [every[index] for index in self.block_index(kind)]
        return np.concatenate(found) if found else np.zeros((0, 1))


def _place(model: Model, moved: Indices) -> Indices:
    """`StructuralSystem.place` with moved unknowns behind the free ones."""
    if not moved.size:
        return model.free_places
    count = len(model.free_dofs)
    places = np.where(model.free_places == count, count + len(moved), model.free_places)
    places[moved] = count + np.arange(len(moved))
    return places


class HasSystem(Protocol):
    """Anything built on a system, such as a prestressed state."""

    @property
    def system(self) -> StructuralSystem:
        """The compiled structure."""


def system_of(name: str, source: Any) -> StructuralSystem:
    """Return a system, given as such or as the prestressed state that is built on it, or raise InputError."""
    found = getattr(source, "system", source)
    return checks.instance(
        name, found, StructuralSystem, "a prestressed state", remedy="solve_prestress(model) gives one"
    )
