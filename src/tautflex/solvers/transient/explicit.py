"""Explicit central differences: one mass solve per step, stable up to 2 / (largest angular frequency)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from tautflex.errors import InputError
from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.low_rank import LowRankUpdate
from tautflex.solvers.nonlinear.newton import NewtonOutcome
from tautflex.solvers.remembering import Memory, Remembering
from tautflex.solvers.transient.accuracy.books import DAMPING, FRAME, INERTIA, NONE, Books, write_books
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.methods.largest_eigenvalue import largest_eigenvalue
from tautflex.solvers.transient.state import MotionState, MotionTerms

# The limit is estimated anew after so many steps, or as soon as the largest stress has grown by this factor.
_CHECK_INTERVAL, _STRESS_GROWTH = 100, 1.1
# Stiffness that changes from step to step can feed energy into steps close to the limit (parametric excitation).
_STIFFENED_SHARE = 0.5
# Step sizes whose factors are kept.
_MOST_FACTORS = 16


class ExplicitMethod(ABC):
    """Time-integration method whose steps solve with the mass matrix alone; a frozen dataclass."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name in results."""

    @abstractmethod
    def stepper(self, equation: EquationOfMotion) -> ExplicitStepper:
        """Stepper of one run."""


class ExplicitStepper(Remembering):
    """Central-difference steps of one run.

    Parameters
    ----------
    equation
        Equation of motion.
    """

    MEMORY: ClassVar[tuple[str, ...]] = ("_largest", "_age", "_stress", "_checked_stress", "_first_limit", "_vector")

    def __init__(self, equation: EquationOfMotion) -> None:
        self.equation = equation
        self._pattern = equation.system.pattern
        self._factors: dict[float, tuple[SymmetricFactorization, LowRankUpdate]] = {}
        self._largest, self._age = 0.0, 0
        self._stress = self._checked_stress = np.zeros(0)
        self._first_limit = 0.0
        self._vector: Array | None = None

    def memory(self) -> Memory:
        """Copy of what is remembered; of the factors, which are made anew, their step sizes."""
        return super().memory() | {"sizes": np.array(list(self._factors))}

    def recall(self, memory: Memory) -> None:
        """Remember what another stepper did."""
        super().recall(memory)
        for size in memory["sizes"].tolist():
            self._factor(size)

    def stable_step(self, q: Array) -> float:
        """Largest stable step [s] at free unknowns ``q``; infinite without any stiffness."""
        tangent = self._pattern.symmetric_matrix(self.equation.workspace.tangent(q))
        mass = self.equation.inertia.mass_matrix
        self._largest, self._vector = largest_eigenvalue(tangent, mass, self.equation.mass_solve, self._vector)
        self._age, self._checked_stress = 0, self._stress
        return self._limit

    @property
    def _limit(self) -> float:
        """Largest step [s] by the last estimate; kept clear of where the structure has stiffened."""
        limit = 2.0 / float(np.sqrt(self._largest)) if self._largest > 0.0 else np.inf
        return limit if limit >= 0.999 * self._first_limit else _STIFFENED_SHARE * limit

    def check(self, at: MotionState, time_step: float) -> None:
        """Raise InputError if ``time_step`` [s] is not stable at the start of the run."""
        limit = self._first_limit = self.stable_step(at.q)
        if time_step > limit:
            raise InputError(
                f"time_step: expected at most the stable step {_rounded_down(limit):.3g} s of the explicit method, got "
                f"{time_step:g}; use {_rounded_down(0.9 * limit):.3g}, or an implicit method"
            )

    def step(self, at: MotionState, size: float, segment: Segment) -> tuple[MotionState, NewtonOutcome]:
        """Advance by ``size`` [s] inside one smooth segment.

        Returns
        -------
        tuple
            The state at the end of the step, and an outcome that is not converged where the step is not stable.
        """
        self._age += 1
        if self._age > _CHECK_INTERVAL:
            self.stable_step(at.q)
        failed = NewtonOutcome(at.q, False, history=[size / self._limit])
        if size > self._limit:
            return at, failed
        half = at.v + 0.5 * size * at.a
        move = size * half
        q = at.q + move
        if at.internal is None:
            at.internal = self.equation.force(at.q)
            self._checked_stress = self._largest_stress()
        self.equation.set_time(at.time + size, segment.end)
        force = self.equation.force(q)
        if not self._stable_at(q, size):
            return at, failed
        # Stiffness that this very step has felt: a last warning before energy grows.
        felt = float(move @ (force - at.internal))
        if not felt <= 4.0 / size**2 * float(move @ (self.equation.inertia.mass_matrix @ move)):
            self._age = _CHECK_INTERVAL
            return at, failed
        terms = self.equation.motion_terms(segment.motion(at.time + size))
        a = self._acceleration(force, q, half, at.a, terms, size)
        end = MotionState(at.time + size, q, half + 0.5 * size * a, a, internal=force)
        end.books = self._books(at, end, terms, size)
        self.equation.book_inputs(end.books.work, at, end, segment.end)
        return end, NewtonOutcome(q, bool(np.isfinite(a).all()), history=[size / self._limit])

    def _books(self, at: MotionState, end: MotionState, terms: MotionTerms, size: float) -> Books:
        """Books at the end of a step, where all forces balance."""
        equation, own, none = self.equation, np.empty((5, end.q.size)), np.zeros_like(end.q)
        inertia = equation.inertia
        own[INERTIA] = equation.products.mass_product(end.a)
        own[DAMPING] = equation.products.damping_product(end.v) if equation.products.damped else 0.0
        own[FRAME] = equation.frame_load(terms)
        for weight, moving in ((terms.velocity, end.v), (terms.displacement, end.q)):
            if weight.any():
                own[FRAME] += inertia.apply(weight, moving)
        instants = size, size, at.books.late
        work = write_books(
            1.0,
            end.internal,
            none,
            equation.applied(end.q),
            NONE,
            at.q,
            end.q,
            instants,
            at.books.own,
            at.books.work,
            own,
            NONE,
        )
        return Books(work, own)

    def _stable_at(self, q: Array, size: float) -> bool:
        """Whether a step that ends at ``q``, where the force was just evaluated, keeps the limit of its end."""
        self._stress = self._largest_stress()
        known = self._checked_stress > 0.0
        grown = float(np.max(self._stress[known] / self._checked_stress[known], initial=1.0))
        # Frequencies grow with the root of the stress at most, as those of a string do.
        if grown <= _STRESS_GROWTH and size <= self._limit / np.sqrt(grown):
            return True
        before = self._largest, self._vector, self._age, self._checked_stress
        if size <= self.stable_step(q):
            return True
        # A shorter step will not get there: what is known of the start still holds for it.
        self._largest, self._vector, self._age, self._checked_stress = before
        return False

    def _largest_stress(self) -> Array:
        """Largest stress of each block at the last force evaluation [units of the block]."""
        return np.array([float(np.abs(stress).max(initial=0.0)) for stress in self.equation.workspace.stress])

    def _acceleration(self, force: Array, q: Array, half: Array, old: Array, terms: MotionTerms, size: float) -> Array:
        """Acceleration at the end of a step, where the velocity ``half + size a / 2`` depends on it."""
        equation = self.equation
        known = force + equation.frame_forces(q, half, terms)
        factor = self._factor(size)
        if not terms.velocity.any():
            return factor.solve(-known)
        # The gyroscopic force of h a / 2 is smaller than the inertia by (h times the spin): a few turns suffice.
        a = old
        for _ in range(10):
            before, a = a, factor.solve(-known - equation.inertia.apply(0.5 * size * terms.velocity, a))
            if float(np.abs(a - before).max()) <= 1e-12 * float(np.abs(a).max()):
                break
        return a

    def _factor(self, size: float) -> LowRankUpdate:
        """Factors of ``M + h C / 2``; without damping one serves all step sizes."""
        products = self.equation.products
        key = size if products.damped else 0.0
        if key not in self._factors:
            if len(self._factors) < _MOST_FACTORS:
                factors = SymmetricFactorization(self._pattern)
                update = LowRankUpdate(factors)
            else:  # the oldest make room, but their work stays counted
                factors, update = self._factors.pop(next(iter(self._factors)))
            factors.factorize(self.equation.inertia.mass_entries + 0.5 * key * products.entries)
            if products.matrix.rank:
                update.correct(products.matrix.vectors, 0.5 * key * products.matrix.coefficients)
            self._factors[key] = factors, update
        return self._factors[key][1]

    dulling = None

    def prepare(self, at: MotionState, size: float, segment: Segment) -> None:
        """Nothing: there is no tangent."""

    def resolved(self, end: MotionState, error: Array) -> Array:
        """The whole vector: a stable step resolves everything."""
        return error

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(*(factors for factors, _ in self._factors.values()))


def _rounded_down(step: float) -> float:
    """Step [s] with three digits that is not above the given one."""
    unit = 10.0 ** (np.floor(np.log10(step)) - 2)
    return float(np.floor(step / unit) * unit) if np.isfinite(step) else step
