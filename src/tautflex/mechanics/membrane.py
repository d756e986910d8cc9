"""Where a film is taut, wrinkled or slack, and how much of it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tautflex import checks
from tautflex.mechanics.system import HasSystem, StructuralSystem, system_of
from tautflex.mechanics.workspace import Workspace
from tautflex.numeric import Array, jit

MEMBRANE_STATES = ("taut", "wrinkled", "slack")
# Numbers that `survey_stresses` fills in, of which the first few are stored with every sample of a run.
SURVEYED, STORED = 8, 5


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

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> set(tf.membrane_states(state).tolist())              # 0: taut
    {0}
    """
    system = system_of("source", source)
    place = np.zeros(system.size) if q is None else checks.float_array("q", q, (system.size,))
    return survey_at(system, place).membrane_states()


class StressSurvey:
    """Looks at the film and the cables of a structure at the last evaluation of a workspace.

    ``table`` is what `survey_stresses` reads: of every film block where its stresses begin and its rows, of every cable
    block that and whether its law carries compression; Poisson's ratio of every film block; of every film row measure,
    size and element; sections of all cables.
    """

    def __init__(self, system: StructuralSystem, workspace: Workspace) -> None:
        blocks, ends = system.blocks, np.cumsum([0, *(rows.size for rows in workspace.stress_rows)])
        places, cables = system.block_index("membrane"), system.block_index("cable")
        films = [blocks[i] for i in places]
        self._stresses = workspace.stresses
        self._membranes = [(workspace.stress_rows[i], blocks[i]) for i in places]
        before = np.cumsum([0, *(len(block.dofs) for block in films)])
        owners = [
            first + (np.arange(block.size.size) if block.owner is None else block.owner)
            for first, block in zip(before, films, strict=False)
        ]
        self.table = (
            np.array([(ends[i], blocks[i].size.size) for i in places], dtype=np.int64).reshape(-1, 2),
            np.array(
                [(ends[i], blocks[i].size.size, not blocks[i].law.tension_only) for i in cables], dtype=np.int64
            ).reshape(-1, 3),
            np.array([block.material.poisson_ratio for block in films], dtype=np.float64),
            np.concatenate([np.zeros(0), *(block.measure for block in films)]),
            np.concatenate([np.zeros(0), *(block.size for block in films)]),
            np.concatenate([np.zeros(0), *owners]).astype(np.int64),
            np.concatenate([np.zeros(0), *(blocks[i].size for i in cables)]),
        )

    def membrane_states(self) -> NDArray[np.int8]:
        """States of the film elements, of several points the least taut, shape (t,)."""
        found = [np.zeros(0, dtype=np.int8)]
        for stress, block in self._membranes:
            found.append(block.elements_of(_states(stress, block.material.poisson_ratio), np.maximum))
        return np.concatenate(found)

    def stresses(self) -> Array:
        """All numbers of `survey_stresses`, shape (8,)."""
        found = np.empty(SURVEYED)
        survey_stresses(self.table, self._stresses, found)
        return found

    def membrane(self) -> MembraneSurvey:
        """Extreme resultants and area fractions."""
        smallest, largest, wrinkled, slack, _, element = self.stresses().tolist()[:6]
        return MembraneSurvey(smallest, largest, int(element), wrinkled, slack)


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


@jit
def membrane_state(sx: float, sy: float, txy: float, poisson_ratio: float) -> int:
    """Index in `MEMBRANE_STATES` of a plane stress, elastic trial or tension-field alike (mixed criterion)."""
    mean = 0.5 * (sx + sy)
    radius = np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
    # A uniaxial stress is taut in spite of its round-off.
    if mean - radius >= -1e-12 * (mean + radius) and mean + radius > 0.0:
        return 0
    # Major principal strain of the trial stress, times E.
    return 1 if mean + radius - poisson_ratio * (mean - radius) > 0.0 else 2


@jit
def _states(stress: Array, poisson_ratio: float) -> NDArray[np.int8]:
    states = np.empty(stress.shape[1], dtype=np.int8)
    for e in range(states.size):
        states[e] = membrane_state(stress[0, e], stress[1, e], stress[2, e], poisson_ratio)
    return states


@jit
def survey_stresses(table: Any, stresses: Array, found: Array) -> None:
    """Fill in what the stresses of an evaluation tell, shape (8,); ``table`` is that of a `StressSurvey`.

    Smallest and largest principal resultant of the film [N/m], the parts of its area that are wrinkled and slack,
    NaN without a film; the number of cables without tension; the element of the smallest resultant; the largest force
    [N] of an elastic cable that pushes, not above zero, and its number; -1 where there is none.
    """
    films, cables, ratio, measure, size, owner, section = table
    smallest, largest, element = np.inf, -np.inf, -1
    taut, wrinkled, slack, first = 0.0, 0.0, 0.0, 0
    for block in range(films.shape[0]):
        start, count = films[block]
        stress = stresses[start : start + 3 * count].reshape((3, count))
        for e in range(count):
            sx, sy, txy, row = stress[0, e], stress[1, e], stress[2, e], first + e
            mean, radius = 0.5 * (sx + sy), np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
            if (mean - radius) * size[row] < smallest:
                smallest, element = (mean - radius) * size[row], owner[row]
            largest = max(largest, (mean + radius) * size[row])
            state, area = membrane_state(sx, sy, txy, ratio[block]), measure[row] / size[row]
            if state == 0:
                taut += area
            elif state == 1:
                wrinkled += area
            else:
                slack += area
        first += count
    total, first = taut + wrinkled + slack, 0
    if element < 0:
        smallest = largest = total = np.nan
    loose, push, pushing = 0, 0.0, -1
    for block in range(cables.shape[0]):
        start, count, elastic = cables[block]
        for e in range(count):
            if stresses[start + e] < 0.0:
                loose += 1
                force = stresses[start + e] * section[first + e]
                if elastic and force < push:
                    push, pushing = force, first + e
        first += count
    found[0], found[1], found[2], found[3] = smallest, largest, wrinkled / total, slack / total
    found[4], found[5], found[6], found[7] = loose, element, push, pushing
