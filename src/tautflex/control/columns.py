r"""What inputs do to a structure: loads, wrenches and changes of the stiffness, per unit of each number.

An input is a constant pattern of forces, a change of stresses or pressure that follows the film [control.md 1]. Each
has a static answer ``psi = K^-1 f`` whose stresses, with the input's own, change the stiffness of the structure,

    Khat = Phi' d/ds [K_tan(q + s psi; sigma + s columns)] Phi  at s = 0,

less the symmetric derivative of the pressure's force, which turns with the film. ``K_tan`` is quadratic in s where laws
are elastic, so a central difference is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.tension_group import ReeledCables
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.mechanics.loads.prepared import FilmPressure, LinearInput, PatternLoad, PreparedInput, StressChange
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, cross_matrices
from tautflex.text import shown

# Cosines below this are round-off.
_ROUND_OFF = 1e-10
# Stresses of a difference, as part of those that are there: laws that give way are not linear farther off.
_STEP = 1e-3


@dataclass(frozen=True, eq=False)
class InputColumns:
    """One input of a linear view, per unit of its n numbers.

    Parameters
    ----------
    name, labels, units
        Name of the input, names and units of its numbers.
    pattern
        Force on the free unknowns, shape (size, n).
    held
        Force, and torque about the origin, on supported directions or the hub itself, shape (6, n).
    columns
        Number of a block -> change of its stresses, shape (row, strain, n).
    internal
        Whether the spacecraft pulls at itself, so that the whole wrench is zero.
    film
        Pressure of 1 Pa that follows the film; None: there is none.
    stroke
        Length of each cable that a drive reels in, from free unknowns and a number [m]; None where there is no drive.
    """

    name: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    pattern: Array
    held: Array
    columns: dict[int, Array] = field(default_factory=dict)
    internal: bool = False
    film: PressureLoad | None = None
    stroke: Callable[[Array, float], Array] | None = None

    @property
    def count(self) -> int:
        """Number of numbers."""
        return len(self.labels)

    @classmethod
    def of(cls, name: str, given: Any, system: StructuralSystem) -> InputColumns:
        """InputColumns of an effect, one that is bound already, or a wrench on the hub, shape (6, n).

        Raises
        ------
        InputError
            If it is neither a pattern of forces, nor a change of stresses, nor one number of pressure.
        """
        given = given.prepare(system) if isinstance(given, TimeInput) else given
        film = given.unit if isinstance(given, FilmPressure) else None
        if isinstance(given, PatternLoad):
            parts: tuple[Array, Array, dict[int, Array], bool] = given.pattern, given.held, {}, given.internal
        elif isinstance(given, StressChange | FilmPressure):
            stresses = given.columns if isinstance(given, StressChange) else {}
            parts = np.zeros((system.size, given.count)), np.zeros((6, given.count)), stresses, False
        elif isinstance(given, PreparedInput):
            raise InputError(
                f"inputs.{name}: expected a constant pattern of forces, a change of stresses or one number of "
                f"pressure, got {type(given).__name__}, which has no linear column; leave it out of the linear view, "
                "or push with a NodalForce or an EdgeForce"
            )
        else:
            held = checks.float_array(f"inputs.{name}", given, (6, None))
            parts = np.zeros((system.size, held.shape[1])), held, {}, False
        count = parts[1].shape[1]
        units = ("N m",) * count
        if isinstance(given, LinearInput):
            units = tuple(label.partition("[")[2].rstrip("]") for label in given.labels)
        labels = (name,) if count == 1 else tuple(f"{name}[{k}]" for k in range(count))
        stroke = given.stroke if isinstance(given, ReeledCables) else None
        return cls(name, labels, units, *parts, film, stroke)

    def wrench(self, rows: Array, q: Array) -> Array:
        """Force and torque on the whole spacecraft at q, shape (6, n); ``rows`` are `rigid_rows` there."""
        if self.film is not None:
            return self.film.wrench(q)[:, None]
        return np.zeros((6, self.count)) if self.internal else self.held + rows @ self.pattern


def columns_of(inputs: Mapping[str, Any], system: StructuralSystem) -> list[InputColumns]:
    """Effects of named inputs in order."""
    if not isinstance(inputs, Mapping):
        raise InputError(f"inputs: expected a mapping from names to inputs, got {shown(inputs)}; name them")
    return [InputColumns.of(name, given, system) for name, given in inputs.items()]


def by_name(key: str, values: Mapping[str, ArrayLike] | None, effects: Sequence[InputColumns]) -> dict[str, Array]:
    """Numbers given for inputs by their names, shapes (n,); InputError for other names, or not as many numbers."""
    counts = {effect.name: effect.count for effect in effects}
    if not isinstance(values, Mapping | None):
        raise InputError(f"{key}: expected a mapping from names of inputs to numbers, got {shown(values)}; name them")
    for name in values or {}:
        checks.one_of(key, name, list(counts))
    return {name: checks.spread(f"{key}.{name}", value, counts[name]) for name, value in (values or {}).items()}


def rigid_rows(system: StructuralSystem, q: Array) -> Array:
    """Force and torque about the origin of nodal forces at free unknowns q: rows of a map, shape (6, size)."""
    model, place = system.model, system.place
    rows = np.zeros((6, system.size + 1))
    arms = model.nodes + system.translations(q)
    for axis in range(3):
        slots = place[model.translation_dofs[:, axis]]
        rows[axis, slots] = 1.0
        rows[3:, slots] = cross_matrices(arms)[:, :, axis].T
    turning = np.flatnonzero(np.diff(model.dof_offset) == 6)
    for axis in range(3):
        rows[3 + axis, place[model.dof_offset[turning] + 3 + axis]] = 1.0
    return rows[:, :-1]


def loads_of(effect: InputColumns, system: StructuralSystem, q: Array) -> Array:
    """Forces on the free unknowns at q, those that stresses make included, shape (size, n)."""
    if effect.film is not None:
        return effect.film.force(q)[:, None]
    if not effect.columns:
        return effect.pattern
    made = [
        (system.with_initial_stress(minus).force(q)[0] - system.with_initial_stress(plus).force(q)[0]) / (2.0 * step)
        for plus, minus, step in _both_ways(effect, system)
    ]
    return np.array(made).T


def stiffness_changes(
    effect: InputColumns,
    system: StructuralSystem,
    q: Array,
    answers: Array,
    vectors: Array,
    films: Sequence[PressureLoad] = (),
) -> Array:
    """Khat on vectors (r, size) of an effect with static answers (size, n) at q, under held pressures, (n, r, r)."""
    result = np.zeros((effect.count, len(vectors), len(vectors)))
    for k, (plus, minus, step) in enumerate(_both_ways(effect, system, answers)):
        ahead, behind = q + step * answers[:, k], q - step * answers[:, k]
        change = system.with_initial_stress(plus).tangent(ahead) - system.with_initial_stress(minus).tangent(behind)
        for film in films:
            change -= film.stiffness(ahead) - film.stiffness(behind)
        change /= 2.0 * step
        if effect.film is not None:
            change -= effect.film.stiffness(q)
        result[k] = vectors @ (system.pattern.symmetric_matrix(change) @ vectors.T)
    return result


def _both_ways(
    effect: InputColumns, system: StructuralSystem, answers: Array | None = None
) -> Iterator[tuple[list[Array], list[Array], float]]:
    """Initial stresses with a step of each number of an effect and without, and the step."""
    now = list(system.initial_stress)
    for k in range(effect.count):
        own = {index: columns[:, :, k] for index, columns in effect.columns.items()}
        made = [np.abs(own[i]).max(initial=0.0) if i in own else 0.0 for i in range(len(now))]
        if answers is not None:
            strains = system.linear_strain(answers[:, k])
            for i, (block, strain) in enumerate(zip(system.blocks, strains, strict=True)):
                stress = np.einsum("rst,rt->rs", block.elasticity, strain)
                made[i] = max(made[i], float(np.abs(stress).max(initial=0.0)))
        ratios = [float(np.abs(s).max(initial=0.0)) / m for s, m in zip(now, made, strict=True) if m > 0.0]
        step = _STEP * max(ratios, default=0.0) or 1.0
        plus = [stress + step * own[i] if i in own else stress for i, stress in enumerate(now)]
        minus = [stress - step * own[i] if i in own else stress for i, stress in enumerate(now)]
        yield plus, minus, step


def without_round_off(vectors: Array, loads: Array) -> Array:
    """``vectors @ loads`` for vectors (r, size) and loads (size, n), zero where that is round-off."""
    whole = vectors @ loads
    sizes = np.outer(np.linalg.norm(vectors, axis=1), np.linalg.norm(loads, axis=0))
    return np.where(np.abs(whole) > _ROUND_OFF * sizes, whole, 0.0)
