"""The same cantilever on a hub that is free to turn, driven by a torque, as one file of numbers.

A problem file holds what `spinup_problem` describes, but for ``rate`` and ``duration`` of the spin-up; in their place
``inertia`` of the hub about its axis [kg m^2] and ``torque`` [N m], which is ``torque (1 - cos(2 pi t/duration))``
until ``duration`` [s] and nothing later. The hub's centre is at rest.

A result file holds what a spin-up's does and ``angle`` (sample) of the hub [rad].
"""

from __future__ import annotations

import numpy as np
from spinup_problem import LENGTH, MASS_PER_LENGTH, spinup_problem

# Half of the beam's own about the axis; both would turn at RATE if the beam were rigid.
INERTIA = MASS_PER_LENGTH * LENGTH**3 / 6.0
RATE, DURATION, END = 3.0, 5.0, 15.0
TORQUE = RATE * 3.0 * INERTIA / DURATION


def hub_problem(elements: int, step: float) -> dict[str, np.ndarray]:
    """Cantilever on a free hub: number of elements and step [s] -> numbers of a problem file."""
    values = {"inertia": INERTIA, "torque": TORQUE, "duration": DURATION}
    return spinup_problem(elements, step, END) | {name: np.array(value) for name, value in values.items()}
