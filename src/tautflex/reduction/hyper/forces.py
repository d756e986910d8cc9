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
    rest, columns
        Their initial stresses without inputs, and what a unit of each of n inputs adds, below each other as in
        ``stresses``, shapes (k,) and (n, k); (0, k): none. What answers the inputs at once are n more unknowns of the
        store behind the coordinates.
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
    rest: Array
    columns: Array


@jit
def _extended(arrays: HyperArrays, q: Array, given: Array) -> Array:
    """Coordinates, numbers of inputs (none are zeros), and the zero of held unknowns, as the kernel reads them."""
    place = np.zeros(q.size + arrays.columns.shape[0] + 1)
    place[: q.size] = q
    place[q.size : q.size + given.size] = given
    return place


@jit
def _restress(arrays: HyperArrays, given: Array) -> None:
    """Give the chosen elements the initial stresses of inputs."""
    if arrays.columns.shape[0] == 0:
        return
    start = 0
    for block in range(arrays.store[3].shape[0]):
        stress = block_data(arrays.store, block).initial_stress
        for s in range(stress.shape[0]):
            for e in range(stress.shape[1]):
                total = arrays.rest[start]
                for k in range(given.size):
                    total += arrays.columns[k, start] * given[k]
                stress[s, e] = total
                start += 1


@jit
def element_force(arrays: HyperArrays, q: Array, v: Array, given: Array, force: Array) -> None:
    """Internal force less that of the reference, as `internal_force`; what is given are the numbers of inputs."""
    _restress(arrays, given)
    place = _extended(arrays, q, given)
    total = np.zeros(place.size)
    add_forces(arrays.store, place, total, arrays.stresses, True, False, False)
    force.fill(0.0)
    for i in range(q.size):
        force[i] = total[i] - arrays.reference[i]


@jit
def element_average(arrays: HyperArrays, start: Array, end: Array, v: Array, given: Array, force: Array) -> None:
    """As `average_force`."""
    _restress(arrays, given)
    first, last = _extended(arrays, start, given), _extended(arrays, end, given)
    total = np.zeros(first.size)
    add_average_forces(arrays.store, first, last, total)
    force.fill(0.0)
    for i in range(start.size):
        force[i] = total[i] - arrays.reference[i]


@jit
def element_tangent(arrays: HyperArrays, q: Array, given: Array) -> Array:
    """Tangent ``sum G' V (B' D B + sigma.Q) G``, as `tangent`: one product of tall matrices for all elements."""
    _restress(arrays, given)
    r, place = q.size, _extended(arrays, q, given)
    half = np.zeros(arrays.gradient.shape)
    start = 0
    for block in range(arrays.store[3].shape[0]):
        data = block_data(arrays.store, block)
        strains, count = data.initial_stress.shape
        gradients = data.gradients
        local, strain, stress = np.empty((place.size - 1, PACK)), np.empty((strains, PACK)), np.empty((strains, PACK))
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
def _element_energies(arrays: HyperArrays, q: Array, given: Array) -> Array:
    result, total = np.empty(q.shape[0]), np.zeros(q.shape[1] + arrays.columns.shape[0] + 1)
    for n in range(result.size):
        _restress(arrays, given[n])
        place = _extended(arrays, q[n], given[n])
        energy = add_forces(arrays.store, place, total, arrays.stresses, False, True, False)
        result[n] = energy - np.dot(arrays.reference, q[n])
    return result


@strain_energies.register
def _(arrays: HyperArrays, q: Array, given: Array | None = None) -> Array:
    return np.asarray(_element_energies(arrays, q, np.zeros((len(q), 0)) if given is None else given))


KERNELS[HyperArrays] = ForceKernels(element_force, element_average, element_tangent)
