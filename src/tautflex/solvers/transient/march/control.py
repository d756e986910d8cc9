"""Size of adaptive steps, compiled: the same decisions for the driver's steps and for those of a stretch.

``limits`` holds, in the order of their names here, the spacing of the grid of results, the smallest and the largest
step [s], the tolerance, of the steps at hand their size [s] and their error over the change of the acceleration, per
size [s], and the end of the first step of the grid [s]. ``standing`` holds which power of `QUANTUM` the size is of the
spacing, the ratio of the last error to the allowed one, and the size of its step [s].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.numeric import Array, jit

SPACING, SMALLEST, LARGEST, TOLERANCE, SIZE, SHARE, KICKED = range(7)
LEVEL, RATIO, RATED = range(3)

# Step sizes are the spacing times powers of this, so that a size comes back and its factors with it.
QUANTUM = np.sqrt(2.0)
# Share of an error that is still expected one step later: vibration passes through phases without any.
_MEMORY = 0.95
# Limits of one change, aim of the controller, and its exponents for an error of order h^2 [Gustafsson 1991].
_SMALLEST_FACTOR, _LARGEST_FACTOR, _AIM = 0.2, 2.0, 0.8
_INTEGRAL, _PROPORTIONAL = 0.7 / 2.0, 0.4 / 2.0


@jit
def quantised(size: float, spacing: float) -> float:
    """Power of `QUANTUM` of the largest step on the ladder that is not above a size [s]."""
    return float(np.floor(np.log(size / spacing) / np.log(QUANTUM) + 1e-6))


@jit
def changed(ratio: float, last: float) -> float:
    """Factor of the step size: proportional-integral control after a kept step, integral (``last`` < 0) otherwise."""
    ratio = max(ratio, 1e-8)
    factor = (_AIM / ratio) ** 0.5 if last < 0.0 else (_AIM / ratio) ** _INTEGRAL * (last / ratio) ** _PROPORTIONAL
    return min(max(factor, _SMALLEST_FACTOR), _LARGEST_FACTOR)


@jit
def choose_next(standing: Array, limits: Array, size: float, nominal: float, ratio: float) -> None:
    """Set the size of the next step; a step cut short at a landing says little about longer ones."""
    last = standing[RATIO]
    ratio = max(ratio, _MEMORY * last * (size / standing[RATED]) ** 2)
    factor = changed(ratio, last)
    standing[RATIO], standing[RATED] = max(ratio, 1e-4), size
    if size < 0.99 * nominal and size * factor < nominal:
        return
    wanted = quantised(min(size * factor, limits[LARGEST]), limits[SPACING])
    # Up only by a whole quantum, down only where the next step would fail: the factors stay.
    if wanted > standing[LEVEL] or (wanted < standing[LEVEL] and ratio > 1.0 - 0.1):
        standing[LEVEL] = wanted


@jit
def error_ratio(found: Array, tolerance: float, fastest: Array, speeds: Array, kick: Array, kicked: bool) -> float:
    """Largest error over the allowed one, which is the tolerance times the largest speed of the run so far.

    ``kick`` counts as a speed where a step starts in the first of the grid (``kicked``).
    """
    largest = 0.0
    for i in range(found.size):
        if found[i] > 0.0:
            speed = max(fastest[i], speeds[i])
            if kicked:
                speed = max(speed, kick[i])
            largest = max(largest, found[i] / (tolerance * speed) if speed > 0.0 else np.inf)
    return largest


@jit
def is_kept(control: Any, begins: float, found: float, speed: float) -> bool:
    """Whether a step that begins at an instant [s] keeps the tolerance; then the next one is chosen.

    ``control`` holds limits, standing, largest speeds so far, kick, number of steps beyond the tolerance.
    """
    limits, standing, fastest, kick, beyond, _ = control
    size, speeds = limits[SIZE], np.array([speed])
    ratio = error_ratio(np.array([found]), limits[TOLERANCE], fastest, speeds, kick, begins < limits[KICKED])
    if ratio > 1.0:
        if size > limits[SMALLEST] * (1.0 + 1e-9):
            return False
        beyond[0] += 1
    fastest[0] = max(fastest[0], speed)
    choose_next(standing, limits, size, size, ratio)
    return True
