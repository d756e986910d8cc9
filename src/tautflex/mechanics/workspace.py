"""Buffers of repeated evaluations: what one run may write to while others share its structure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.kernel import add_average_forces, add_forces
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.mechanics.restressing import StressPattern, restress
from tautflex.mechanics.store import block_data
from tautflex.mechanics.tangent import add_tangent
from tautflex.numeric import Array, Places

_NONE = np.zeros(0)


class Workspace:
    """Forces and tangents of a structure, evaluated over and over by one run; made by `StructuralSystem.workspace`.

    It owns what changes in a run: a copy of the store's values with changes of the initial stresses, and the stresses
    of the last evaluation, in ``stresses`` as compiled code fills them, one block after the other, and in
    ``stress_rows`` by block, shapes (strain, element). ``held`` is where those unknowns are that are held and
    moved, whose places in the store lie between the free ones and that of all others. The rest is shared.
    """

    def __init__(
        self,
        store: tuple[NDArray[Any], ...],
        initial_stress: tuple[Array, ...],
        pattern: SparsityPattern,
        upper_slots: list[Places],
        moved: int = 0,
    ) -> None:
        slots, terms, values, table = store
        self.store: tuple[NDArray[Any], ...] = (slots, terms, values.copy(), table)
        self._initial_stress, self._pattern, self._slots = initial_stress, pattern, upper_slots
        self._current_stress = [block_data.py_func(self.store, k).initial_stress for k in range(len(initial_stress))]
        ends = np.cumsum([0, *(stress.size for stress in self._current_stress)])
        self.stresses = np.zeros(ends[-1])
        self.stress_rows = [
            self.stresses[first:last].reshape(now.shape)
            for first, last, now in zip(ends[:-1], ends[1:], self._current_stress, strict=True)
        ]
        self.held = np.zeros(moved)
        self._extended = np.zeros(pattern.size + moved + 1)
        self._changed: set[int] = set()

    @property
    def stress(self) -> list[Array]:
        """Stress of each block at the last evaluation, shapes (element, strain)."""
        return [stress.T for stress in self.stress_rows]

    def change_initial_stress(self, change: dict[int, Array]) -> None:
        """Add to the initial stresses of some blocks, in place of any earlier change.

        ``change`` maps the number of a block to what is added, shape (element, strain); blocks that are left out get
        their initial stress back.
        """
        for index in self._changed | set(change):
            current = self._current_stress[index]
            current[:] = self._initial_stress[index].T
            if index in change:
                current += change[index].T
        self._changed = set(change)

    def stress_pattern(self, columns: dict[int, Array]) -> StressPattern:
        """What `restress` reads of a change of stresses per number, by block: shapes (element, strain, n)."""
        return StressPattern.of(self.store, self._initial_stress, columns)

    def restress(self, pattern: StressPattern, numbers: Array) -> None:
        """Set the initial stresses by numbers, shape (n,), of a pattern that all changes of this workspace are of."""
        restress(self.store[2], pattern, numbers)
        self._changed = set(range(len(self._initial_stress)))

    def _extend(self, q: Array) -> Array:
        """Free unknowns with those that are moved and the zero of all supported ones behind them (a reused buffer)."""
        self._extended[: q.size], self._extended[q.size : -1] = q, self.held
        return self._extended

    def force(self, q: Array) -> tuple[Array, float]:
        """Internal force [N, N m], shape (size,), and work of the stresses from zero unknowns [J].

        ``q`` are free unknowns [m, rad], shape (size,); the stresses of all elements are then in ``stress``.
        """
        force = np.zeros(len(self._extended))
        energy = add_forces(self.store, self._extend(q), force, self.stresses, True, True, False)
        return force[: q.size], energy

    def added_force(self, q: Array, change: dict[int, Array]) -> Array:
        """What a change of initial stresses, which then stands, adds to the internal force, shape (size,)."""
        self.change_initial_stress({})
        alone = self.force(q)[0]
        self.change_initial_stress(change)
        return self.force(q)[0] - alone

    def strain_energy(self, q: Array) -> float:
        """Work of the stresses from zero unknowns [J]; the stresses of all elements are then in ``stress``."""
        return float(add_forces(self.store, self._extend(q), self._extended, self.stresses, False, True, False))

    def force_sizes(self, q: Array) -> Array:
        """Sum of the sizes of the elements' forces on each unknown [N, N m], shape (size,)."""
        sizes = np.zeros(len(self._extended))
        add_forces(self.store, self._extend(q), sizes, self.stresses, True, False, True)
        return sizes[: q.size]

    def average_force(self, start: Array, end: Array) -> Array:
        """Internal force [N, N m] of the average stress between two states, shape (size,).

        Its work on ``end - start`` is the change of the strain energy [theory.md 8].
        """
        before, after = (np.concatenate([each, self.held, [0.0]]) for each in (start, end))
        force = np.zeros(len(self._extended))
        add_average_forces(self.store, before, after, force)
        return force[: start.size]

    def upper_tangent(self, q: Array, start: Array = _NONE, blocks: Iterable[int] | None = None) -> Array:
        """Upper triangle of the tangent stiffness [N/m ...] at free unknowns ``q``, shape (upper entries,).

        With ``start`` that of the average stress over a step from there, whose middle ``q`` is. ``blocks`` are the
        numbers of those that count; None is all.
        """
        if start.size:
            start = np.concatenate([start, self.held, [0.0]])
        extended, values = self._extend(q), np.zeros(len(self._pattern.upper[0]) + 1)
        for block in range(len(self._slots)) if blocks is None else blocks:
            add_tangent(self.store, block, extended, start, self._slots[block], values)
        return values[:-1]

    def tangent(self, q: Array, blocks: Iterable[int] | None = None) -> Array:
        """Values of the tangent stiffness [N/m ...] at free unknowns ``q`` in the pattern, shape (entries,)."""
        values: Array = self.upper_tangent(q, blocks=blocks)[self._pattern.from_upper]
        return values
