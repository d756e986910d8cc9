"""Algebra of vectors and quaternions as tuples, which compiled code keeps in registers.

An array of three numbers costs more to make than all that is done with it.
"""

from __future__ import annotations

import numpy as np

from tautflex.numeric import Array, jit

Triple = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Axes = tuple[Triple, Triple, Triple]


@jit
def triple(values: Array, first: int) -> Triple:
    """Three numbers of an array from a place on."""
    return values[first], values[first + 1], values[first + 2]


@jit
def put(values: Array, first: int, vector: Triple) -> None:
    """Write a vector into an array from a place on."""
    values[first], values[first + 1], values[first + 2] = vector


@jit
def plus(a: Triple, factor: float, b: Triple) -> Triple:
    """``a + factor b``."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@jit
def crossed(a: Triple, b: Triple) -> Triple:
    """``a x b``."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@jit
def times(axes: Axes, b: Triple) -> Triple:
    """Matrix, by its rows, times a vector."""
    (p, q, r), (x, y, z) = axes, b
    return (
        p[0] * x + p[1] * y + p[2] * z,
        q[0] * x + q[1] * y + q[2] * z,
        r[0] * x + r[1] * y + r[2] * z,
    )


@jit
def back(axes: Axes, b: Triple) -> Triple:
    """The transposed matrix times a vector."""
    (p, q, r), (x, y, z) = axes, b
    return (
        p[0] * x + q[0] * y + r[0] * z,
        p[1] * x + q[1] * y + r[1] * z,
        p[2] * x + q[2] * y + r[2] * z,
    )


@jit
def after(left: Quaternion, right: Quaternion) -> Quaternion:
    """Quaternion product: the rotation ``right`` followed by ``left``."""
    (a, b, c, d), (w, x, y, z) = left, right
    return (
        a * w - (b * x + c * y + d * z),
        a * x + w * b + (c * z - d * y),
        a * y + w * c + (d * x - b * z),
        a * z + w * d + (b * y - c * x),
    )


@jit
def quaternion_of(turn: Triple) -> Quaternion:
    """Unit quaternion, scalar first, of a rotation vector [rad]."""
    x, y, z = turn
    half = 0.5 * np.sqrt(x * x + y * y + z * z)
    # No division by a vanishing angle.
    share = 0.5 * np.sin(half) / half if half > 0.0 else 0.5
    return np.cos(half), share * x, share * y, share * z


@jit
def axes_of(quaternion: Quaternion) -> Axes:
    """Rows of the rotation matrix of a unit quaternion, which turns vectors of the floating frame into the inertial."""
    w, x, y, z = quaternion
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
