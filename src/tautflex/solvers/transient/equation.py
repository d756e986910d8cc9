"""The equation of motion (49): its forces in a step, the start of a run and what a jump of the rigid motion changes.

`EquationOfMotion` is that of a prescribed floating frame, and what steppers, drivers and recorders ask of any other:
`HubEquation` says the same of a frame on a free hub.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.loads.inputs import InputSet, earlier
from tautflex.mechanics.loads.prepared import FollowerForce
from tautflex.mechanics.products import MassDamping
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.accuracy.books import DAMPING, FRAME, INERTIA, INTERNAL, LOAD, NONE, STRESS, Books
from tautflex.solvers.transient.accuracy.norms import ErrorNorms
from tautflex.solvers.transient.march.frame import frame_of, frame_terms
from tautflex.solvers.transient.methods.scheme import Stage, StepScheme
from tautflex.solvers.transient.moved_supports import MovedSupports
from tautflex.solvers.transient.state import MotionState, MotionTerms, Resolved, hermite
from tautflex.solvers.transient.status import Statistics
from tautflex.solvers.transient.step_kernel import begin_step, end_of_step, step_residual


@dataclass
class EquationOfMotion(ErrorNorms):
    """Forces of ``M a + P(q, v, t) = 0`` [paper (49)] for one run.

    Parameters
    ----------
    state
        Prestressed state.
    damping
        Damping model.
    coupling
        Switches of the rotating-frame terms.
    statistics
        Where the work is counted.
    inputs
        Forces, tensions and temperatures in time; None is none.
    """

    kind: ClassVar[type[MotionState]] = MotionState
    state: PrestressedState
    damping: Damping
    coupling: Coupling
    statistics: Statistics = field(default_factory=Statistics)
    inputs: InputSet | None = None

    def __post_init__(self) -> None:
        self.system = self.state.system
        self.inertia = self.system.inertia
        linear = self.state.linear
        matrix = self.damping.of(linear)
        self.moved = MovedSupports(self.state, matrix, self.inputs) if self.inputs and self.inputs.moved else None
        self.workspace = self.system.workspace() if self.moved is None else self.moved.workspace
        kinds = linear.by_kind if matrix.kinds else None
        self.products = MassDamping(
            self.system.pattern, self.inertia.mass_entries, self.state.tangent_entries, matrix, kinds
        )
        self.frame: Any = frame_of(self.coupling, self.coupling.moments(self.system))
        self._mass_factor = SymmetricFactorization(self.system.pattern)
        self._motion: RigidMotion | None = None
        self.at_rest = MotionTerms((), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(self.system.size))
        self._terms = self.at_rest
        self.input_load = np.zeros(self.system.size)
        self.restressed = bool(self.inputs and self.inputs.changes_stress())
        given = self.inputs if self.restressed else None
        self.pattern = self.workspace.stress_pattern(given.columns) if given and given.all_linear else None
        self._numbers = NONE
        self.followers: list[FollowerForce] = []

    def motion_terms(self, motion: RigidMotion) -> MotionTerms:
        """Gyroscopic and K_T matrices and the load of a motion; kept while the motion does not change."""
        if motion is self._motion:
            return self._terms
        self._motion = motion
        row = motion.row
        key = tuple(row.tolist())
        if self._terms.key != key:
            self._terms = MotionTerms(key, *frame_terms(row, self.frame))
        return self._terms

    def set_time(self, time: float, before: float = np.inf) -> bool:
        """Apply the inputs of an instant; a jump at ``before`` is not met yet. Whether they may be other ones."""
        if not self.inputs:
            return False
        instant = earlier(time, before)
        if self.inputs.all_linear:
            numbers = self.inputs.values(instant)
            if np.array_equal(numbers, self._numbers):
                return False
            self._numbers = numbers
        self.input_load, self.followers = self.inputs.load(instant), self.inputs.followers(instant)
        if self.pattern is not None:
            self.workspace.restress(self.pattern, self._numbers)
        else:
            self.workspace.change_initial_stress(self.inputs.stress(instant))
        if self.moved is not None:
            self.moved.set_time(instant)
        return True

    def forget_time(self) -> None:
        """Apply inputs anew at the next instant, whatever is set: another has changed stresses."""
        self._numbers = NONE

    def force(self, q: Array) -> Array:
        """Internal force above the reference."""
        self.statistics.force_evaluations += 1
        force, _ = self.workspace.force(q)
        force -= self.state.reference_force
        return force

    def applied(self, q: Array) -> Array:
        """Force of the inputs at the instant that is set."""
        return sum((item.force(q) for item in self.followers), self.input_load)

    def frame_load(self, terms: MotionTerms) -> Array:
        """Load of the moving frame, and of moved supports at the instant that is set; left-hand side."""
        return terms.load if self.moved is None else terms.load + self.moved.load(terms)

    def frame_forces(self, q: Array, v: Array, terms: MotionTerms) -> Array:
        """Forces of damping, of the moving frame and of the inputs."""
        total = self.frame_load(terms) - self.applied(q)
        if self.products.damped:
            total += self.products.damping_product(v)
        if terms.velocity.any():
            total += self.inertia.apply(terms.velocity, v)
        if terms.displacement.any():
            total += self.inertia.apply(terms.displacement, q)
        return total

    def start(self, time: float, q: Array, v: Array, motion: RigidMotion, hub: Array = NONE) -> MotionState:
        """State with the acceleration that balances all forces at ``time``; ``hub`` is that of a free one."""
        self.set_time(time)
        forces = self.force(q) + self.frame_forces(q, v, self.motion_terms(motion))
        return MotionState(time, q, v, self.mass_solve(-forces), forces)

    def balance(self, at: MotionState, motion: RigidMotion) -> Array:
        """All forces of an instant and its strain energy, shape (size + 1,): what may change where a run goes on."""
        self.set_time(at.time)
        forces = self.frame_forces(at.q, at.v, self.motion_terms(motion)) + self.force(at.q)
        return np.append(forces, self.strain_energy(at.q))

    def rebalanced(self, at: MotionState, before: Array, motion: RigidMotion, dulling: Resolved | None) -> MotionState:
        """Same position and velocity where `balance` was another before: the acceleration takes up the difference."""
        change = self.balance(at, motion) - before
        if not change.any():
            return at
        pushed, stored = self.mass_solve(-change[:-1]), self._stored(at.q) - change[-1]
        return self._pushed_by(at, dulling(at, pushed) if dulling and self.restressed else pushed, stored)

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion, dulling: Resolved | None) -> MotionState:
        """Same position and velocity under another rigid motion; the acceleration takes up the jump of the forces.

        Only the change is solved for: re-computing the whole acceleration would throw the small imbalance that a
        collocation method leaves in the stiff directions into it.

        Of stresses that jump only what steps resolve is taken up by methods that overshoot in the rest: a tension that
        jumps accelerates the film in its plane by ``w^2`` times its static answer, w far beyond the step. The film then
        feels the jump late, by up to half a step.
        """
        self.set_time(at.time, at.time)
        old, stored = self._all_forces(at, before), self._stored(at.q)
        inside = self.force(at.q) if dulling and self.restressed else NONE
        self.set_time(at.time)
        change = self._all_forces(at, after) - old
        pushed = self._pushed_by(at, self.mass_solve(-change), stored) if change.any() else at
        pull = self.force(at.q) - inside if inside.size else NONE
        return self.settled(pushed, pull, dulling) if dulling and pull.any() else pushed

    def _pushed_by(self, at: MotionState, change: Array, stored: float) -> MotionState:
        """State with this change of its acceleration, from one that stored another strain energy [J]."""
        forces = None if at.forces is None else at.forces - self.products.mass_product(change)
        return MotionState(at.time, at.q, at.v, at.a + change, forces, books=self.books_behind_jump(at, stored))

    def settled(self, at: MotionState, pull: Array, resolved: Resolved) -> MotionState:
        """A state with what steps resolve of the acceleration by a force of stresses, shape (size,); see `jump`."""
        pushed = self.mass_solve(-pull)
        return self._pushed_by(at, resolved(at, pushed) - pushed, self._stored(at.q))

    def strain_energy(self, q: Array) -> float:
        """Strain energy above the reference at the instant that is set [J]."""
        return self.workspace.strain_energy(q) - float(self.state.reference_force @ q)

    def _stored(self, q: Array) -> float:
        """The same where inputs change it, else zero."""
        return self.strain_energy(q) if self.restressed else 0.0

    def book_inputs(self, work: Array, at: MotionState, end: MotionState, before: float) -> None:
        """Add to the work of a step what inputs strain and what dampers take of moved supports."""
        if self.restressed or self.moved is not None:
            work[STRESS] += self.restressing_work(at, end, before)
        if self.moved is not None:
            self.moved.keep_books(work, at, end)

    def restressing_work(self, at: MotionState, end: MotionState, before: float) -> float:
        """What inputs add to the strain energy over a step [J]; its end is then set."""
        self.set_time(at.time)
        if not self.set_time(end.time, before):
            return 0.0
        stored = self.workspace.strain_energy(q := 0.5 * (at.q + end.q))
        self.set_time(at.time)
        stored -= self.workspace.strain_energy(q)
        self.set_time(end.time, before)
        return stored

    def books_behind_jump(self, at: MotionState, stored: float) -> Books:
        """Books of a state behind a jump, before which ``stored`` [J] was its strain energy; that instant is set."""
        work = at.books.work.copy()
        work[STRESS] += self._stored(at.q) - stored
        return Books(work)

    def _all_forces(self, at: MotionState, motion: RigidMotion) -> Array:
        """Forces that may jump; the internal ones do where tension or temperature does."""
        total = self.frame_forces(at.q, at.v, self.motion_terms(motion))
        return total + self.force(at.q) if self.inputs else total

    def step_forces(
        self, numbers: StepNumbers, at: MotionState, size: float, segment: Segment, diagonal: Array
    ) -> StepForces:
        """Forces of a step of this size [s] inside one smooth segment, see `StepForces`."""
        instant = at.time + numbers.scheme.evaluation * size
        terms = self.motion_terms(segment.motion(instant))
        then = self.then(numbers, at, segment)
        self.set_time(instant, segment.end)
        return StepForces(self, numbers, terms, at, size, diagonal, segment.end, then)

    def then(self, numbers: StepNumbers, at: MotionState, segment: Segment) -> Array:
        """Forces at a step's start by kind, unresolved ones as internal, (5, size), if it weighs them; else empty."""
        if numbers.scheme.weight == 1.0 or at.books.now.size:
            return at.books.now
        assert at.forces is not None  # the method needs them
        self.set_time(at.time)
        rows, terms = np.zeros((5, at.q.size)), self.motion_terms(segment.motion(at.time))
        beside = self.frame_forces(at.q, at.v, terms)
        rows[DAMPING], rows[LOAD] = self.products.damping_product(at.v), -self.applied(at.q)
        rows[FRAME], rows[INTERNAL] = beside - rows[DAMPING] - rows[LOAD], at.forces - beside
        return rows

    def correction(self, q: Array, scheme: StepScheme) -> tuple[Array, Array]:
        """U, shape (rank, size), and D, (rank, rank), of the low-rank part ``U' D U`` of the effective stiffness."""
        damping = self.products.matrix
        return damping.vectors, np.diag(scheme.weight * scheme.velocity.d * damping.coefficients)

    def motion(self, at: MotionState, segment: Segment) -> RigidMotion:
        """Motion of the floating frame."""
        return segment.motion(at.time)

    def kinetic_energy(self, at: MotionState) -> float:
        """Energy of the motion relative to the floating frame [J]."""
        return 0.5 * self.products.mass_norm(at.v)

    def between(self, start: MotionState, end: MotionState, time: float) -> MotionState:
        """State at an instant between two states."""
        q, v = hermite(start.time, end.time, time, (start.q, end.q), (start.v, end.v))
        share = (time - start.time) / (end.time - start.time)
        return MotionState(time, q, v, start.a + share * (end.a - start.a))

    def mobile_mass(self, at: MotionState, vector: Array) -> Array:
        """Mass that elastic motion alone moves, times a vector of shape (size,)."""
        return self.products.mass_product(vector)

    def count(self, *factors: SymmetricFactorization) -> None:
        """Bring the counters of the mass factors and of others into the statistics."""
        every = (self._mass_factor, *factors)
        self.statistics.factorizations = sum(factor.factorizations for factor in every)
        self.statistics.back_substitutions = sum(factor.solves for factor in every)

    @property
    def mass_ready(self) -> bool:
        """Whether the mass matrix was factorized."""
        return self._mass_factor.ready

    def mass_solve(self, right: Array) -> Array:
        """Solve with the consistent mass matrix, shape (size,)."""
        if not self._mass_factor.ready:
            self._mass_factor.factorize(self.inertia.mass_entries)
        return self._mass_factor.solve(right)


class StepNumbers:
    """Stage of one step size as compiled code reads it."""

    def __init__(self, stage: Stage, equation: EquationOfMotion) -> None:
        self.scheme, self.share, self.recalled = stage.scheme, stage.share, stage.factors
        scheme = stage.scheme
        # What `step_residual` asks for.
        self.part = scheme.evaluation if scheme.average_stress else 0.0
        # Damping in proportion to stiffness resists in the axes of the reference: it does not turn with the structure.
        self.turning_share = 1.0 / (1.0 + scheme.velocity.d * equation.products.matrix.stiffness)
        inertia, velocity = scheme.inertia, scheme.velocity
        ends = (scheme.end_displacement, scheme.end_velocity, scheme.end_acceleration, inertia, velocity)
        self.end = np.array([(part.d, part.v, part.a) for part in ends])
        self.known = np.array([scheme.weight, inertia.v, inertia.a, velocity.v, velocity.a, velocity.d])
        self.linear = equation.products.combined(inertia.d, scheme.weight * velocity.d)
        # The same in the pattern's upper triangle, for the effective stiffness.
        constant = inertia.d * equation.inertia.mass_entries
        if equation.products.spread:
            constant += scheme.weight * velocity.d * equation.products.entries
        self.constant_stiffness = constant[equation.system.pattern.upper[0]]


class StepForces:
    """All forces of one step from ``at`` as a function of its increment.

    ``terms`` are those of the frame at the evaluation instant, ``diagonal`` is that of the stiffness, shape (size,);
    a jump at ``before`` [s] is not met yet, and ``then`` has the forces at the start by kind if they are weighed.
    ``known_norm`` and ``stiff_norm`` are the norms of the forces that do not depend on the increment and of
    ``diagonal * q`` [N], ``displacement`` is the matrix Z of the frame's stiffness M(Z), shape (3, 3) [1/s^2].
    """

    def __init__(
        self, equation: EquationOfMotion, numbers: StepNumbers, terms: MotionTerms, at: MotionState, size: float,
        diagonal: Array, before: float, then: Array,
    ) -> None:  # fmt: skip
        self.equation, self.numbers, self.at, self.size = equation, numbers, at, size
        self.displacement, self.before = terms.displacement, before
        self._then, self._input, self._frame = then, equation.input_load, equation.frame_load(terms)
        self._scheme = scheme = numbers.scheme
        products, pairs = equation.products, equation.inertia.pairs
        load = self._frame - equation.input_load if equation.inputs else self._frame
        self._rows, turning, self.known_norm, self._load_norm, self.stiff_norm = begin_step(
            products.start, products.column, products.mass, products.damping, products.spread, pairs,
            numbers.known, terms.velocity, terms.displacement, load, diagonal, at.q, at.v, at.a,
        )  # fmt: skip
        known = self._rows[0]
        if products.matrix.rank:
            velocity = scheme.velocity
            products.add_low_rank(scheme.weight, velocity.v * at.v + velocity.a * at.a, known)
            self.known_norm = float(np.linalg.norm(known))
        self._internal = self._history = NONE
        self._followers, self._followed = equation.followers, NONE
        if scheme.weight < 1.0:
            assert at.forces is not None
            self._history = at.forces
            known += (1.0 - scheme.weight) * at.forces
            self.known_norm = float(np.linalg.norm(known))
        self._fixed: Any = (
            products.start, products.column, numbers.linear, pairs, turning, scheme.weight,
            equation.state.reference_force, self._rows,
        )  # fmt: skip
        workspace = equation.workspace
        self._elements: Any = workspace.store, workspace.stresses, workspace.held

    def residual(self, x: Array) -> tuple[Array, float, float, float]:
        """Residual of an increment [N], its norm, the norm of the forces it is measured against, that of inertia."""
        found = step_residual(x, self.at.q, *self._elements, *self._fixed, False, self.numbers.part)
        self._internal, residual, norm, internal, inertia, _ = found
        products, scale = self.equation.products, max(internal, self._load_norm)
        if products.matrix.rank:
            products.add_low_rank(self._scheme.weight * self._scheme.velocity.d, x, residual)
            norm = float(np.linalg.norm(residual))
        if self._followers:
            norm, push = self._push(x, residual)
            scale = max(scale, push)
        return residual, norm, scale, inertia

    @np.errstate(over="ignore", invalid="ignore")
    def _push(self, x: Array, residual: Array) -> tuple[float, float]:
        """Take the forces that follow the motion from the residual, their mean if stresses are averaged; both norms."""
        start, push = self.at.q, np.zeros_like(x)
        for item in self._followers:
            if self._scheme.average_stress:
                push += item.mean_force(start, start + x / self._scheme.evaluation)
            else:
                push += item.force(start + x)
        self._followed = push.copy()
        push *= self._scheme.weight
        residual -= push
        return float(np.linalg.norm(residual)), float(np.linalg.norm(push))

    def end(self, x: Array, residual: Array) -> MotionState:
        """State at the end of the step whose increment leaves this residual, the last that was computed."""
        at, weight, books, equation = self.at, self._scheme.weight, self.at.books, self.equation
        products, instant = equation.products, weight * self._scheme.evaluation * self.size
        load = self._input + self._followed if self._followers else self._input
        rows, work, _ = end_of_step(
            self.numbers.end, self.size, instant, books.late, products.start, products.column, products.mass,
            products.spread, products.vectors, products.coefficients, weight, self._rows, self._internal,
            equation.state.reference_force, self._frame, load, self._then, books.own, books.work, x, at.q, at.v, at.a,
        )  # fmt: skip
        q, v, a, jerk = rows[:4]
        forces, now = None, NONE
        if weight < 1.0:
            now = rows[9:]
            forces = (residual - now[INERTIA] - (1.0 - weight) * self._history) / weight
        books = Books(work, rows[4:9], now, instant - self.size)
        end = MotionState(at.time + self.size, q, v, a, forces, jerk, books=books)
        equation.book_inputs(work, at, end, self.before)
        return end
