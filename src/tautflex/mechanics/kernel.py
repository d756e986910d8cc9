"""Compiled energy, force and stress of any element block [theory.md 2].

Elements are worked off in packs: every short list of terms (gradient, strain, elasticity) is an outer loop, the
elements of a pack the inner one over rows of equal length, which the compiler turns into vector instructions. Extended
vectors end with one slot that collects whatever belongs to supported unknowns.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.laws.law import call_law
from tautflex.mechanics.store import ELASTIC, block_data
from tautflex.numeric import Array, jit

PACK = 128


@jit
def pack_strain(data: Any, first: int, width: int, q: Array, local: Array, g: Array, strain: Array) -> None:
    """Gradients and strains of the pack of ``width`` elements that starts at ``first``."""
    for k in range(data.dofs.shape[0]):
        slots, row = data.dofs[k, first : first + width], local[k]
        for e in range(width):
            row[e] = q[slots[e]]
    g.fill(0.0)
    strain.fill(0.0)
    for t in range(data.gradient_row.size):
        result, factor = g[data.gradient_row[t]], local[data.gradient_column[t]]
        values = data.gradient_value[t, first : first + width]
        for e in range(width):
            result[e] += values[e] * factor[e]
    for t in range(data.linear_value.size):
        result, factor, value = strain[data.linear_strain[t]], g[data.linear_gradient[t]], data.linear_value[t]
        for e in range(width):
            result[e] += value * factor[e]
    for t in range(data.quadratic_value.size):
        result, value = strain[data.quadratic_strain[t]], 0.5 * data.quadratic_value[t]
        factor, other = g[data.quadratic_first[t]], g[data.quadratic_second[t]]
        for e in range(width):
            result[e] += value * factor[e] * other[e]


@jit
def pack_stress(data: Any, first: int, width: int, strain: Array, stress: Array) -> None:
    """Elastic (trial) stresses of a pack."""
    for s in range(strain.shape[0]):
        result, start = stress[s], data.initial_stress[s, first : first + width]
        for e in range(width):
            result[e] = start[e]
    for t in range(data.elastic_row.size):
        result, factor = stress[data.elastic_row[t]], strain[data.elastic_column[t]]
        values = data.elastic_value[t, first : first + width]
        for e in range(width):
            result[e] += values[e] * factor[e]


@jit
def apply_law(data: Any, first: int, width: int, stress: Array, tangent: Array, density: Array) -> float:
    """Replace a pack's trial stresses by those of a nonlinear law, fill its tangents, return its energy.

    ``density`` (pack,) is filled with the stored energy per measure.
    """
    call_law(data.law, stress, tangent, density, data.law_parameters, width)
    energy = 0.0
    for e in range(width):
        energy += data.measure[first + e] * density[e]
    for e in range(width):
        energy -= data.initial_energy[first + e]
    return energy


@jit
def _elastic_energy(data: Any, first: int, width: int, strain: Array, stress: Array) -> float:
    energy, measure = 0.0, data.measure[first : first + width]
    for s in range(strain.shape[0]):
        row, end, start = strain[s], stress[s], data.initial_stress[s, first : first + width]
        for e in range(width):
            energy += measure[e] * row[e] * 0.5 * (start[e] + end[e])
    return energy


@jit
def _scatter(
    data: Any, first: int, width: int, g: Array, stress: Array, conjugate: Array, local: Array, out: Array
) -> None:
    """Add the nodal forces ``G' V B' sigma`` of a pack to ``out``; ``stress`` is multiplied by the measure."""
    measure = data.measure[first : first + width]
    for s in range(stress.shape[0]):
        row = stress[s]
        for e in range(width):
            row[e] *= measure[e]
    conjugate.fill(0.0)
    for t in range(data.linear_value.size):
        result, factor, value = conjugate[data.linear_gradient[t]], stress[data.linear_strain[t]], data.linear_value[t]
        for e in range(width):
            result[e] += value * factor[e]
    for t in range(data.quadratic_value.size):
        result, value = conjugate[data.quadratic_first[t]], data.quadratic_value[t]
        factor, other = g[data.quadratic_second[t]], stress[data.quadratic_strain[t]]
        for e in range(width):
            result[e] += value * factor[e] * other[e]
    local.fill(0.0)
    for t in range(data.gradient_row.size):
        result, factor = local[data.gradient_column[t]], conjugate[data.gradient_row[t]]
        values = data.gradient_value[t, first : first + width]
        for e in range(width):
            result[e] += values[e] * factor[e]
    for k in range(data.dofs.shape[0]):
        slots, row = data.dofs[k, first : first + width], local[k]
        for e in range(width):
            out[slots[e]] += row[e]


@jit
def _block_force(data: Any, q: Array, force: Array, stresses: Array, forces: bool, energies: bool) -> float:
    strains, count = data.initial_stress.shape
    local, strain = np.empty((data.dofs.shape[0], PACK)), np.empty((strains, PACK))
    stress, tangent = np.empty((strains, PACK)), np.empty((strains, strains, PACK))
    g, conjugate, density = np.empty((data.gradients, PACK)), np.empty((data.gradients, PACK)), np.empty(PACK)
    energy = 0.0
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        pack_strain(data, first, width, q, local, g, strain)
        pack_stress(data, first, width, strain, stress)
        if data.law != ELASTIC:
            energy += apply_law(data, first, width, stress, tangent, density)
        elif energies:
            energy += _elastic_energy(data, first, width, strain, stress)
        if energies:
            for s in range(strains):
                row, kept = stress[s], stresses[s * count + first : s * count + first + width]
                for e in range(width):
                    kept[e] = row[e]
        if forces:
            _scatter(data, first, width, g, stress, conjugate, local, force)
    return energy


@jit
def add_forces(store: Any, q: Array, force: Array, stresses: Array, forces: bool, energies: bool) -> float:
    """Add the internal forces of all blocks of a store to ``force``.

    ``q`` and ``force`` are extended vectors, shape (size + 1,). ``stresses`` is filled with the stresses of one block
    after the other, each (strain, element). ``forces`` says whether ``force`` is wanted, ``energies`` whether stresses
    and the strain energy [J] are, which is returned; without them only that of nonlinear blocks is.
    """
    energy, first = 0.0, 0
    for block in range(store[3].shape[0]):
        data = block_data(store, block)
        size = data.initial_stress.size
        energy += _block_force(data, q, force, stresses[first : first + size], forces, energies)
        first += size
    return energy


@jit
def _block_average(data: Any, start: Array, end: Array, force: Array) -> None:
    strains, count = data.initial_stress.shape
    local, strain = np.empty((data.dofs.shape[0], PACK)), np.empty((strains, PACK))
    stress, tangent = np.empty((strains, PACK)), np.empty((strains, strains, PACK))
    strain_end, stress_end = np.empty((strains, PACK)), np.empty((strains, PACK))
    density, density_end = np.empty(PACK), np.empty(PACK)
    g, g_end = np.empty((data.gradients, PACK)), np.empty((data.gradients, PACK))
    conjugate = np.empty((data.gradients, PACK))
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        pack_strain(data, first, width, start, local, g, strain)
        pack_stress(data, first, width, strain, stress)
        pack_strain(data, first, width, end, local, g_end, strain_end)
        pack_stress(data, first, width, strain_end, stress_end)
        if data.law != ELASTIC:
            apply_law(data, first, width, stress, tangent, density)
            apply_law(data, first, width, stress_end, tangent, density_end)
            for e in range(width):
                measure, start_energy = data.measure[first + e], data.initial_energy[first + e]
                before, after = measure * density[e] - start_energy, measure * density_end[e] - start_energy
                work, square = 0.0, 0.0
                for s in range(strains):
                    move = strain_end[s, e] - strain[s, e]
                    work += 0.5 * measure * (stress[s, e] + stress_end[s, e]) * move
                    square += move * move
                # Below the round-off of the energies there is nothing to correct.
                defect = after - before - work
                if abs(defect) > 1e-15 * (abs(before) + abs(after)):
                    factor = 2.0 * defect / (measure * square)
                    for s in range(strains):
                        stress[s, e] += factor * (strain_end[s, e] - strain[s, e])
        for s in range(strains):
            row, other = stress[s], stress_end[s]
            for e in range(width):
                row[e] = 0.5 * (row[e] + other[e])
        for i in range(data.gradients):
            row, other = g[i], g_end[i]
            for e in range(width):
                row[e] = 0.5 * (row[e] + other[e])
        _scatter(data, first, width, g, stress, conjugate, local, force)


@jit
def add_average_forces(store: Any, start: Array, end: Array, force: Array) -> None:
    """Add ``G' V B(g_middle)' (sigma_start + sigma_end)/2`` of all blocks to ``force`` [theory.md 8].

    Its work on ``end - start`` is the change of energy: exactly for the elastic law, because strains are quadratic,
    and for other laws by the discrete gradient, which corrects the average stress along the change of strain
    [Gonzalez, J. Nonlinear Sci. 6 (1996) 449].
    """
    for block in range(store[3].shape[0]):
        _block_average(block_data(store, block), start, end, force)


@jit
def _store_initial_energies(store: Any, block: int) -> None:
    data = block_data(store, block)
    strains, count = data.initial_stress.shape
    stress, tangent = data.initial_stress.copy(), np.empty((strains, strains, count))
    call_law(data.law, stress, tangent, data.initial_energy, data.law_parameters, count)
    data.initial_energy[:] *= data.measure


def restart_energy(store: tuple[NDArray[Any], ...], block: int) -> None:
    """Let energies of a block with a nonlinear law count from zero unknowns, as those of the elastic law do."""
    if block_data.py_func(store, block).law != ELASTIC:
        _store_initial_energies(store, block)
