"""The spin-up of a cantilever [Kane, Ryan & Banerjee 1987; Simo & Vu-Quoc 1988] as one file of numbers.

A problem file (``.npz``) holds ``length`` [m], ``axial_stiffness`` [N], ``bending_stiffness`` [N m^2],
``mass_per_length`` [kg/m], ``rate`` [rad/s] reached after ``duration`` [s], number of ``elements``, ``step`` [s],
``end`` [s] and ``spectral_radius`` of the generalized-alpha method.

A result file (``.npz``) holds ``time`` (sample) [s], ``extension`` and ``lag`` of the tip along and across the hub's
axis [m], ``seconds`` of processor time of the stepping, ``set_up_seconds`` before it, and ``details``, a JSON object.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable

import numpy as np

LENGTH, AXIAL_STIFFNESS, BENDING_STIFFNESS, MASS_PER_LENGTH = 10.0, 2.8e7, 1.4e4, 1.2
RATE, DURATION, END = 6.0, 15.0, 20.0
# Published: largest lag of the tip [m] near 6.8 s; steady extension w^2 rho A L^3/(3 EA) [m].
LARGEST_LAG, TIME_OF_LARGEST_LAG = -0.57, 6.8
EXTENSION = RATE**2 * MASS_PER_LENGTH * LENGTH**3 / (3.0 * AXIAL_STIFFNESS)


def spinup_problem(elements: int, step: float, end: float = END) -> dict[str, np.ndarray]:
    """Cantilever on a hub that is spun up.

    Parameters
    ----------
    elements
        Number of beam elements.
    step, end
        Step and duration [s].

    Returns
    -------
    dict
        The numbers of a problem file.
    """
    values = {
        "length": LENGTH,
        "axial_stiffness": AXIAL_STIFFNESS,
        "bending_stiffness": BENDING_STIFFNESS,
        "mass_per_length": MASS_PER_LENGTH,
        "rate": RATE,
        "duration": DURATION,
        "elements": elements,
        "step": step,
        "end": end,
        "spectral_radius": 0.8,
    }
    return {name: np.array(value) for name, value in values.items()}


def median_of_three(timed: Callable[[], float]) -> float:
    """Processor seconds of a run [s]: its own if it takes more than one, else the median of three."""
    first = timed()
    return first if first > 1.0 else statistics.median((first, timed(), timed()))
