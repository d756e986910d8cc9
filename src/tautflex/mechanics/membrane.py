"""Where a film is taut, wrinkled or slack, and how much of it."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.system import StructuralSystem

Array = NDArray[np.float64]

_jit = numba.njit(cache=True, error_model="numpy")


FILM_STATES = ("taut", "wrinkled", "slack")


@_jit
def film_state(sx: float, sy: float, txy: float, poisson_ratio: float) -> int:
    """Index in `FILM_STATES` of a plane stress, elastic trial or tension-field alike (mixed criterion)."""
    mean = 0.5 * (sx + sy)
    radius = np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
    # A uniaxial stress is taut in spite of its round-off.
    if mean - radius >= -1e-12 * (mean + radius) and mean + radius > 0.0:
        return 0
    # Major principal strain of the trial stress, times E.
    return 1 if mean + radius - poisson_ratio * (mean - radius) > 0.0 else 2


class HasSystem(Protocol):
    """Anything built on a system, such as a prestressed state."""

    @property
    def system(self) -> StructuralSystem:
        """The compiled structure."""
        ...


class FilmSurvey(NamedTuple):
    """State of all film elements at one instant.

    Parameters
    ----------
    smallest, largest
        Extreme principal resultants [N/m]; NaN without a film.
    element
        Film element with the smallest one, -1 without a film.
    wrinkled, slack
        Parts of the film's area in these states [-]; NaN without a film.
    """

    smallest: float
    largest: float
    element: int
    wrinkled: float
    slack: float


def film_states(source: StructuralSystem | HasSystem, q: Array | None = None) -> NDArray[np.int8]:
    """State of each film element: 0 taut, 1 wrinkled, 2 slack [mixed criterion, theory.md 2].

    Parameters
    ----------
    source
        Prestressed state or system. With the elastic law, the answer says where a real film would wrinkle.
    q
        Free unknowns [m, rad], shape (size,); None is the reference state.

    Returns
    -------
    numpy.ndarray
        Shape (t,).
    """
    system = source if isinstance(source, StructuralSystem) else source.system
    system.force(np.zeros(system.size) if q is None else q)
    return current_film_states(system)


def current_film_states(system: StructuralSystem) -> NDArray[np.int8]:
    """States of the film elements at the last force evaluation, shape (t,)."""
    pieces = [np.zeros(0, dtype=np.int8)]
    for index in system.block_index("membrane"):
        pieces.append(_states(system.stress[index].T, system.blocks[index].material.poisson_ratio))
    return np.concatenate(pieces)


def survey_film(system: StructuralSystem) -> FilmSurvey:
    """Extreme resultants and area fractions at the last force evaluation."""
    smallest, largest, element = np.inf, -np.inf, -1
    areas, first = np.zeros(3), 0
    for stress, poisson_ratio, area, thickness in system.films:
        low, high, worst = _survey(stress, poisson_ratio, area, areas)
        if low * thickness < smallest:
            smallest, element = low * thickness, first + worst
        largest = max(largest, high * thickness)
        first += len(area)
    if element < 0:
        return FilmSurvey(np.nan, np.nan, -1, np.nan, np.nan)
    total = areas[0] + areas[1] + areas[2]
    return FilmSurvey(smallest, largest, element, areas[1] / total, areas[2] / total)


@_jit
def _states(stress: Array, poisson_ratio: float) -> NDArray[np.int8]:
    states = np.empty(stress.shape[1], dtype=np.int8)
    for e in range(states.size):
        states[e] = film_state(stress[0, e], stress[1, e], stress[2, e], poisson_ratio)
    return states


@_jit
def _survey(stress: Array, poisson_ratio: float, area: Array, areas: Array) -> tuple[float, float, int]:
    """Extreme principal stresses of (3, element) and the element of the smaller; areas of the states are added up."""
    smallest, largest, worst = np.inf, -np.inf, -1
    for e in range(area.size):
        sx, sy, txy = stress[0, e], stress[1, e], stress[2, e]
        mean, radius = 0.5 * (sx + sy), np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
        if mean - radius < smallest:
            smallest, worst = mean - radius, e
        largest = max(largest, mean + radius)
        areas[film_state(sx, sy, txy, poisson_ratio)] += area[e]
    return smallest, largest, worst
