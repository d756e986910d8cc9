"""Where a film is taut, wrinkled or slack, and how much of it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex import checks
from tautflex.mechanics.system import HasSystem, StructuralSystem, system_of
from tautflex.mechanics.workspace import Workspace
from tautflex.numeric import Array, jit_in_order

MEMBRANE_STATES = ("taut", "wrinkled", "slack")


class MembraneSurvey(NamedTuple):
    """State of all film elements at one instant; NaN, and -1 for ``element``, without a film.

    ``smallest`` and ``largest`` are the extreme principal resultants [N/m], ``element`` has the smallest one,
    ``wrinkled`` and ``slack`` are the parts of the film's area in these states [-].
    """

    smallest: float
    largest: float
    element: int
    wrinkled: float
    slack: float


def membrane_states(source: StructuralSystem | HasSystem, q: Array | None = None) -> NDArray[np.int8]:
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
    system = system_of("source", source)
    place = np.zeros(system.size) if q is None else checks.float_array("q", q, (system.size,))
    return survey_at(system, place).membrane_states()


class StressSurvey:
    """Looks at the film and the cables of a structure at the last evaluation of a workspace.

    ``cables`` holds stresses [Pa] as a view, sections [m^2], and whether the law carries compression, of every cable
    block.
    """

    def __init__(self, system: StructuralSystem, workspace: Workspace) -> None:
        rows, blocks = workspace.stress_rows, system.blocks
        self._membranes = [(rows[i], blocks[i]) for i in system.block_index("membrane")]
        self.cables = [
            (rows[i][0], blocks[i].size, not blocks[i].law.tension_only) for i in system.block_index("cable")
        ]

    def membrane_states(self) -> NDArray[np.int8]:
        """States of the film elements, of several points the least taut, shape (t,)."""
        found = [np.zeros(0, dtype=np.int8)]
        for stress, block in self._membranes:
            found.append(block.elements_of(_states(stress, block.material.poisson_ratio), np.maximum))
        return np.concatenate(found)

    def membrane(self) -> MembraneSurvey:
        """Extreme resultants and area fractions."""
        smallest, largest, element = np.inf, -np.inf, -1
        areas, first = np.zeros(3), 0
        for stress, block in self._membranes:
            low, high, worst = _survey(stress, block.material.poisson_ratio, block.measure, block.size, areas)
            if low < smallest:
                smallest, element = low, first + (worst if block.owner is None else int(block.owner[worst]))
            largest = max(largest, high)
            first += len(block.dofs)
        if element < 0:
            return MembraneSurvey(np.nan, np.nan, -1, np.nan, np.nan)
        total = areas[0] + areas[1] + areas[2]
        return MembraneSurvey(smallest, largest, element, areas[1] / total, areas[2] / total)

    def slack_cables(self) -> int:
        """Number of cables without tension."""
        return sum(int(np.count_nonzero(stress < 0.0)) for stress, *_ in self.cables)


def survey_at(system: StructuralSystem, q: Array) -> StressSurvey:
    """Survey of the stresses at free unknowns [m, rad], shape (size,)."""
    workspace = system.workspace()
    workspace.strain_energy(q)
    return StressSurvey(system, workspace)


def principal_resultants(system: StructuralSystem, stress: Iterable[Array]) -> Array:
    """Smallest and largest principal resultant [N/m] of each film element, from all blocks' stresses, shape (t, 2)."""
    found = [np.zeros((0, 2))]
    for block, values in zip(system.blocks, stress, strict=True):
        if block.kind == "membrane":
            low, high = (principal_values(values) * block.size[:, None]).T
            extremes = block.elements_of(low, np.minimum), block.elements_of(high, np.maximum)
            found.append(np.stack(extremes, axis=1))
    return np.concatenate(found)


def principal_values(stress: Array) -> Array:
    """Smaller and larger principal value of plane stresses (sx, sy, txy), shape (element, 3) -> (element, 2)."""
    mean = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    return np.stack([mean - radius, mean + radius], axis=1)


@jit_in_order
def membrane_state(sx: float, sy: float, txy: float, poisson_ratio: float) -> int:
    """Index in `MEMBRANE_STATES` of a plane stress, elastic trial or tension-field alike (mixed criterion)."""
    mean = 0.5 * (sx + sy)
    radius = np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
    # A uniaxial stress is taut in spite of its round-off.
    if mean - radius >= -1e-12 * (mean + radius) and mean + radius > 0.0:
        return 0
    # Major principal strain of the trial stress, times E.
    return 1 if mean + radius - poisson_ratio * (mean - radius) > 0.0 else 2


@jit_in_order
def _states(stress: Array, poisson_ratio: float) -> NDArray[np.int8]:
    states = np.empty(stress.shape[1], dtype=np.int8)
    for e in range(states.size):
        states[e] = membrane_state(stress[0, e], stress[1, e], stress[2, e], poisson_ratio)
    return states


@jit_in_order
def _survey(stress: Array, poisson_ratio: float, measure: Array, size: Array, areas: Array) -> tuple[float, float, int]:
    """Extreme principal resultants of (3, row) and the row of the smaller; areas of the states are added up."""
    smallest, largest, worst = np.inf, -np.inf, -1
    for e in range(size.size):
        sx, sy, txy = stress[0, e], stress[1, e], stress[2, e]
        mean, radius = 0.5 * (sx + sy), np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
        if (mean - radius) * size[e] < smallest:
            smallest, worst = (mean - radius) * size[e], e
        largest = max(largest, (mean + radius) * size[e])
        areas[membrane_state(sx, sy, txy, poisson_ratio)] += measure[e] / size[e]
    return smallest, largest, worst
