"""Unit quaternions (scalar first) that turn vectors of the floating frame into the inertial frame.

Own, because a free hub asks for the matrix in every step: 3 us here, 18 us through scipy's Rotation.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def cross(a: Array, b: Array) -> Array:
    """Cross product of two vectors, shape (3,); numpy's general one takes thirty times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def product(left: Array, right: Array) -> Array:
    """Quaternion product, shape (4,): the rotation ``right`` followed by ``left``."""
    a, u = left[0], left[1:]
    b, v = right[0], right[1:]
    return np.concatenate([[a * b - u @ v], a * v + b * u + cross(u, v)])


def exponential(turn: Array) -> Array:
    """Quaternion of a rotation vector [rad], shape (3,) -> (4,)."""
    half = 0.5 * float(np.linalg.norm(turn))
    # np.sinc(x) is sin(pi x)/(pi x): no division by a vanishing angle.
    return np.concatenate([[np.cos(half)], 0.5 * np.sinc(half / np.pi) * turn])


def matrix(quaternion: Array) -> Array:
    """Rotation matrix A of a unit quaternion, shape (3, 3)."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
