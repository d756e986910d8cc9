"""Compiled tangents of any element block, added to the upper triangle of the sparsity pattern [theory.md 2]."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.elements.laws.law import call_law
from tautflex.elements.local_frame import make_room, turn_core
from tautflex.lending import lent
from tautflex.mechanics.average import average_stress
from tautflex.mechanics.kernel import pack_strain, pack_stress
from tautflex.mechanics.store import ELASTIC, block_data
from tautflex.numeric import Array, Places, jit

# Smaller than the kernel's: the element matrices of a pack must stay in the first-level cache.
PACK = 32


@jit
def pack_core(
    data: Any, first: int, width: int, g: Array, stress: Array, tangent: Array, b: Array, db: Array, core: Array
) -> None:
    """``B' D B + sigma.Q`` of a pack, shape (gradient, gradient, pack)."""
    b.fill(0.0)
    db.fill(0.0)
    core.fill(0.0)
    strains, gradients = b.shape[0], b.shape[1]
    for t in range(data.linear_value.size):
        result, value = b[data.linear_strain[t], data.linear_gradient[t]], data.linear_value[t]
        for e in range(width):
            result[e] += value
    for t in range(data.quadratic_value.size):
        s, i, j = data.quadratic_strain[t], data.quadratic_first[t], data.quadratic_second[t]
        value = data.quadratic_value[t]
        slope, result, factor, row = b[s, i], core[i, j], g[j], stress[s]
        for e in range(width):
            slope[e] += value * factor[e]
            result[e] += value * row[e]
    if data.law == ELASTIC:
        for t in range(data.elastic_row.size):
            row, column = data.elastic_row[t], data.elastic_column[t]
            values = data.elastic_value[t, first : first + width]
            for i in range(gradients):
                result, factor = db[row, i], b[column, i]
                for e in range(width):
                    result[e] += values[e] * factor[e]
    else:
        for row in range(strains):
            for column in range(strains):
                slope = tangent[row, column]
                for i in range(gradients):
                    result, factor = db[row, i], b[column, i]
                    for e in range(width):
                        result[e] += slope[e] * factor[e]
    for s in range(strains):
        for i in range(gradients):
            slope = b[s, i]
            for j in range(gradients):
                result, factor = core[i, j], db[s, j]
                for e in range(width):
                    result[e] += slope[e] * factor[e]


@jit
def _block_tangent(data: Any, q: Array, start: Array, slots: Places, values: Array) -> None:
    strains, count = data.initial_stress.shape
    gradients, unknowns = data.gradients, data.dofs.shape[0]
    local, strain, ends = np.empty((unknowns, PACK)), np.empty((strains, PACK)), np.empty((2 * strains, PACK))
    stress, averaged = ends[:strains], start.size > 0 and data.law != ELASTIC
    g = np.empty((gradients * (1 + data.turns), PACK))
    b, db = np.empty((strains, gradients, PACK)), np.empty((strains, gradients, PACK))
    core, half = np.empty((gradients, gradients, PACK)), np.empty((gradients, unknowns, PACK))
    element = np.empty((unknowns, unknowns, PACK))
    tangent, density = np.empty((strains, strains, PACK)), np.empty(PACK)
    other, end = np.empty((strains, PACK)), 2.0 * q - start if averaged else start
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        if averaged:
            pack_strain(data, first, width, start, local, g, strain)
            pack_stress(data, first, width, strain, stress)
            pack_strain(data, first, width, end, local, g, other)
            pack_stress(data, first, width, other, ends[strains:])
            average_stress(data, ends, tangent, density, strain, other, width)
        pack_strain(data, first, width, q, local, g, strain)
        if not averaged:
            pack_stress(data, first, width, strain, stress)
        if data.law != ELASTIC and not averaged:
            call_law(data.law, stress, tangent, density, data.law_parameters, width)
        pack_core(data, first, width, g, stress, tangent, b, db, core)
        if data.turns:
            conjugate = np.zeros((gradients, PACK))
            for s in range(strains):
                for i in range(gradients):
                    for e in range(width):
                        conjugate[i, e] += b[s, i, e] * stress[s, e]
            turn_core(g[gradients:], width, make_room(), conjugate, core)
        half.fill(0.0)
        element.fill(0.0)
        for t in range(data.gradient_row.size):
            row, column = data.gradient_row[t], data.gradient_column[t]
            factor = data.gradient_value[t, first : first + width]
            for i in range(gradients):
                result, part = half[i, column], core[i, row]
                for e in range(width):
                    result[e] += part[e] * factor[e]
        measure = data.measure[first : first + width]
        for t in range(data.gradient_row.size):
            row, column = data.gradient_row[t], data.gradient_column[t]
            factor = data.gradient_value[t, first : first + width]
            # The element matrix is symmetric: half of it is enough.
            for k in range(column + 1):
                result, part = element[column, k], half[row, k]
                for e in range(width):
                    result[e] += measure[e] * factor[e] * part[e]
        pair = 0
        for m in range(unknowns):
            for k in range(m + 1):
                part, place = element[m, k], slots[pair, first : first + width]
                for e in range(width):
                    values[place[e]] += part[e]
                pair += 1


@jit
def add_tangent(store: Any, block: int, q: Array, start: Array, slots: Places, values: Array) -> None:
    """Add one block's tangents ``G' V (B' D B + sigma.Q) G`` to the values of an upper triangle (upper entries + 1,).

    Stress and tangent of a law are those at ``q``; unless ``start`` is empty, their averages over the step from there
    whose middle ``q`` is. ``slots`` are the block's `SparsityPattern.upper_slots`; the last value collects what belongs
    to supports.
    """
    _block_tangent(block_data(lent(store), block), q, start, slots, values)
