"""Terms of the moving frame from its motion, compiled: for a step in Python and for many steps in one call."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.mechanics.inertia import LoadMoments
from tautflex.mechanics.products import add_moments
from tautflex.motion.coupling import Coupling
from tautflex.numeric import Array, jit


@jit
def frame_terms(motion: Array, frame: Any) -> tuple[Array, Array, Array]:
    """Matrices Z of G and of K_T, and the load Q_T, see `Coupling`.

    ``motion`` is a row of `Segment.rows`, ``frame`` what `frame_of` gives.
    """
    (gyroscopic, euler, centrifugal, factor), first, zeroth = frame
    x, y, z, a, b, c = motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]
    turning = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    speeding = np.array(((0.0, -c, b), (c, 0.0, -a), (-b, a, 0.0)))
    square = np.array(((-y * y - z * z, x * y, x * z), (x * y, -x * x - z * z, y * z), (x * z, y * z, -x * x - y * y)))
    load = np.zeros(zeroth.shape[1])
    if factor != 0.0:
        add_moments(first, speeding + square, 1.0, load)
        for k in range(3):
            push, row = motion[6 + k], zeroth[k]
            if push != 0.0:
                for i in range(load.size):
                    load[i] += push * row[i]
        for i in range(load.size):
            load[i] *= factor
    return 2.0 * turning * gyroscopic, speeding * euler + square * centrifugal, load


def frame_of(coupling: Coupling, moments: LoadMoments) -> Any:
    """Switches of the terms and what makes loads, for `frame_terms`."""
    switches = coupling.gyroscopic, coupling.euler, coupling.centrifugal, coupling.load_factor
    first, zeroth = (np.ascontiguousarray(part) for part in (moments.first_moment, moments.zeroth_moment))
    return tuple(float(one) for one in switches), first, zeroth
