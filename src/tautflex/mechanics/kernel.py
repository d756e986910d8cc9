"""Compiled energy, force and stress of any element block [theory.md 2].

Elements are worked off in packs: every short list of terms (gradient, strain, elasticity) is an outer loop, the
elements of a pack the inner one over rows of equal length, which the compiler turns into vector instructions. Extended
vectors end with one slot that collects whatever belongs to supported unknowns. Gradients of blocks that turn are those
of their local frames, in buffers of twice as many rows, whose second half keeps them as they were.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.elements.laws.law import call_law
from tautflex.elements.local_frame import make_room, pull_back, to_local
from tautflex.lending import lent
from tautflex.mechanics.average import average_stress
from tautflex.mechanics.products import inner
from tautflex.mechanics.store import ELASTIC, block_data
from tautflex.numeric import Array, jit

PACK = 128
# Gauss points of a mean along a step: exact to the sixth order in what the ends of a line turn in it.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(3)


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
    if data.turns:
        g[data.gradients :] = g[: data.gradients]
        to_local(g[data.gradients :], width, g)
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
def _scatter(
    data: Any, first: int, width: int, g: Array, stress: Array, conjugate: Array, local: Array, out: Array, sizes: bool
) -> None:
    """Add the nodal forces ``G' V B' sigma`` of a pack (or their sizes) to ``out``; ``stress`` is multiplied by V."""
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
    if data.turns:
        pull_back(g[data.gradients :], width, make_room(), conjugate)
    local.fill(0.0)
    for t in range(data.gradient_row.size):
        result, factor = local[data.gradient_column[t]], conjugate[data.gradient_row[t]]
        values = data.gradient_value[t, first : first + width]
        for e in range(width):
            result[e] += values[e] * factor[e]
    for k in range(data.dofs.shape[0]):
        slots, row = data.dofs[k, first : first + width], local[k]
        for e in range(width):
            out[slots[e]] += abs(row[e]) if sizes else row[e]


@jit
def _give_way(data: Any, first: int, width: int, strain: Array, stress: Array, energies: bool) -> float:
    """Replace the trial stresses of a pack by those of its law; work of the stresses from zero unknowns, if wanted."""
    (strains, most), energy = strain.shape, 0.0
    tangent, density = np.empty((strains, strains, most)), np.empty(most)
    if energies:
        # By the mean stress: nothing is lost in a difference to the energy of the prestress.
        ends, rest = np.empty((2 * strains, most)), np.zeros((strains, most))
        for s in range(strains):
            for e in range(width):
                ends[s, e], ends[strains + s, e] = data.initial_stress[s, first + e], stress[s, e]
        average_stress(data, ends, tangent, density, rest, strain, width)
        for s in range(strains):
            for e in range(width):
                energy += data.measure[first + e] * ends[s, e] * strain[s, e]
    call_law(data.law, stress, tangent, density, data.law_parameters, width)
    return energy


@jit
def _block_force(
    data: Any, q: Array, force: Array, stresses: Array, forces: bool, energies: bool, sizes: bool
) -> float:
    strains, count = data.initial_stress.shape
    most, gradients = min(PACK, count), data.gradients
    local, g = np.empty((data.dofs.shape[0], most)), np.empty((gradients * (1 + data.turns), most))
    strain, stress, conjugate = np.empty((strains, most)), np.empty((strains, most)), np.empty((gradients, most))
    energy = 0.0
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        pack_strain(data, first, width, q, local, g, strain)
        pack_stress(data, first, width, strain, stress)
        if data.law != ELASTIC:
            energy += _give_way(data, first, width, strain, stress, energies)
        elif energies:
            density = conjugate[0]
            density.fill(0.0)
            for s in range(strains):
                row, end, start = strain[s], stress[s], data.initial_stress[s, first : first + width]
                for e in range(width):
                    density[e] += 0.5 * (start[e] + end[e]) * row[e]
            energy += inner(data.measure[first : first + width], density[:width])
        if energies:
            for s in range(strains):
                row, kept = stress[s], stresses[s * count + first : s * count + first + width]
                for e in range(width):
                    kept[e] = row[e]
        if forces:
            _scatter(data, first, width, g, stress, conjugate, local, force, sizes)
    return energy


@jit
def add_forces(store: Any, q: Array, force: Array, stresses: Array, forces: bool, energies: bool, sizes: bool) -> float:
    """Add the internal forces of all blocks of a store to ``force``.

    ``q`` and ``force`` are extended vectors, shape (size + 1,). ``stresses`` is filled with the stresses of one block
    after the other, each (strain, element). ``forces`` says whether ``force`` is wanted, ``energies`` whether stresses
    and the strain energy above zero unknowns [J] are, which is returned, ``sizes`` whether sizes of the rows' forces
    are to be added: their sum loses a few units of the last place of these to round-off.
    """
    energy, first, parts = 0.0, 0, lent(store)
    for block in range(parts[3].shape[0]):
        data = block_data(parts, block)
        size = data.initial_stress.size
        energy += _block_force(data, q, force, stresses[first : first + size], forces, energies, sizes)
        first += size
    return energy


@jit
def _block_average(data: Any, start: Array, end: Array, force: Array) -> None:
    strains, count = data.initial_stress.shape
    local = np.empty((data.dofs.shape[0], PACK))
    strain, strain_end, ends = np.empty((strains, PACK)), np.empty((strains, PACK)), np.empty((2 * strains, PACK))
    stress, stress_end = ends[:strains], ends[strains:]
    tangent, density = np.empty((strains, strains, PACK)), np.empty(PACK)
    rows = data.gradients * (1 + data.turns)
    g, g_end = np.empty((rows, PACK)), np.empty((rows, PACK))
    conjugate = np.empty((data.gradients, PACK))
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        pack_strain(data, first, width, start, local, g, strain)
        pack_stress(data, first, width, strain, stress)
        pack_strain(data, first, width, end, local, g_end, strain_end)
        pack_stress(data, first, width, strain_end, stress_end)
        average_stress(data, ends, tangent, density, strain, strain_end, width)
        if data.turns:
            _scatter_mean(data, first, width, g, g_end, stress, conjugate, local, force)
            continue
        for i in range(data.gradients):
            row, other = g[i], g_end[i]
            for e in range(width):
                row[e] = 0.5 * (row[e] + other[e])
        _scatter(data, first, width, g, stress, conjugate, local, force, False)


@jit
def _scatter_mean(
    data: Any, first: int, width: int, g: Array, g_end: Array, stress: Array, conjugate: Array, local: Array, out: Array
) -> None:
    """Add ``G' V mean(B)' sigma`` over a step of elements that turn, whose strains are no quadratics of gradients."""
    middle, part = np.empty_like(g), np.empty_like(stress)
    start, end, given = g[data.gradients :], g_end[data.gradients :], middle[data.gradients :]
    for k in range(_POINTS.size):
        share = 0.5 + 0.5 * _POINTS[k]
        for e in range(width):
            given[:, e] = (1.0 - share) * start[:, e] + share * end[:, e]
            part[:, e] = 0.5 * _WEIGHTS[k] * stress[:, e]
        to_local(given, width, middle)
        _scatter(data, first, width, middle, part, conjugate, local, out, False)


@jit
def add_average_forces(store: Any, start: Array, end: Array, force: Array) -> None:
    """Add ``G' V B(g_middle)' (sigma_start + sigma_end)/2`` of all blocks to ``force`` [theory.md 8].

    Its work on ``end - start`` is the change of energy, because strains are quadratic; of elements that turn B is its
    mean over the step. Other laws than the elastic one give their mean over the step in place of that of both ends, see
    `average`.
    """
    parts = lent(store)
    for block in range(parts[3].shape[0]):
        _block_average(block_data(parts, block), start, end, force)
