"""Where a film is taut, wrinkled or slack, and how much of it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from tautflex.elements.laws import film_state
from tautflex.mechanics.system import StructuralSystem
from tautflex.mechanics.workspace import Workspace

Array = NDArray[np.float64]

_jit = numba.njit(cache=True, error_model="numpy")


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
    return survey_at(system, np.zeros(system.size) if q is None else q).film_states()


class StressSurvey:
    """Looks at the film and the cables of a structure at the last evaluation of a workspace.

    Parameters
    ----------
    system
        The structure.
    workspace
        Whose stresses are looked at.

    Attributes
    ----------
    cables
        Stresses [Pa] as a view, section [m^2], and whether the law is elastic, of every cable block.
    """

    def __init__(self, system: StructuralSystem, workspace: Workspace) -> None:
        groups, rows = system.model.groups, workspace.stress_rows
        self._films = [
            (rows[i], system.blocks[i].law_parameters[1], system.blocks[i].measure / thickness, thickness)
            for i in system.block_index("membrane")
            for thickness in (groups[i].section.thickness,)  # type: ignore[union-attr]
        ]
        self.cables = [
            (rows[i][0], groups[i].section.area, system.blocks[i].law == "elastic")  # type: ignore[union-attr]
            for i in system.block_index("cable")
        ]

    def film_states(self) -> NDArray[np.int8]:
        """States of the film elements, shape (t,)."""
        found = [_states(stress, poisson_ratio) for stress, poisson_ratio, *_ in self._films]
        return np.concatenate([np.zeros(0, dtype=np.int8), *found])

    def film(self) -> FilmSurvey:
        """Extreme resultants and area fractions."""
        smallest, largest, element = np.inf, -np.inf, -1
        areas, first = np.zeros(3), 0
        for stress, poisson_ratio, area, thickness in self._films:
            low, high, worst = _survey(stress, poisson_ratio, area, areas)
            if low * thickness < smallest:
                smallest, element = low * thickness, first + worst
            largest = max(largest, high * thickness)
            first += len(area)
        if element < 0:
            return FilmSurvey(np.nan, np.nan, -1, np.nan, np.nan)
        total = areas[0] + areas[1] + areas[2]
        return FilmSurvey(smallest, largest, element, areas[1] / total, areas[2] / total)

    def slack_cables(self) -> int:
        """Number of cables without tension."""
        return sum(int(np.count_nonzero(stress < 0.0)) for stress, *_ in self.cables)


def survey_at(system: StructuralSystem, q: Array) -> StressSurvey:
    """Survey of the stresses at free unknowns [m, rad], shape (size,)."""
    workspace = system.workspace()
    workspace.strain_energy(q)
    return StressSurvey(system, workspace)


def principal_resultants(system: StructuralSystem, stress: Iterable[Array]) -> Array:
    """Smaller and larger principal resultant [N/m] of each film element, from all blocks' stresses, shape (t, 2)."""
    found = [
        principal_values(values) * group.section.thickness  # type: ignore[union-attr]
        for group, values in zip(system.model.groups, stress, strict=True)
        if group.section.kind == "membrane"
    ]
    return np.concatenate(found) if found else np.zeros((0, 2))


def principal_values(stress: Array) -> Array:
    """Smaller and larger principal value of plane stresses (sx, sy, txy), shape (element, 3) -> (element, 2)."""
    mean = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    return np.stack([mean - radius, mean + radius], axis=1)


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
