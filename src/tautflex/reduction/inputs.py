r"""Inputs in time on a reduced model: all that does not change in a run, worked out once.

An input acts by a constant pattern of forces, or by columns of stress s_k. Stresses work on the strains, so with the
structure's answer ``psi_k = -K^-1 b_k``, ``b_k = G' V L' s_k``, less its part in the coordinates, the forces are

    f(eta, u) = f(eta) + sum_k u_k (beta_k + Khat_k eta),   beta_k = Phi' b_k,
    Khat_k = Phi' d/ds [K_tan(q = s psi_k; sigma0 + s s_k)] Phi  at s = 0.

The answer is that of the very stress, so the mixed terms with what follows the coordinates cancel, and a flat von
Karman film loses nothing; what the answer stretches by its own slopes is of second order in u and left out.
``eta Khat eta / 2`` is a sum over monomials: steps take it as a given stress of these. A hyper-reduced model has the
columns in its weighed elements, and psi_k as further unknowns that are given.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import InputSet, earlier, require_still
from tautflex.mechanics.loads.prepared import FollowerForce, LinearInput, PreparedInput, StressChange
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.numeric import Array
from tautflex.reduction.bases.answers import apart, static_answers
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.forces import strain_energies
from tautflex.reduction.polynomial.monomials import packed
from tautflex.reduction.polynomial.strains import stress_energies, stress_loads

# Pressures of the same distribution but for round-off.
_ALIKE = 1e-14
# Part of the stiffness that an answer may be late by, and instants at which inputs are looked at to know.
_NOTABLE, _LOOKS = 0.02, 500
# Part of the stiffness by an input that few elements may have wrong.
_MISSED = 0.05


def require_linear(inputs: InputSet) -> None:
    """Raise UnsupportedError for an input that is not linear in a few numbers."""
    require_still("on a reduced model", inputs.given)
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


def input_loads(inputs: InputSet) -> tuple[Array, Array]:
    """Forces of unit linear inputs on the free unknowns: patterns (n, size), and stresses at rest (n_s, size)."""
    require_linear(inputs)
    stressing = inputs.stressing
    pulls = -stress_loads(inputs.system, inputs.columns) if inputs.columns else np.zeros((0, inputs.system.size))
    return inputs.force_at_rest.T[~stressing], pulls[stressing[: len(pulls)]]


class Pressed(NamedTuple):
    """Pressure of some distribution, its force on the coordinates at rest, (r,), and on what follows them, (m,)."""

    unit: PressureLoad
    load: Array
    beside: Array


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
    load
        Forces of n linear inputs on the coordinates, shape (r, n), zero for the n_s of them that are stresses.
    columns
        Of these, by block number, shapes (row, strain, n_s).
    answers
        psi, shape (n_s, size).
    beta
        Force of unit stresses on the coordinates at rest, shape (n_s, r).
    own
        ``u own u / 2`` is what stresses store at once in the structure that answers them, shape (n_s, n_s).
    slopes
        What pressure that follows the film adds to the forces per monomial, shape (m, n); 0 of other inputs.

    Raises
    ------
    UnsupportedError
        If an input is not linear in a few numbers.
    """

    def __init__(self, rom: OnBasis, inputs: InputSet) -> None:
        require_linear(inputs)
        self._rom, self.given, basis = rom, inputs, rom.basis
        self._stressing, system = np.flatnonzero(inputs.stressing), rom.state.system
        items = [item for _, item in inputs.named]
        self._others = [
            item for item in items if not isinstance(item, LinearInput) and type(item).load is not PreparedInput.load
        ]
        self._followers = [item for item in items if type(item).follower is not PreparedInput.follower]
        self._uneven = [item for item in self._followers if not isinstance(item, LinearInput)]
        self._pressures: list[Pressed] = []
        self.load, self._on_monomials = self._projected(inputs.force_at_rest)
        self.slopes = np.zeros_like(self._on_monomials)
        for place, unit in inputs.films.items():
            self.slopes[:, place] = self._slopes(unit)
        self._on_monomials += self.slopes
        self.columns = {number: column[..., self._stressing] for number, column in inputs.columns.items()}
        pulls = stress_loads(system, self.columns) if self.columns else np.zeros((0, system.size))
        self.beta = pulls @ basis.kept.T
        self.answers = static_answers(rom.reference, basis, -pulls) if len(pulls) else pulls
        self.own = pulls @ self.answers.T

    @property
    def followers(self) -> bool:
        """Whether an input has forces that follow the motion."""
        return bool(self._followers)

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

    def values(self, times: Array, before: float = np.inf) -> Array:
        """Numbers of the linear inputs at instants [s], shape (time, n); a jump at ``before`` is not met yet."""
        return np.array([self.given.values(earlier(float(time), before)) for time in times])

    def stresses(self, times: Array, before: float = np.inf) -> Array:
        """Those of them that are stresses, shape (time, n_s)."""
        return np.take(self.values(times, before), self._stressing, axis=1)

    def driven(self, numbers: Array) -> tuple[Array, Array]:
        """Load on the coordinates, shape (time, r), and what is given to the internal force, of numbers (time, n).

        Both on the left-hand side. Given is a stress per monomial, shape (time, m), or, where stresses act in elements,
        their numbers (time, n_s).
        """
        load, pulled = -by_rows(numbers, self.load.T), np.take(numbers, self._stressing, axis=1)
        if self._rom.in_elements:
            return load, pulled
        given = by_rows(pulled, self.stress) - by_rows(numbers, self._on_monomials.T)
        return load + by_rows(pulled, self.beta), given

    def forces(self, times: Array, before: float = np.inf) -> tuple[Array, Array]:
        """The same of all inputs at instants [s]; a jump at ``before`` is not met yet."""
        load, given = self.driven(self.values(times, before))
        for place, time in enumerate(times) if self._others or self._uneven else ():
            for own, beside in self._unsplit(earlier(float(time), before)):
                load[place] -= own
                if not self._rom.in_elements:
                    given[place] -= beside
        return load, given

    def _unsplit(self, time: float) -> Iterator[tuple[Array, Array]]:
        """Forces at an instant that are not known to be linear in few numbers, as `_projected` has them."""
        for item in self._others:
            if (force := item.load(time)) is not None:
                yield self._projected(force)
        for item in self._uneven:
            if (film := item.follower(time)) is not None:
                size, unit = self.pressed(film)
                yield size * unit.load, size * unit.beside

    def answer(self, times: Array) -> Array:
        """What the structure answers at once to stresses at instants [s], shape (time, size)."""
        return self.stresses(times) @ self.answers

    def stored(self, arrays: Any, q: Array, times: Array, before: float = np.inf) -> Array:
        """What stresses add to the strain energy of coordinates (time, r) at instants [J], shape (time,)."""
        u = self.stresses(times, before)
        given = u if self._rom.in_elements else u @ self.stress
        added = strain_energies(arrays, q, given) - strain_energies(arrays, q)
        if self._rom.in_elements:
            return np.asarray(added)
        return np.asarray(added + np.einsum("tk,tk->t", u, q @ self.beta.T + 0.5 * u @ self.own))

    def doubts(self, end: float, beta: float) -> list[str]:
        """Sentences on inputs of a run to ``end`` [s] whose answer is taken as instantaneous although it is not.

        Stress changes stiffness at once, its answer by K2 only after a time, that of its own motion, 1 / frequency,
        and of stiffness damping, beta [s]. ``change of u K2 / K (time) (frequency of the coordinates)`` is then wrong.
        """
        if not self.columns or not self.answers.any():
            return []
        rom, basis, first, said = self._rom, self._rom.basis, 0, []
        pace = rom.fast_limit / 4.0
        moving = basis.amplitude > 0.05 * basis.amplitude.max()
        root = np.sqrt(rom.reference.energies(basis.kept[moving]))
        step = 0.5 / pace
        numbers = self.stresses(np.append(np.arange(0.0, end, max(step, end / _LOOKS)), end))
        missed = rom.missed(self.columns)
        for name, item in self.given.named:
            if not isinstance(item, StressChange):
                continue
            own = slice(first, first + item.count)
            first += item.count
            if (part := float(missed[own].max(initial=0.0))) > _MISSED:
                said.append(
                    f"inputs: the chosen elements miss {part:.0%} of what {name} does to the stiffness; give it to "
                    "hyper_reduce(..., inputs=[...]), and a smaller tolerance if that has it already"
                )
            change = np.abs(numbers[1:, own] - numbers[:-1, own]).max(initial=0.0)
            motion = (numbers[:, own] - numbers[:1, own]) @ self.answers[own]
            largest = motion[np.argmax(np.abs(motion).max(axis=1))]
            if change == 0.0 or not largest.any():
                continue
            slowest = float(apart(rom.state, rom.reference, largest[None])[1].min())
            delay = 1.0 / slowest + beta
            share = change / np.abs(numbers[:, own] - numbers[:1, own]).max()
            table = np.zeros((basis.kept.shape[0],) * 2)
            table[np.triu_indices(len(table))] = share * (rom.second_degree @ largest)
            matrix = (table + table.T)[np.ix_(moving, moving)] / np.outer(root, root)
            wrong = float(np.abs(np.linalg.eigvalsh(matrix)).max()) * pace * delay
            if slowest < rom.fast_limit or wrong > _NOTABLE:
                said.append(
                    f"inputs: the structure answers {name} in {delay:.2g} s, which the reduced model takes as at once: "
                    f"{wrong:.0%} of the stiffness for that long; give the inputs to reduce(..., inputs=[...]), which "
                    "makes the answers coordinates"
                )
        return said

    def left_out(self, time: float, eta: Array, q: Array) -> float:
        """Part of the force of pressure on the coordinates that the model lacks, at a state of the full structure."""
        first, second = np.triu_indices(self._rom.size)
        worst = 0.0
        for item in self._followers:
            film: Any = item.follower(time)
            if film is None or not film.pressure.any():
                continue
            (size, unit), (whole, through) = self.pressed(film), self._projected(film.force(q))
            missing, through = whole - size * unit.load, through - size * unit.beside
            if through.size:
                np.add.at(missing, first, through * eta[second])
                np.add.at(missing, second, through * eta[first])
            worst = max(worst, float(np.linalg.norm(missing) / np.linalg.norm(size * unit.load)))
        return worst

    def _projected(self, forces: Array) -> tuple[Array, Array]:
        """Forces (size, ...) on the coordinates, shape (r, ...), and on what follows them, per monomial, (m, ...)."""
        rom = self._rom
        if len(rom.basis.derivatives):
            return rom.basis.kept @ forces, rom.monomial_vectors @ forces
        return rom.basis.kept @ forces, np.zeros((rom.monomial_count, *forces.shape[1:]))

    def pressed(self, film: FollowerForce) -> tuple[float, Pressed]:
        """Size of a pressure [Pa], and what a unit of its distribution does, which is worked out once.

        That is what is constant and linear about rest. What the film's turning and stretching add beyond it is of
        second order in its slopes, see `left_out`.
        """
        assert isinstance(film, PressureLoad)  # nothing else gets past `require_linear`
        size = float(film.pressure[np.argmax(np.abs(film.pressure))])
        for known in self._pressures:
            if np.abs(film.pressure - size * known.unit.pressure).max() <= _ALIKE * abs(size):
                return size, known
        unit = film.scaled(film.pressure / (size or 1.0))
        load, beside = self._projected(unit.force(np.zeros(self._rom.state.system.size)))
        self._pressures.append(Pressed(unit, load, beside + self._slopes(unit)))
        return size, self._pressures[-1]

    def _slopes(self, unit: PressureLoad) -> Array:
        """What the turning of the film adds to the force of a pressure per monomial, shape (m,)."""
        rom = self._rom
        if not rom.monomial_count:
            return np.zeros(0)
        tangent = rom.state.system.matrix(unit.tangent(np.zeros(rom.state.system.size)))
        return np.asarray(0.5 * packed(rom.basis.kept @ (tangent @ rom.basis.kept.T)))


def by_rows(rows: Array, matrix: Array) -> Array:
    """``rows @ matrix``, every row by itself: its last bits do not depend on how many there are."""
    result = np.zeros((len(rows), matrix.shape[1]))
    for k in range(len(matrix)):
        result += rows[:, k, None] * matrix[k]
    return result
