"""Compiled energy, force and tangent of any element block [theory.md 2].

Elements are worked off in packs: every short list of terms (gradient, strain, elasticity) is an outer loop, the
elements of a pack the inner one, which the compiler turns into vector instructions. Extended vectors and matrices end
with one slot that collects whatever belongs to supported unknowns.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from tautflex.elements.block import ElementBlock
from tautflex.elements.laws import ELASTIC, LAWS, SLACK, slack_factor, tension_field

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PACK = 64

# Re-association lets reductions vectorise; NaN and infinity keep their meaning.
_jit = numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz", "arcp"}, error_model="numpy")


class KernelData(NamedTuple):
    """One block as the kernel reads it: lists of non-zero terms; the element is always the last axis."""

    dofs: Indices
    gradient_row: Indices
    gradient_column: Indices
    gradient_value: Array
    linear_strain: Indices
    linear_gradient: Indices
    linear_value: Array
    quadratic_strain: Indices
    quadratic_first: Indices
    quadratic_second: Indices
    quadratic_value: Array
    elastic_row: Indices
    elastic_column: Indices
    elastic_value: Array
    initial_stress: Array
    measure: Array
    gradients: int
    law: int
    law_parameters: tuple[float, float, float]
    initial_energy: Array


def kernel_data(block: ElementBlock, dofs: Indices, initial_stress: Array) -> KernelData:
    """Compress a block for the kernel.

    Parameters
    ----------
    block
        Element block.
    dofs
        Slot of every unknown in the extended vector, shape (element, dof).
    initial_stress
        Stress at zero unknowns, shape (element, strain), units of the block.

    Returns
    -------
    KernelData
    """
    gradient_row, gradient_column = _terms(np.any(block.gradient != 0.0, axis=0))
    linear_strain, linear_gradient = _terms(block.linear)
    quadratic_strain, quadratic_first, quadratic_second = _terms(block.quadratic)
    elastic_row, elastic_column = _terms(np.any(block.elasticity != 0.0, axis=0))
    data = KernelData(
        dofs=np.ascontiguousarray(dofs.T),
        gradient_row=gradient_row,
        gradient_column=gradient_column,
        gradient_value=np.ascontiguousarray(block.gradient[:, gradient_row, gradient_column].T),
        linear_strain=linear_strain,
        linear_gradient=linear_gradient,
        linear_value=block.linear[linear_strain, linear_gradient],
        quadratic_strain=quadratic_strain,
        quadratic_first=quadratic_first,
        quadratic_second=quadratic_second,
        quadratic_value=block.quadratic[quadratic_strain, quadratic_first, quadratic_second],
        elastic_row=elastic_row,
        elastic_column=elastic_column,
        elastic_value=np.ascontiguousarray(block.elasticity[:, elastic_row, elastic_column].T),
        initial_stress=np.array(initial_stress.T, order="C"),  # a copy of its own: inputs in time change it
        measure=np.ascontiguousarray(block.measure),
        gradients=block.gradient.shape[1],
        law=LAWS[block.law],
        law_parameters=block.law_parameters,
        initial_energy=np.zeros(len(dofs)),
    )
    restart_energy(data)
    return data


def restart_energy(data: KernelData) -> None:
    """Let energies of nonlinear laws count from zero unknowns, as those of the elastic law do."""
    if data.law != ELASTIC:
        _store_initial_energy(data, data.initial_energy)


def _terms(table: NDArray[Any]) -> tuple[Indices, ...]:
    """Indices of the non-zero entries, contiguous so that every block has the same compiled type."""
    return tuple(np.ascontiguousarray(index) for index in np.nonzero(table))


@_jit
def _strain(data: Any, first: int, width: int, q: Array, local: Array, g: Array, strain: Array) -> None:
    """Gradients and strains of the pack of ``width`` elements that starts at ``first``."""
    for k in range(data.dofs.shape[0]):
        for e in range(width):
            local[k, e] = q[data.dofs[k, first + e]]
    g.fill(0.0)
    strain.fill(0.0)
    for t in range(data.gradient_row.size):
        row, column = data.gradient_row[t], data.gradient_column[t]
        for e in range(width):
            g[row, e] += data.gradient_value[t, first + e] * local[column, e]
    for t in range(data.linear_value.size):
        s, i, value = data.linear_strain[t], data.linear_gradient[t], data.linear_value[t]
        for e in range(width):
            strain[s, e] += value * g[i, e]
    for t in range(data.quadratic_value.size):
        s, i, j = data.quadratic_strain[t], data.quadratic_first[t], data.quadratic_second[t]
        value = 0.5 * data.quadratic_value[t]
        for e in range(width):
            strain[s, e] += value * g[i, e] * g[j, e]


@_jit
def _stress(data: Any, first: int, width: int, strain: Array, stress: Array) -> None:
    """Stresses of a pack."""
    for s in range(strain.shape[0]):
        for e in range(width):
            stress[s, e] = data.initial_stress[s, first + e]
    for t in range(data.elastic_row.size):
        row, column = data.elastic_row[t], data.elastic_column[t]
        for e in range(width):
            stress[row, e] += data.elastic_value[t, first + e] * strain[column, e]


@_jit
def _apply_law(data: Any, first: int, width: int, stress: Array, tangent: Array) -> float:
    """Replace a pack's trial stresses by those of a nonlinear law, fill its tangents, return its energy."""
    energy = 0.0
    young, poisson, residual = data.law_parameters
    if data.law == SLACK:
        for e in range(width):
            trial = stress[0, e]
            factor = slack_factor(trial, residual)
            energy += data.measure[first + e] * 0.5 * factor * trial * trial / young
            stress[0, e] = factor * trial
            tangent[0, 0, e] = factor * young
    else:
        result, slope = np.empty(3), np.empty((3, 3))
        for e in range(width):
            density = tension_field(stress[0, e], stress[1, e], stress[2, e], young, poisson, residual, result, slope)
            energy += data.measure[first + e] * density
            for s in range(3):
                stress[s, e] = result[s]
                for r in range(3):
                    tangent[s, r, e] = slope[s, r]
    for e in range(width):
        energy -= data.initial_energy[first + e]
    return energy


@_jit
def _store_initial_energy(data: Any, target: Array) -> None:
    strains, count = data.initial_stress.shape
    stress, tangent = np.empty((strains, PACK)), np.empty((strains, strains, PACK))
    for e in range(count):
        for s in range(strains):
            stress[s, 0] = data.initial_stress[s, e]
        target[e] = _apply_law(data, e, 1, stress, tangent)


@_jit
def add_force(data: Any, q: Array, force: Array, all_stress: Array) -> float:
    """Add internal forces ``G' V B' sigma`` to ``force``, fill ``all_stress`` (strain, element), return the energy."""
    strains, count = data.initial_stress.shape
    local, strain = np.empty((data.dofs.shape[0], PACK)), np.empty((strains, PACK))
    stress, tangent = np.empty((strains, PACK)), np.empty((strains, strains, PACK))
    g, conjugate = np.empty((data.gradients, PACK)), np.empty((data.gradients, PACK))
    energy = 0.0
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        _strain(data, first, width, q, local, g, strain)
        _stress(data, first, width, strain, stress)
        conjugate.fill(0.0)
        if data.law == ELASTIC:
            for s in range(strains):
                for e in range(width):
                    middle = 0.5 * (data.initial_stress[s, first + e] + stress[s, e])
                    energy += data.measure[first + e] * strain[s, e] * middle
        else:
            energy += _apply_law(data, first, width, stress, tangent)
        for s in range(strains):
            for e in range(width):
                all_stress[s, first + e] = stress[s, e]
        for t in range(data.linear_value.size):
            s, i, value = data.linear_strain[t], data.linear_gradient[t], data.linear_value[t]
            for e in range(width):
                conjugate[i, e] += value * stress[s, e]
        for t in range(data.quadratic_value.size):
            s, i, j = data.quadratic_strain[t], data.quadratic_first[t], data.quadratic_second[t]
            value = data.quadratic_value[t]
            for e in range(width):
                conjugate[i, e] += value * g[j, e] * stress[s, e]
        local.fill(0.0)
        for t in range(data.gradient_row.size):
            row, column = data.gradient_row[t], data.gradient_column[t]
            for e in range(width):
                local[column, e] += data.gradient_value[t, first + e] * conjugate[row, e]
        for k in range(data.dofs.shape[0]):
            for e in range(width):
                force[data.dofs[k, first + e]] += data.measure[first + e] * local[k, e]
    return energy


@_jit
def add_tangent(data: Any, q: Array, slots: Indices, values: Array) -> None:
    """Add tangents ``G' V (B' D B + sigma.Q) G`` to the sparse ``values``; slots has shape (dof, dof, element)."""
    strains, count = data.initial_stress.shape
    gradients, unknowns = data.gradients, data.dofs.shape[0]
    local, strain, stress = np.empty((unknowns, PACK)), np.empty((strains, PACK)), np.empty((strains, PACK))
    g, b, db = (
        np.empty((gradients, PACK)),
        np.empty((strains, gradients, PACK)),
        np.empty((strains, gradients, PACK)),
    )
    core, half = np.empty((gradients, gradients, PACK)), np.empty((gradients, unknowns, PACK))
    element, tangent = np.empty((unknowns, unknowns, PACK)), np.empty((strains, strains, PACK))
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        _strain(data, first, width, q, local, g, strain)
        _stress(data, first, width, strain, stress)
        if data.law != ELASTIC:
            _apply_law(data, first, width, stress, tangent)
        b.fill(0.0)
        db.fill(0.0)
        core.fill(0.0)
        half.fill(0.0)
        element.fill(0.0)
        for t in range(data.linear_value.size):
            for e in range(width):
                b[data.linear_strain[t], data.linear_gradient[t], e] += data.linear_value[t]
        for t in range(data.quadratic_value.size):
            s, i, j = data.quadratic_strain[t], data.quadratic_first[t], data.quadratic_second[t]
            for e in range(width):
                b[s, i, e] += data.quadratic_value[t] * g[j, e]
                core[i, j, e] += data.quadratic_value[t] * stress[s, e]
        if data.law == ELASTIC:
            for t in range(data.elastic_row.size):
                row, column = data.elastic_row[t], data.elastic_column[t]
                for i in range(gradients):
                    for e in range(width):
                        db[row, i, e] += data.elastic_value[t, first + e] * b[column, i, e]
        else:
            for row in range(strains):
                for column in range(strains):
                    for i in range(gradients):
                        for e in range(width):
                            db[row, i, e] += tangent[row, column, e] * b[column, i, e]
        for s in range(strains):
            for i in range(gradients):
                for j in range(gradients):
                    for e in range(width):
                        core[i, j, e] += b[s, i, e] * db[s, j, e]
        for t in range(data.gradient_row.size):
            row, column = data.gradient_row[t], data.gradient_column[t]
            for i in range(gradients):
                for e in range(width):
                    half[i, column, e] += core[i, row, e] * data.gradient_value[t, first + e]
        for t in range(data.gradient_row.size):
            row, column = data.gradient_row[t], data.gradient_column[t]
            for k in range(unknowns):
                for e in range(width):
                    element[column, k, e] += data.gradient_value[t, first + e] * half[row, k, e]
        for m in range(unknowns):
            for k in range(unknowns):
                for e in range(width):
                    values[slots[m, k, first + e]] += data.measure[first + e] * element[m, k, e]


@_jit
def smallest_principal_value(stress: Array) -> float:
    """Smallest principal value of plane stresses (sx, sy, txy), shape (3, element)."""
    smallest = np.inf
    for e in range(stress.shape[1]):
        half = 0.5 * (stress[0, e] - stress[1, e])
        radius = np.sqrt(half * half + stress[2, e] * stress[2, e])
        smallest = min(smallest, 0.5 * (stress[0, e] + stress[1, e]) - radius)
    return smallest


@_jit
def add_average_force(data: Any, start: Array, end: Array, force: Array) -> None:
    """Add ``G' V B(g_middle)' (sigma_start + sigma_end)/2`` to ``force`` [theory.md 8].

    Its work on ``end - start`` is the change of energy: exactly for the elastic law, because strains are quadratic,
    and for other laws by the discrete gradient, which corrects the average stress along the change of strain
    [Gonzalez, J. Nonlinear Sci. 6 (1996) 449].
    """
    strains, count = data.initial_stress.shape
    local, strain = np.empty((data.dofs.shape[0], PACK)), np.empty((strains, PACK))
    stress, tangent = np.empty((strains, PACK)), np.empty((strains, strains, PACK))
    strain_end, stress_end, single = np.empty((strains, PACK)), np.empty((strains, PACK)), np.empty((strains, PACK))
    g, g_end = np.empty((data.gradients, PACK)), np.empty((data.gradients, PACK))
    conjugate = np.empty((data.gradients, PACK))
    for first in range(0, count, PACK):
        width = min(PACK, count - first)
        _strain(data, first, width, start, local, g, strain)
        _stress(data, first, width, strain, stress)
        _strain(data, first, width, end, local, g_end, strain_end)
        _stress(data, first, width, strain_end, stress_end)
        if data.law != ELASTIC:
            for e in range(width):
                for s in range(strains):
                    single[s, 0] = stress[s, e]
                before = _apply_law(data, first + e, 1, single, tangent)
                for s in range(strains):
                    stress[s, e], single[s, 0] = single[s, 0], stress_end[s, e]
                after = _apply_law(data, first + e, 1, single, tangent)
                work, square = 0.0, 0.0
                for s in range(strains):
                    stress_end[s, e] = single[s, 0]
                for s in range(strains):
                    move = strain_end[s, e] - strain[s, e]
                    work += 0.5 * data.measure[first + e] * (stress[s, e] + stress_end[s, e]) * move
                    square += move * move
                # Below the round-off of the energies there is nothing to correct.
                defect = after - before - work
                if abs(defect) > 1e-15 * (abs(before) + abs(after)):
                    factor = 2.0 * defect / (data.measure[first + e] * square)
                    for s in range(strains):
                        stress[s, e] += factor * (strain_end[s, e] - strain[s, e])
        conjugate.fill(0.0)
        for s in range(strains):
            for e in range(width):
                stress[s, e] = 0.5 * (stress[s, e] + stress_end[s, e])
        for i in range(data.gradients):
            for e in range(width):
                g[i, e] = 0.5 * (g[i, e] + g_end[i, e])
        for t in range(data.linear_value.size):
            s, i, value = data.linear_strain[t], data.linear_gradient[t], data.linear_value[t]
            for e in range(width):
                conjugate[i, e] += value * stress[s, e]
        for t in range(data.quadratic_value.size):
            s, i, j = data.quadratic_strain[t], data.quadratic_first[t], data.quadratic_second[t]
            value = data.quadratic_value[t]
            for e in range(width):
                conjugate[i, e] += value * g[j, e] * stress[s, e]
        local.fill(0.0)
        for t in range(data.gradient_row.size):
            row, column = data.gradient_row[t], data.gradient_column[t]
            for e in range(width):
                local[column, e] += data.gradient_value[t, first + e] * conjugate[row, e]
        for k in range(data.dofs.shape[0]):
            for e in range(width):
                force[data.dofs[k, first + e]] += data.measure[first + e] * local[k, e]
