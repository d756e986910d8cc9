"""Attitude of the floating frame along a maneuver.

Own (Magnus series), because scipy's solve_ivp would lose what is exact here: turns about a fixed axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.motion.kinematics import Maneuver, Segment
from tautflex.motion.rotations import IDENTITY, exponential, product
from tautflex.numeric import Array

# Steps per segment at least, so that no short motion inside a long quiet one is stepped over.
_FEWEST_STEPS = 32
_MOST_DOUBLINGS = 8
_TOLERANCE = 1e-11
_GAUSS = 0.5 + np.sqrt(0.15) * np.array([-1.0, 0.0, 1.0])


def attitude(maneuver: Maneuver, times: ArrayLike, initial: ArrayLike = IDENTITY) -> Array:
    """Attitude quaternion of the floating frame, from its angular velocity ``q' = q (0, w)/2``.

    Segments are marched through by the sixth-order Magnus method [Blanes, Casas, Oteo & Ros 2009, (255)], which is
    exact while the axis stays; steps are halved until that changes nothing beyond 1e-11.

    Parameters
    ----------
    maneuver
        Rigid motion; its discontinuities are respected.
    times
        Instants >= 0 [s], rising, shape (n,).
    initial
        Attitude at t = 0, scalar first, normalised here, shape (4,).

    Returns
    -------
    numpy.ndarray
        Unit quaternions, scalar first, ``v_space = q v_frame q*``, shape (n, 4). Their sign follows continuously from
        the initial one.

    Raises
    ------
    InputError
        If times fall or begin before 0, or the initial attitude is zero.
    NotConvergedError
        If the angular velocity is too rough to be followed.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> scalar, *vector = tf.attitude(tf.Slew(angle=np.pi, duration=2.0), [1.0])[0]
    >>> print(f"{2 * np.arccos(scalar):.4f} rad after half of it")
    1.5708 rad after half of it
    """
    checks.instance("maneuver", maneuver, Maneuver, "a maneuver such as Stop(rate=0.628, duration=1.0)")
    instants = checks.float_array("times", times, (None,))
    if instants.size and (instants[0] < 0.0 or np.any(np.diff(instants) < 0.0)):
        raise InputError("times: expected rising instants >= 0; sort them and begin at the start of the maneuver")
    q = np.array(checks.float_array("initial", initial, (4,)))
    if not q.any():
        raise InputError("initial: expected a rotation, got zeros; no rotation is (1, 0, 0, 0)")
    q /= np.linalg.norm(q)
    result = np.zeros((len(instants), 4))
    for segment in maneuver.segments():
        if not instants.size or instants[-1] < segment.start:
            break
        inside = (instants >= segment.start) & (instants <= segment.end)
        stops = np.append(instants[inside], min(segment.end, float(instants[-1])))
        turns = _turns(segment, stops)
        result[inside] = np.array([product(q, turn) for turn in turns[:-1]]).reshape(-1, 4)
        q = product(q, turns[-1])
    return result


def _turns(segment: Segment, stops: Array) -> Array:
    """Turns from the start of a segment to each of the stops within it, shape (stop, 4)."""
    before = _march(segment, stops, 1)
    for doubling in range(1, _MOST_DOUBLINGS):
        turns = _march(segment, stops, 2**doubling)
        if np.abs(turns - before).max() < _TOLERANCE:
            return turns
        before = turns
    raise NotConvergedError(
        f"attitude: the angular velocity between {segment.start:g} and {stops[-1]:g} s is too rough to be followed; "
        "smooth its table"
    )


def _march(segment: Segment, stops: Array, refinement: int) -> Array:
    largest = (stops[-1] - segment.start) / _FEWEST_STEPS
    turns, q, time = np.zeros((len(stops), 4)), IDENTITY, segment.start
    for row, stop in enumerate(stops):
        if stop > time:
            count = refinement * max(1, int(np.ceil((stop - time) / largest * (1.0 - 1e-12))))
            for vector in _rotation_vectors(segment, time, (stop - time) / count, count):
                q = product(q, exponential(vector))
            time = stop
        turns[row] = q
    return turns / np.linalg.norm(turns, axis=1, keepdims=True)


def _rotation_vectors(segment: Segment, time: float, step: float, count: int) -> Array:
    """Rotation vector of each step, shape (count, 3).

    The Magnus series is written for ``Y' = A Y``; here the rates stand on the right, which turns every bracket round.
    """
    nodes = time + step * (np.arange(count)[:, None] + _GAUSS)
    rates = np.array([[segment.motion(node).angular_velocity for node in line] for line in nodes.tolist()])
    one = step * rates[:, 1]
    two = np.sqrt(15.0) / 3.0 * step * (rates[:, 2] - rates[:, 0])
    three = 10.0 / 3.0 * step * (rates[:, 2] - 2.0 * rates[:, 1] + rates[:, 0])
    first = np.cross(two, one)
    second = -np.cross(2.0 * three + first, one) / 60.0
    return one + three / 12.0 + np.cross(two + second, -20.0 * one - three + first) / 240.0
