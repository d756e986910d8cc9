r"""Inputs in time on a reduced model: all that does not change in a run, worked out once.

An input acts by a constant pattern of forces, or by columns of stress s_k. Stresses work on the strains, so with the
structure's answer ``psi_k = -K^-1 b_k``, ``b_k = G' V L' s_k``, less its part in the coordinates, the forces are

    f(eta, u) = f(eta) + sum_k u_k (beta_k + Khat_k eta),   beta_k = Phi' b_k,
    Khat_k = Phi' d/ds [K_tan(q = s psi_k; sigma0 + s s_k)] Phi  at s = 0.

The answer is that of the very stress, so the mixed terms with what follows the coordinates cancel, and a flat
von Karman structure loses nothing. ``eta Khat eta / 2`` is a sum over monomials: steps take it as a given stress of
these. A hyper-reduced model has the columns in its weighed elements, and psi_k as further unknowns that are given.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from tautflex import checks
from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import InputSet, PreparedInput, earlier
from tautflex.mechanics.loads.prepared import PatternLoad, StressChange, value_at
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.numeric import Array
from tautflex.reduction.bases.answers import apart, static_answers
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import strain_energies
from tautflex.reduction.polynomial.monomials import packed
from tautflex.reduction.polynomial.strains import stress_energies, stress_loads

# Pressures of the same distribution but for round-off.
_ALIKE = 1e-14


def _values(item: PatternLoad | StressChange, time: float) -> Array:
    value = value_at(item.name, item.function, time)
    if isinstance(item, PatternLoad):
        return checks.vector3(item.name, value)
    return np.broadcast_to(np.atleast_1d(value), (item.count,))


def require_linear(inputs: InputSet) -> None:
    """Raise UnsupportedError for an input that is not linear in a few numbers."""
    for name, item in inputs.named:
        if not isinstance(item, StressChange) and type(item).stress is not PreparedInput.stress:
            raise UnsupportedError(
                f"inputs: expected columns of stress on a reduced model, got {name}, which gives stress(time) alone; "
                "let prepare return a StressChange, whose columns say what each number does, or simulate the full state"
            )
        if (follower := item.follower(0.0)) is not None and not isinstance(follower, PressureLoad):
            raise UnsupportedError(
                f"inputs: expected forces that do not follow the motion on a reduced model, got {name}; simulate the "
                "full state"
            )


def stress_columns(inputs: InputSet) -> dict[int, Array]:
    """Columns of all inputs that change stresses, side by side, by block number, shapes (row, strain, n)."""
    changes = [item for _, item in inputs.named if isinstance(item, StressChange)]
    total = sum(item.count for item in changes)
    columns: dict[int, Array] = {}
    first = 0
    for item in changes:
        for number, own in item.columns.items():
            place = columns.setdefault(number, np.zeros((*own.shape[:2], total)))
            place[:, :, first : first + item.count] = own
        first += item.count
    return columns


def input_loads(inputs: InputSet) -> Array:
    """Forces of unit inputs on the free unknowns, those of patterns and those of stresses, shape (n, size)."""
    require_linear(inputs)
    loads = [item.pattern.T for _, item in inputs.named if isinstance(item, PatternLoad)]
    if columns := stress_columns(inputs):
        loads.append(-stress_loads(inputs.system, columns))
    return np.concatenate([np.zeros((0, inputs.system.size)), *loads])


class ReducedInputs:
    """Inputs of a run on a reduced model with r coordinates and m monomials.

    Parameters
    ----------
    rom
        The reduced model.
    inputs
        Inputs bound to its structure.

    Attributes
    ----------
    given
        The inputs.
    load, held
        Forces of n patterns on the coordinates, shape (r, n), and what supports take up of them, shape (6, n).
    columns
        Of n_s stresses by block number, shapes (row, strain, n_s).
    answers
        psi, shape (n_s, size).
    beta
        Force of unit stresses on the coordinates at rest, shape (n_s, r).

    Raises
    ------
    UnsupportedError
        If an input is not linear in a few numbers.
    """

    def __init__(self, rom: OnBasis, inputs: InputSet) -> None:
        require_linear(inputs)
        self._rom, self.given, basis = rom, inputs, rom.basis
        items = [item for _, item in inputs.named]
        self._patterns = [item for item in items if isinstance(item, PatternLoad)]
        self._changes = [(name, item) for name, item in inputs.named if isinstance(item, StressChange)]
        self._others = [
            item for item in items if not isinstance(item, PatternLoad) and type(item).load is not PreparedInput.load
        ]
        self._followers = [item for item in items if type(item).follower is not PreparedInput.follower]
        pattern = _joined([item.pattern for item in self._patterns], rom.state.system.size)
        self.load, self._on_monomials = self._projected(pattern)
        self.held = _joined([item.held for item in self._patterns], 6)
        self.columns = stress_columns(inputs)
        pulls = stress_loads(rom.state.system, self.columns) if self.columns else np.zeros((0, len(pattern)))
        self.beta = pulls @ basis.kept.T
        self.answers = static_answers(rom.reference, basis, -pulls) if len(pulls) else pulls
        self._own = pulls @ self.answers.T
        self._pressures: list[tuple[Array, Array, Array]] = []

    @property
    def breaks(self) -> tuple[float, ...]:
        """Instants at which an input jumps [s]."""
        return self.given.breaks

    def __bool__(self) -> bool:
        return bool(self.given)

    @cached_property
    def stress(self) -> Array:
        """``eta Khat eta / 2`` per monomial, shape (n_s, m)."""
        rom = self._rom
        if not self.columns or rom.in_elements:
            return np.zeros((len(self.beta), rom.monomial_count))
        return stress_energies(rom.state.system, rom.basis.kept, self.columns) + self.answers @ rom.second_degree.T

    @cached_property
    def stiffness(self) -> Array:
        """Khat, shape (n_s, r, r)."""
        first, second = np.triu_indices(self._rom.size)
        result = np.zeros((len(self.beta), self._rom.size, self._rom.size))
        result[:, first, second] += self.stress
        result[:, second, first] += self.stress
        return result

    def arrays(self, damping: Damping) -> Any:
        """Arrays of the model for the compiled stepper, with room for the stresses."""
        arrays = self._rom.arrays(damping)
        return self._rom.restressed(arrays, self.columns, self.answers) if self.columns else arrays

    def stresses(self, times: Array, before: float = np.inf) -> Array:
        """Numbers of the stresses at instants [s], shape (time, n_s); a jump at ``before`` is not met yet."""
        return self._numbers([item for _, item in self._changes], times, before)

    def forces(self, times: Array, before: float = np.inf) -> tuple[Array, Array]:
        """Load on the coordinates, shape (time, r), and what is given to the internal force, on the left-hand side.

        That is a stress per monomial, shape (time, m), or, where stresses act in elements, their numbers (time, n_s).
        """
        pushed, pulled = self._numbers(self._patterns, times, before), self.stresses(times, before)
        load, given = -pushed @ self.load.T, -pushed @ self._on_monomials.T
        for place, time in enumerate(times):
            instant = earlier(float(time), before)
            for item in self._others:
                force = item.load(instant)
                if force is not None:
                    own, beside = self._projected(force)
                    load[place] -= own
                    given[place] -= beside
            for item in self._followers:
                size, own, beside = self._pressure(item.follower(instant))
                load[place] -= size * own
                given[place] -= size * beside
        if self._rom.in_elements:
            return load, pulled
        return load + pulled @ self.beta, given + pulled @ self.stress

    def answer(self, times: Array, look: csr_array | None = None) -> Array:
        """What the structure answers at once to stresses at instants [s], shape (time, size), or readings of it."""
        return self.stresses(times) @ (self.answers if look is None else (look @ self.answers.T).T)

    def stored(self, arrays: Any, q: Array, times: Array, before: float = np.inf) -> Array:
        """What stresses add to the strain energy of coordinates (time, r) at instants [J], shape (time,)."""
        u = self.stresses(times, before)
        given = u if self._rom.in_elements else u @ self.stress
        added = strain_energies(arrays, q, given) - strain_energies(arrays, q)
        if self._rom.in_elements:
            return np.asarray(added)
        return np.asarray(added + np.einsum("tk,tk->t", u, q @ self.beta.T + 0.5 * u @ self._own))

    def doubts(self) -> list[str]:
        """Sentences on inputs whose answer is taken as instantaneous although it is not."""
        rom, first, said = self._rom, 0, []
        for name, item in self._changes:
            own, first = self.answers[first : first + item.count], first + item.count
            slowest, limit = apart(rom.state, rom.reference, own)[1].min(initial=np.inf), rom.fast_limit
            if slowest < limit:
                said.append(
                    f"inputs: the structure answers {name} at {slowest / (2.0 * np.pi):.3g} Hz, which the reduced model "
                    f"takes as at once, as from {limit / (2.0 * np.pi):.3g} Hz on; give the inputs to reduce(..., "
                    "inputs=[...]), which makes slow answers coordinates"
                )
        return said

    def _numbers(self, items: Sequence[PatternLoad | StressChange], times: Array, before: float) -> Array:
        rows = [[_values(item, earlier(float(time), before)) for item in items] for time in times]
        return np.array([np.concatenate([np.zeros(0), *row]) for row in rows]).reshape(len(times), -1)

    def _projected(self, forces: Array) -> tuple[Array, Array]:
        """Forces (size, ...) on the coordinates, shape (r, ...), and on what follows them, per monomial, (m, ...)."""
        rom = self._rom
        if len(rom.basis.derivatives):
            return rom.basis.kept @ forces, rom.monomial_vectors @ forces
        return rom.basis.kept @ forces, np.zeros((rom.monomial_count, *forces.shape[1:]))

    def _pressure(self, film: Any) -> tuple[float, Array, Array]:
        """Size of a pressure, and force on the coordinates and stress per monomial of its distribution.

        Constant and linear parts at rest; what turns and stretches of the film add beyond them is not taken.
        """
        pressure = np.zeros(1) if film is None else film.pressure
        size = float(pressure[np.argmax(np.abs(pressure))])
        if size == 0.0:
            return 0.0, np.zeros(self._rom.size), np.zeros(self._rom.monomial_count)
        for known, own, beside in self._pressures:
            if np.abs(pressure - size * known).max() <= _ALIKE * abs(size):
                return size, own, beside
        rom, unit = self._rom, film.scaled(pressure / size)
        own, beside = self._projected(unit.force(np.zeros(rom.state.system.size)))
        if rom.monomial_count:
            tangent = rom.state.system.matrix(unit.tangent(np.zeros(rom.state.system.size)))
            beside = beside + 0.5 * packed(rom.basis.kept @ (tangent @ rom.basis.kept.T))
        self._pressures.append((unit.pressure, own, beside))
        return size, own, beside


def _joined(columns: Sequence[Array], rows: int) -> Array:
    return np.concatenate([np.zeros((rows, 0)), *columns], axis=1)
