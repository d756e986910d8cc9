"""Initial stresses that are linear in a few numbers, compiled: for an instant, and for the steps of a stretch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.mechanics.kernel import add_forces
from tautflex.mechanics.store import KernelStore, block_data
from tautflex.numeric import Array, Indices, jit


class StressPattern(NamedTuple):
    """Where initial stresses change, shape (place,), what they are without, and their change per number, (place, n)."""

    places: Indices
    initial: Array
    columns: Array

    @classmethod
    def of(cls, store: Any, initial: tuple[Array, ...], columns: dict[int, Array]) -> StressPattern:
        """From a store, the initial stresses of its blocks, shapes (element, strain), and `InputSet.columns`."""
        numbered = KernelStore(store[0], store[1], np.arange(store[2].size, dtype=float), store[3])
        places, stresses, changes = [np.zeros(0)], [np.zeros(0)], list[Array]()
        for index, column in columns.items():
            change = np.moveaxis(column, 1, 0)
            changed = np.any(change != 0.0, axis=2)
            places.append(block_data.py_func(numbered, index).initial_stress[changed])
            stresses.append(initial[index].T[changed])
            changes.append(change[changed])
        return cls(np.concatenate(places).astype(np.int64), np.concatenate(stresses), np.concatenate(changes))


@jit
def restress(values: Array, pattern: Any, numbers: Array) -> None:
    """Set the initial stresses in the values of a store by the numbers of a `StressPattern`, shape (n,)."""
    places, initial, columns = pattern
    for i in range(places.size):
        change = 0.0
        for k in range(numbers.size):
            change += columns[i, k] * numbers[k]
        values[places[i]] = initial[i] + change


@jit
def restress_stage(stress: Any, elements: Any, row: int) -> None:
    """Set the stresses of the evaluation instant of a stage, if they change in a stretch.

    ``stress`` is None or a `StressPattern`, its numbers at start, evaluation instant and end of every stage, shape
    (stages, 3, n), and at samples, (samples, n); ``elements`` holds store and stresses of a `Workspace`.
    """
    if stress is not None:
        restress(elements[0][2], stress[0], stress[1][row, 1])


@jit
def restress_sample(stress: Any, elements: Any, row: int) -> None:
    """Set the stresses of a sample, if they change in a stretch, see `restress_stage`."""
    if stress is not None:
        restress(elements[0][2], stress[0], stress[2][row])


@jit
def restressing_work(stress: Any, elements: Any, row: int, start: Array, end: Array) -> float:
    """What a change of stresses adds to the strain energy of a stage [J]; they are then those at its end.

    It is that of the structure in the middle between the free unknowns ``start`` and ``end``; see `restress_stage`.
    """
    if stress is None:
        return 0.0
    (store, stresses), pattern, numbers, middle = elements[:2], stress[0], stress[1][row], np.zeros(start.size + 1)
    if np.array_equal(numbers[0], numbers[2]):
        restress(store[2], pattern, numbers[2])
        return 0.0
    for i in range(start.size):
        middle[i] = 0.5 * (start[i] + end[i])
    restress(store[2], pattern, numbers[0])
    before = add_forces(store, middle, middle, stresses, False, True, False)
    restress(store[2], pattern, numbers[2])
    return add_forces(store, middle, middle, stresses, False, True, False) - before
