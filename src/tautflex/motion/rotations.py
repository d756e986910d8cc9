"""Unit quaternions (scalar first) that turn vectors of the floating frame into the inertial frame.

Own, because a free hub asks for the matrix in every step: 3 us here, 18 us through scipy's Rotation.
"""

from __future__ import annotations

import numpy as np

from tautflex.numeric import Array, jit_in_order

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def cross(a: Array, b: Array) -> Array:
    """Cross product of two vectors, shape (3,); numpy's general one takes thirty times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@jit_in_order
def product(left: Array, right: Array) -> Array:
    """Quaternion product, shape (4,): the rotation ``right`` followed by ``left``."""
    result = np.empty(4)
    result[0] = left[0] * right[0] - (left[1] * right[1] + left[2] * right[2] + left[3] * right[3])
    result[1] = left[0] * right[1] + right[0] * left[1] + (left[2] * right[3] - left[3] * right[2])
    result[2] = left[0] * right[2] + right[0] * left[2] + (left[3] * right[1] - left[1] * right[3])
    result[3] = left[0] * right[3] + right[0] * left[3] + (left[1] * right[2] - left[2] * right[1])
    return result


@jit_in_order
def exponential(turn: Array) -> Array:
    """Quaternion of a rotation vector [rad], shape (3,) -> (4,)."""
    half = 0.5 * np.sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2])
    # No division by a vanishing angle.
    share = 0.5 * np.sin(half) / half if half > 0.0 else 0.5
    return np.array([np.cos(half), share * turn[0], share * turn[1], share * turn[2]])


@jit_in_order
def matrix(quaternion: Array) -> Array:
    """Rotation matrix A of a unit quaternion, shape (3, 3)."""
    w, x, y, z = quaternion[0], quaternion[1], quaternion[2], quaternion[3]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
