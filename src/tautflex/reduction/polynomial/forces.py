r"""Compiled forces of a reduced model.

The third-degree force is ``Y' F'F y``: the monomials y make stress fields ``F y``, which act on the slopes
``Y = dy/deta``. There are as many fields as the structure has independent states of self-stress, far fewer than
monomials.
"""

from __future__ import annotations

from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching import dispatch
from tautflex.reduction.polynomial.monomials import monomials

# Of any reduced model, by the type of its arrays.
_internal_force = dispatch.internal_force


class ReducedArrays(NamedTuple):
    """Constant arrays of a reduced model; r coordinates, m monomials.

    Parameters
    ----------
    first, second
        Indices of the monomials, shape (m,).
    mass, damping, linear
        Shape (r, r).
    quadratic
        Second-degree force per monomial, shape (r, m), or (0, m) if there is none.
    fields
        F, shape (k, m): the third-degree force is ``Y' F'F y``.
    viscous
        Damping of the static derivatives as ``Y' V'V dy/dt``, shape (l, m).
    turning
        ``M(Z)`` of the coordinates by (row, column) of Z, shape (3, 3, r, r).
    turning_derivatives
        The same between static derivatives (per monomial) and coordinates, shape (3, 3, m, r).
    """

    first: Indices
    second: Indices
    mass: Array
    damping: Array
    linear: Array
    quadratic: Array
    fields: Array
    viscous: Array
    turning: Array
    turning_derivatives: Array


class FrameTerms(NamedTuple):
    """Terms of the moving frame at a row of instants; arrays with one row hold for all.

    Parameters
    ----------
    velocity, displacement
        Matrices Z of G and K_T, shape (n, 3, 3).
    load
        Inertial load less inputs, shape (n, r).
    stress
        What loads on the static derivatives and inputs add to the stress per monomial, shape (n, m); where stresses act
        in elements, the numbers of the inputs.
    turns
        Whether any Z is not zero.
    """

    velocity: Array
    displacement: Array
    load: Array
    stress: Array
    turns: bool


# Loops in place of array expressions: those make the compiler generate shape checks and error texts, half of its time.
@jit
def dot(x: Array, y: Array) -> float:
    """Inner product of two short vectors, without leaving compiled code."""
    total = 0.0
    for i in range(x.size):
        total += x[i] * y[i]
    return total


@jit
def add_times(factor: float, matrix: Array, vector: Array, result: Array) -> None:
    """Add ``factor * matrix @ vector`` to ``result``."""
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(vector.size):
            total += matrix[i, j] * vector[j]
        result[i] += factor * total


@jit
def _pair_products(arrays: ReducedArrays, a: Array, b: Array) -> Array:
    """Products ``a_i b_j`` of the pairs that make the monomials, shape (m,)."""
    result = np.empty(arrays.first.size)
    for k in range(result.size):
        result[k] = a[arrays.first[k]] * b[arrays.second[k]]
    return result


@jit
def _rates(arrays: ReducedArrays, q: Array, v: Array) -> Array:
    """Rates of the monomials, shape (m,)."""
    result = np.empty(arrays.first.size)
    for k in range(result.size):
        i, j = arrays.first[k], arrays.second[k]
        result[k] = q[i] * v[j] + v[i] * q[j]
    return result


@jit
def add_product(factor: Array, vector: Array, result: Array) -> None:
    """Add ``F'F vector`` to ``result``; four rows of F at a time save memory traffic."""
    fours = factor.shape[0] // 4 * 4
    for k in range(0, fours, 4):
        f, g, h, e = factor[k], factor[k + 1], factor[k + 2], factor[k + 3]
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for m in range(vector.size):
            a += f[m] * vector[m]
            b += g[m] * vector[m]
            c += h[m] * vector[m]
            d += e[m] * vector[m]
        for m in range(vector.size):
            result[m] += a * f[m] + b * g[m] + c * h[m] + d * e[m]
    for k in range(fours, factor.shape[0]):
        f, a = factor[k], 0.0
        for m in range(vector.size):
            a += f[m] * vector[m]
        for m in range(vector.size):
            result[m] += a * f[m]


@jit
def internal_force(arrays: ReducedArrays, q: Array, v: Array, given: Array, force: Array) -> None:
    """Fill ``force`` with linear, second- and third-degree forces, and those of a given stress per monomial.

    The static derivatives' damping belongs here: at large deflections it is stiff, and a step has to solve for it.
    Where ``force`` has room for 2 r numbers, the second half is filled with the part that is not elastic.
    """
    r, y, other = q.size, _pair_products(arrays, q, q), given.copy()
    stress = np.zeros(y.size)
    force.fill(0.0)
    add_times(1.0, arrays.linear, q, force)
    add_times(1.0, arrays.quadratic, y, force)
    add_product(arrays.fields, y, stress)
    if arrays.viscous.shape[0]:
        add_product(arrays.viscous, _rates(arrays, q, v), other)
    for k in range(y.size):
        i, j = arrays.first[k], arrays.second[k]
        force[i] += (stress[k] + other[k]) * q[j]
        force[j] += (stress[k] + other[k]) * q[i]
        if force.size > r:
            force[r + i] += other[k] * q[j]
            force[r + j] += other[k] * q[i]


@jit
def average_force(arrays: ReducedArrays, start: Array, end: Array, v: Array, given: Array, force: Array) -> None:
    """Internal force averaged along the way from start to end; its work is the change of the strain energy.

    Two Gauss points are exact for a force of third degree [average vector field, Quispel & McLaren 2008].
    """
    own, place = np.empty(force.size), np.empty(start.size)
    force.fill(0.0)
    for side in (-1.0, 1.0):
        share = 0.5 + side * 0.5 / np.sqrt(3.0)
        for i in range(start.size):
            place[i] = start[i] + share * (end[i] - start[i])
        internal_force(arrays, place, v, given, own)
        for i in range(force.size):
            force[i] += 0.5 * own[i]


@jit
def derivative_forces(
    arrays: ReducedArrays, frame: FrameTerms, row: int, q: Array, v: Array, stress: Array, force: Array
) -> None:
    """Fill what static derivatives do besides answering statically: stress per monomial, force on the coordinates.

    The load offsets them, and the rotating frame couples them to the coordinates, both small and smooth, so a step
    takes them at its predicted state.
    """
    r, m = q.size, arrays.first.size
    at = row % frame.stress.shape[0]
    for k in range(stress.size):
        stress[k] = frame.stress[at, k]
    force.fill(0.0)
    if not frame.turns:
        return
    y, rate = _pair_products(arrays, q, q), _rates(arrays, q, v)
    at = row % frame.velocity.shape[0]
    for a in range(3):
        for b in range(3):
            gyro, turn = frame.velocity[at, a, b], frame.displacement[at, a, b]
            if gyro == 0.0 and turn == 0.0:
                continue
            for k in range(m):
                here = gyro * rate[k] + turn * y[k]
                total = 0.0
                for j in range(r):
                    total += arrays.turning_derivatives[a, b, k, j] * (gyro * v[j] + turn * q[j])
                    # M_ap(Z) = M_pa(Z')'
                    force[j] += arrays.turning_derivatives[b, a, k, j] * here
                stress[k] += total


@jit
def frame_matrices(
    arrays: ReducedArrays, frame: FrameTerms, row: int, on_velocity: Array, on_displacement: Array
) -> None:
    """Fill damping plus gyroscopic matrix, and K_T, of the coordinates."""
    r = arrays.mass.shape[0]
    on_displacement.fill(0.0)
    for i in range(r):
        for j in range(r):
            on_velocity[i, j] = arrays.damping[i, j]
    if not frame.turns:
        return
    at = row % frame.velocity.shape[0]
    for a in range(3):
        for b in range(3):
            gyro, turn = frame.velocity[at, a, b], frame.displacement[at, a, b]
            if gyro == 0.0 and turn == 0.0:
                continue
            for i in range(r):
                for j in range(r):
                    on_velocity[i, j] += gyro * arrays.turning[a, b, i, j]
                    on_displacement[i, j] += turn * arrays.turning[a, b, i, j]


@jit
def total_force(arrays: Any, frame: FrameTerms, row: int, q: Array, v: Array, force: Array) -> None:
    """Fill ``force`` with all forces but inertia."""
    r = q.size
    stress, other = np.empty(frame.stress.shape[1]), np.empty(r)
    on_velocity, on_displacement = np.empty((r, r)), np.empty((r, r))
    derivative_forces(arrays, frame, row, q, v, stress, other)
    frame_matrices(arrays, frame, row, on_velocity, on_displacement)
    _internal_force(arrays, q, v, stress, force)
    load = frame.load[row % frame.load.shape[0]]
    for i in range(r):
        force[i] += other[i] + load[i]
    add_times(1.0, on_velocity, v, force)
    add_times(1.0, on_displacement, q, force)


@jit
def slopes(arrays: ReducedArrays, q: Array) -> Array:
    """Derivatives of the monomials, shape (m, r)."""
    result = np.zeros((arrays.first.size, q.size))
    for k in range(arrays.first.size):
        result[k, arrays.first[k]] += q[arrays.second[k]]
        result[k, arrays.second[k]] += q[arrays.first[k]]
    return result


@jit
def tangent(arrays: ReducedArrays, q: Array, given: Array) -> Array:
    """Derivative of the internal force at q under a given stress per monomial, shape (r, r)."""
    slope, stress = slopes(arrays, q), given.copy()
    add_product(arrays.fields, _pair_products(arrays, q, q), stress)
    moved = arrays.fields @ slope
    result = moved.T @ moved
    for i in range(q.size):
        for j in range(q.size):
            result[i, j] += arrays.linear[i, j]
            if arrays.quadratic.shape[0]:
                for k in range(stress.size):
                    result[i, j] += arrays.quadratic[i, k] * slope[k, j]
    for k in range(stress.size):
        result[arrays.first[k], arrays.second[k]] += stress[k]
        result[arrays.second[k], arrays.first[k]] += stress[k]
    return result


def energies(arrays: Any, q: Array, v: Array) -> Array:
    """Kinetic and strain energy [J] of rows of states (n, r), shape (n, 2)."""
    return np.stack([0.5 * np.einsum("nr,nr->n", v @ arrays.mass, v), strain_energies(arrays, q)], axis=1)


@singledispatch
def strain_energies(arrays: Any, q: Array, given: Array | None = None) -> Array:
    """Strain energy [J] of rows of coordinates (n, r), shape (n,), under what is given to the internal force."""
    y = monomials(q)
    fields = y @ arrays.fields.T
    strain = 0.5 * np.einsum("nr,nr->n", q @ arrays.linear, q) + 0.5 * np.einsum("nk,nk->n", fields, fields)
    if len(arrays.quadratic):
        strain += np.einsum("nr,nr->n", y @ arrays.quadratic.T, q) / 3.0
    if given is not None:
        strain += np.einsum("nm,nm->n", y, given)
    return np.asarray(strain)


def rows_from(frame: FrameTerms, first: int) -> FrameTerms:
    """FrameTerms terms from one instant on; those that hold for all stay."""
    velocity, displacement, load, stress = (part if len(part) == 1 else part[first:] for part in frame[:4])
    return FrameTerms(velocity, displacement, load, stress, frame.turns)


dispatch.KERNELS[ReducedArrays] = dispatch.ForceKernels(internal_force, average_force, tangent)
