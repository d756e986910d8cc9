"""Compiled forces of a hyper-reduced model: the element kernel, on elements whose unknowns are the coordinates."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.laws.law import call_law
from tautflex.mechanics.kernel import add_average_forces, add_forces, pack_strain, pack_stress
from tautflex.mechanics.store import ELASTIC, block_data
from tautflex.mechanics.tangent import PACK, pack_core
from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.dispatch import KERNELS, ForceKernels
from tautflex.reduction.polynomial.forces import strain_energies


class HyperArrays(NamedTuple):
    """Constant arrays of a hyper-reduced model; r coordinates.

    Parameters
    ----------
    first, second, viscous, turning_derivatives
        As in `ReducedArrays`, but empty: nothing is condensed.
    mass, damping, linear, turning
        As in `ReducedArrays`; ``linear`` is the stiffness of the reference.
    store
        Chosen elements on the basis, the parts of a `KernelStore`.
    gradient
        Their gradient matrices times the basis, below each other, shape (sum of gradients, r).
    reference
        Internal force of the chosen elements at rest, shape (r,); the reference state carries it.
    stresses
        Space for the stresses of the chosen elements.
    """

    first: Indices
    second: Indices
    mass: Array
    damping: Array
    linear: Array
    viscous: Array
    turning: Array
    turning_derivatives: Array
    store: tuple[NDArray[Any], ...]
    gradient: Array
    reference: Array
    stresses: Array


@jit
def _extended(q: Array) -> Array:
    """Coordinates with the zero of held unknowns behind them, as the kernel reads them."""
    place = np.zeros(q.size + 1)
    place[:-1] = q
    return place


@jit
def element_force(arrays: HyperArrays, q: Array, v: Array, given: Array, force: Array) -> None:
    """Internal force less that of the reference, as `internal_force`; there is no stress per monomial to be given."""
    total = np.zeros(q.size + 1)
    add_forces(arrays.store, _extended(q), total, arrays.stresses, True, False, False)
    for i in range(q.size):
        force[i] = total[i] - arrays.reference[i]


@jit
def element_average(arrays: HyperArrays, start: Array, end: Array, v: Array, given: Array, force: Array) -> None:
    """As `average_force`."""
    total = np.zeros(start.size + 1)
    add_average_forces(arrays.store, _extended(start), _extended(end), total)
    for i in range(start.size):
        force[i] = total[i] - arrays.reference[i]


@jit
def element_tangent(arrays: HyperArrays, q: Array, given: Array) -> Array:
    """Tangent ``sum G' V (B' D B + sigma.Q) G``, as `tangent`: one product of tall matrices for all elements."""
    r, place = q.size, _extended(q)
    half = np.zeros(arrays.gradient.shape)
    start = 0
    for block in range(arrays.store[3].shape[0]):
        data = block_data(arrays.store, block)
        strains, count = data.initial_stress.shape
        gradients = data.gradients
        local, strain, stress = np.empty((r, PACK)), np.empty((strains, PACK)), np.empty((strains, PACK))
        g, slope, density = np.empty((gradients, PACK)), np.empty((strains, strains, PACK)), np.empty(PACK)
        b, db = np.empty((strains, gradients, PACK)), np.empty((strains, gradients, PACK))
        core = np.empty((gradients, gradients, PACK))
        for first in range(0, count, PACK):
            width = min(PACK, count - first)
            pack_strain(data, first, width, place, local, g, strain)
            pack_stress(data, first, width, strain, stress)
            if data.law != ELASTIC:
                call_law(data.law, stress, slope, density, data.law_parameters, width)
            pack_core(data, first, width, g, stress, slope, b, db, core)
            for e in range(width):
                row = start + (first + e) * gradients
                for i in range(gradients):
                    result = half[row + i]
                    for j in range(gradients):
                        factor = data.measure[first + e] * core[i, j, e]
                        if factor != 0.0:
                            other = arrays.gradient[row + j]
                            for k in range(r):
                                result[k] += factor * other[k]
        start += count * gradients
    return arrays.gradient.T @ half


@jit
def _element_energies(arrays: HyperArrays, q: Array) -> Array:
    result, total = np.empty(q.shape[0]), np.zeros(q.shape[1] + 1)
    for n in range(result.size):
        energy = add_forces(arrays.store, _extended(q[n]), total, arrays.stresses, False, True, False)
        result[n] = energy - np.dot(arrays.reference, q[n])
    return result


strain_energies.register(HyperArrays, _element_energies)


KERNELS[HyperArrays] = ForceKernels(element_force, element_average, element_tangent)
