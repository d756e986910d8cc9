"""Central differences across a flat film whose motion in its plane follows statically."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tautflex.errors import UnsupportedError
from tautflex.mechanics.kernel import add_forces
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices, jit
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.substitution import substitute
from tautflex.solvers.nonlinear.newton import NewtonOutcome
from tautflex.solvers.static.across import transverse_unknowns
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.explicit import ExplicitMethod, ExplicitStepper
from tautflex.solvers.transient.methods.largest_eigenvalue import largest_eigenvalue
from tautflex.solvers.transient.state import MotionState, MotionTerms

# Forces in the plane may leave this part of all internal ones. A correction by the stiffness of the reference leaves of
# its residual a part of the size of the strains: one is enough for small ones.
_BALANCED, _MOST_CORRECTIONS = 5e-3, 8
# Velocity at the end of a step over its mean, where the step before had none.
_LATE = 1.5
# Part of the limit that is used: what the film's stretching adds to the stiffness of short waves is not in it.
_SHARE = 0.9

Moved = tuple[Array, Array, Array, Array]
"""Displacement, velocity, acceleration and internal force at the end of a step, shape (size,) each."""


@dataclass(frozen=True)
class CondensedDifference(ExplicitMethod):
    """Central differences across a flat film held at its edges; its motion in the plane follows statically.

    Notes
    -----
    In its plane a film answers far faster than across: the inertia there is left out, and so are waves of stretching.
    Every step moves the film across by central differences, solves for the displacement in the plane that balances it
    there (the stiffness of the reference serves for the whole run) and takes the acceleration across from the forces
    of both [partition by unknowns: Belytschko & Mullen 1978, Int. J. Numer. Methods Eng. 12, 1575; static condensation:
    theory.md 10]. No tangent is assembled after the start. Second order, no numerical damping.

    Short waves across a film of slope g carry the displacement -g w in the plane with them and feel the tension
    alone, so the stable step is ``2 / sqrt(l s)``: s is the largest principal stress and l the largest eigenvalue of
    the stiffness of unit tension and the mass. It follows the stress in every step; a step beyond it is halved.
    """

    @property
    def name(self) -> str:
        """Name in results."""
        return "central difference, static in the plane"

    def stepper(self, equation: EquationOfMotion) -> CondensedStepper:
        """Stepper of one run; UnsupportedError where the plane of a film is not all that can follow statically."""
        _refuse_other(equation)
        return CondensedStepper(equation)


class CondensedStepper(ExplicitStepper):
    """Steps of one run.

    Parameters
    ----------
    equation
        Equation of motion.
    """

    MEMORY = ("_largest",)

    def __init__(self, equation: EquationOfMotion) -> None:
        super().__init__(equation)
        across = transverse_unknowns(equation.state)
        self._across, self._inside = np.flatnonzero(across), np.flatnonzero(~across)
        self._solvers: dict[float, tuple[_Part, _Part]] = {}
        self._unit = self._stiffness_of_unit_tension()

    def _stiffness_of_unit_tension(self) -> float:
        """Largest squared frequency across under a stress of 1 Pa [1/(s^2 Pa)]."""
        system = self.equation.system
        blocks = tuple(replace(block, elasticity=np.zeros_like(block.elasticity)) for block in system.blocks)
        tension = [np.tile((1.0, 1.0, 0.0), (len(stress), 1)) for stress in system.initial_stress]
        stiffness = system.with_initial_stress(tension, blocks).tangent(np.zeros(system.size))
        mass, part = self.equation.inertia.mass_entries, _Part(self._pattern, self._across)
        part.factor.factorize(mass[part.kept])
        pull, inertia = (part.pattern.symmetric_matrix(values[part.kept]) for values in (stiffness, mass))
        return largest_eigenvalue(pull, inertia, part.factor.solve)[0]

    def stable_step(self, q: Array) -> float:
        """Largest stable step [s] at free unknowns ``q``."""
        self.equation.workspace.strain_energy(q)
        self._see_stress()
        return self._limit

    @property
    def _limit(self) -> float:
        return _SHARE * 2.0 / float(np.sqrt(self._largest)) if self._largest > 0.0 else np.inf

    def _see_stress(self) -> None:
        """Take the stresses of the last evaluation."""
        rows = self.equation.workspace.stress_rows
        self._largest = self._unit * max(largest_principal(part) for part in rows)

    def step(self, at: MotionState, size: float, segment: Segment) -> tuple[MotionState, NewtonOutcome]:
        """Advance by ``size`` [s] inside one smooth segment, see `ExplicitStepper`."""
        failed = NewtonOutcome(at.q, False, history=[size / self._limit])
        if size > self._limit:
            return at, failed
        equation = self.equation
        equation.set_time(at.time + size, segment.end)
        terms = equation.motion_terms(segment.motion(at.time + size))
        moved = self._moved_alone(at, terms, size) or self._moved(at, terms, size)
        if moved is None:
            return at, failed
        q, v, a, force = moved
        before = self._largest
        self._see_stress()
        if size > self._limit:
            self._largest = max(before, self._largest)
            return at, failed
        end = MotionState(at.time + size, q, v, a, jerk=(a - at.a) / size, internal=force)
        end.books = self._books(at, end, terms, size)
        equation.book_inputs(end.books.work, at, end, segment.end)
        return end, NewtonOutcome(q, bool(np.isfinite(a).all()), history=[size / self._limit])

    def _moved_alone(self, at: MotionState, terms: MotionTerms, size: float) -> Moved | None:
        """End of a step if nothing but a load acts besides the film, and one correction is enough; else None."""
        equation, (inside, across) = self.equation, self._parts(size)
        turns = terms.velocity.any() or terms.displacement.any()
        factors = inside.factor.parts, across.factor.parts
        if turns or equation.products.damped or equation.followers or None in factors:
            return None
        load, workspace = equation.frame_load(terms) - equation.input_load, equation.workspace
        elements = workspace.store, workspace.stresses, equation.state.reference_force
        rows, left = step_alone(at.q, at.v, at.a, size, load, elements, (self._inside, self._across), factors)
        equation.statistics.force_evaluations += 2
        equation.statistics.iterations += 1
        inside.factor.solves += 1
        across.factor.solves += 1
        return (rows[0], rows[1], rows[2], rows[3]) if left <= _BALANCED else None

    def _moved(self, at: MotionState, terms: MotionTerms, size: float) -> Moved | None:
        """End of a step under all that may act, or None if the plane does not come to balance."""
        half = at.v + 0.5 * size * at.a
        # In the plane the velocity that is kept is the mean of a step, and first guess for the next.
        half[self._inside] = at.v[self._inside]
        q = at.q + size * half
        force = self._balance(q, half, terms, size)
        if force is None:
            return None
        a = self._acceleration(force, q, half, at.a, terms, size)
        v = half + 0.5 * size * a
        v[self._inside] = (q - at.q)[self._inside] / size
        return q, v, a, force

    def _balance(self, q: Array, v: Array, terms: MotionTerms, size: float) -> Array | None:
        """Bring displacement and velocity in the plane to balance; the internal force, or None if it fails.

        The velocity at the end of a step is ``(3 d - d_before) / 2 h``, d the displacements of steps: second order.
        """
        inside, equation = self._inside, self.equation
        for number in range(_MOST_CORRECTIONS):
            force = equation.force(q)
            left = (force + equation.frame_forces(q, v, terms))[inside]
            if number and np.linalg.norm(left) <= _BALANCED * np.linalg.norm(force):
                return force
            if not np.isfinite(left.sum()):
                return None
            move = self._parts(size)[0].factor.solve(left)
            q[inside] -= move
            v[inside] -= _LATE * move / size
            equation.statistics.iterations += 1
        return None

    def _factor(self, size: float) -> Any:
        """Solver across; accelerations in the plane are zero."""
        return self._parts(size)[1]

    def _parts(self, size: float) -> tuple[_Part, _Part]:
        """Factors of ``K + 3 C / 2 h`` in the plane and ``M + h C / 2`` across; without damping for all step sizes."""
        products = self.equation.products
        key = size if products.damped else 0.0
        if key not in self._solvers:
            mass, damping = self.equation.inertia.mass_entries, products.entries
            inside, across = _Part(self._pattern, self._inside), _Part(self._pattern, self._across)
            stiffness = self.equation.state.tangent_entries
            inside.factor.factorize((stiffness + (_LATE * damping / key if key else 0.0))[inside.kept])
            across.factor.factorize((mass + 0.5 * key * damping)[across.kept])
            self._solvers[key] = inside, across
        return self._solvers[key]

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(*(part.factor for parts in self._solvers.values() for part in parts))


class _Part:
    """Some unknowns, the pattern of their matrices and its factors."""

    def __init__(self, pattern: SparsityPattern, chosen: Indices) -> None:
        number = np.full(pattern.size, -1)
        number[chosen] = np.arange(len(chosen))
        self.kept = np.flatnonzero((number[pattern.rows] >= 0) & (number[pattern.columns] >= 0))
        starts = np.searchsorted(number[pattern.columns[self.kept]], np.arange(len(chosen) + 1))
        rows = number[pattern.rows[self.kept]]
        self.pattern = SparsityPattern(len(chosen), starts.astype(np.int32), rows.astype(np.int32))
        self.factor = SymmetricFactorization(self.pattern)
        self._chosen = chosen

    def solve(self, right: Array) -> Array:
        """Solution for a right-hand side (size,), zero elsewhere."""
        result = np.zeros_like(right)
        result[self._chosen] = self.factor.solve(right[self._chosen])
        return result


@jit
def step_alone(
    q: Array, v: Array, a: Array, size: float, load: Array, elements: Any, chosen: Any, factors: Any
) -> tuple[Array, float]:
    """One step of a film under a load, with one correction in its plane; twin of `CondensedStepper._moved`.

    Returns displacement, velocity, acceleration and internal force at its end, shape (4, size), and the part of all
    internal forces that is left in the plane.
    """
    (store, stresses, reference), (inside, across), (plane, mass) = elements, chosen, factors
    count, rows = q.size, np.zeros((4, q.size))
    place, speed, bend, force = rows[0], rows[1], rows[2], rows[3]
    extended, found, pull = np.zeros(count + 1), np.zeros(count + 1), np.empty(inside.size)
    for i in across:
        speed[i] = v[i] + 0.5 * size * a[i]
    for i in inside:
        speed[i] = v[i]
    for i in range(count):
        place[i] = extended[i] = q[i] + size * speed[i]
    add_forces(store, extended, found, stresses, True, False, False)
    for k in range(inside.size):
        i = inside[k]
        pull[k] = found[i] - reference[i] + load[i]
    move = substitute(plane[0], plane[1], plane[2], pull)
    for k in range(inside.size):
        i = inside[k]
        place[i] = extended[i] = place[i] - move[k]
        speed[i] = (place[i] - q[i]) / size
    found[:] = 0.0
    add_forces(store, extended, found, stresses, True, True, False)
    left, norm, push = 0.0, 0.0, np.empty(across.size)
    for i in range(count):
        force[i] = found[i] - reference[i]
        norm += force[i] * force[i]
    for i in inside:
        left += (force[i] + load[i]) ** 2
    for k in range(across.size):
        push[k] = -force[across[k]] - load[across[k]]
    found = substitute(mass[0], mass[1], mass[2], push)
    for k in range(across.size):
        i = across[k]
        bend[i] = found[k]
        speed[i] += 0.5 * size * found[k]
    return rows, np.sqrt(left / norm) if norm > 0.0 else np.sqrt(left)


@jit
def largest_principal(stress: Array) -> float:
    """Largest principal stress of plane ones, shape (3, row), not below zero."""
    largest = 0.0
    for n in range(stress.shape[1]):
        x, y, shear = stress[0, n], stress[1, n], stress[2, n]
        largest = max(largest, 0.5 * (x + y) + np.sqrt(0.25 * (x - y) ** 2 + shear**2))
    return largest


def _refuse_other(equation: EquationOfMotion) -> None:
    """Raise UnsupportedError unless all is elastic film in one plane, moved by nothing but loads and its frame."""
    state: PrestressedState = equation.state
    remedy = "use CentralDifference(), or an implicit method"
    others = sorted({block.kind for block in state.system.blocks} - {"membrane"})
    if others:
        raise UnsupportedError(
            f"method: expected a structure of film alone for CondensedDifference(), got {', '.join(others)}; {remedy}"
        )
    laws = sorted({block.law.name for block in state.system.blocks if not block.is_elastic})
    if laws:
        raise UnsupportedError(f"law: expected 'elastic' for CondensedDifference(), got {', '.join(laws)}; {remedy}")
    if transverse_unknowns(state).all():
        raise UnsupportedError(f"method: expected a flat film for CondensedDifference(), got a curved one; {remedy}")
    if equation.products.matrix.rank:
        raise UnsupportedError(
            f"damping: expected Rayleigh() or none for CondensedDifference(), got damping of modes; {remedy}"
        )
    if equation.moved is not None:
        raise UnsupportedError(f"inputs: expected supports at rest for CondensedDifference(), got moved ones; {remedy}")
