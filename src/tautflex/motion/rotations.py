"""Unit quaternions (scalar first) that turn vectors of the floating frame into the inertial frame.

Own, because a free hub asks for the matrix in every step: 3 us here, 18 us through scipy's Rotation.
"""

from __future__ import annotations

import numpy as np

from tautflex.errors import InputError
from tautflex.motion.triples import after, axes_of, quaternion_of
from tautflex.numeric import Array, jit

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


@jit
def product(left: Array, right: Array) -> Array:
    """Quaternion product, shape (4,): the rotation ``right`` followed by ``left``."""
    return np.array(after((left[0], left[1], left[2], left[3]), (right[0], right[1], right[2], right[3])))


@jit
def exponential(turn: Array) -> Array:
    """Quaternion of a rotation vector [rad], shape (3,) -> (4,)."""
    return np.array(quaternion_of((turn[0], turn[1], turn[2])))


def rotation_vector(quaternion: Array) -> Array:
    """Rotation vector of a unit quaternion [rad], of at most half a turn, shape (4,) -> (3,): `exponential` back."""
    q = quaternion if quaternion[0] >= 0.0 else -quaternion
    sine = float(np.linalg.norm(q[1:]))
    share = 2.0 * np.arctan2(sine, q[0]) / sine if sine > 0.0 else 2.0
    return np.asarray(share * q[1:])


def rotation_vectors(quaternions: Array) -> Array:
    """Rotation vectors of quaternions in a row [rad], shape (n, 4) -> (n, 3), that go on beyond half a turn.

    Of the vectors of one rotation, whole turns about its axis apart, each is the one nearest to the vector before.
    """
    found, last = np.zeros((len(quaternions), 3)), np.zeros(3)
    for k, vector in enumerate(map(rotation_vector, quaternions)):
        angle = float(np.linalg.norm(vector))
        axis = vector / angle if angle > 0.0 else last / (float(np.linalg.norm(last)) or 1.0)
        found[k] = last = (angle + 2.0 * np.pi * round((float(last @ axis) - angle) / (2.0 * np.pi))) * axis
    return found


@jit
def matrix(quaternion: Array) -> Array:
    """Rotation matrix A of a unit quaternion, shape (3, 3)."""
    return np.array(axes_of((quaternion[0], quaternion[1], quaternion[2], quaternion[3])))


def continuous_quaternions(rows: Array) -> Array:
    """Normalise quaternions, shape (n, 4), and choose their signs so that each is the nearer one to the row before.

    InputError if a row is zero, or two rows are half a turn apart, where both ways round are equally long.
    """
    lengths = np.linalg.norm(rows, axis=1)
    if not np.all(lengths > 0.0):
        row = int(np.flatnonzero(~(lengths > 0.0))[0])
        raise InputError(f"quaternions: expected a rotation, got zeros in row {row}; no rotation is (1, 0, 0, 0)")
    unit = rows / lengths[:, None]
    cosines = np.sum(unit[1:] * unit[:-1], axis=1)
    opposite = np.flatnonzero(np.abs(cosines) < 1e-6)
    if opposite.size:
        row = int(opposite[0])
        raise InputError(
            f"quaternions: expected less than half a turn from row to row, got half a turn after row {row}; "
            "give more rows"
        )
    signs = np.concatenate([[1.0], np.cumprod(np.sign(cosines))])
    return unit * signs[:, None]


def body_rates(p: Array, slope: Array, curvature: Array) -> tuple[Array, Array]:
    """Angular velocity [rad/s] and acceleration [rad/s^2] in the frame's own axes, shapes (3,).

    Of a quaternion of any length and its derivatives by time, shapes (4,): ``w = 2 vec(p* p')/|p|^2`` and ``dw = 2
    vec(p* p'')/|p|^2 - 2 w (p . p')/|p|^2``, the motion of ``p/|p|`` without ever forming it.
    """
    w, x, y, z = p
    vector_part = 2.0 / float(p @ p) * np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    velocity = vector_part @ slope
    return velocity, vector_part @ curvature - 2.0 * float(p @ slope) / float(p @ p) * velocity
