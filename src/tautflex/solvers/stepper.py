"""One implicit step of the equation of motion (49), with everything that can be re-used kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tautflex.mechanics.damping import Rayleigh
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.solvers.integrator import Combination, ImplicitMethod, StepScheme
from tautflex.solvers.linear import SymmetricFactorization
from tautflex.solvers.newton import NewtonOutcome, solve_newton
from tautflex.solvers.prestress import PrestressedState
from tautflex.solvers.secant import SecantMemory
from tautflex.solvers.status import Statistics

Array = NDArray[np.float64]

# The force scale of a step never falls below this part of the largest one met so far: after the motion has died
# away there is nothing to resolve at full relative accuracy.
_SCALE_FLOOR = 1e-3
# Iterations lost to an old factorization, summed over steps, that pay for a new one (measured: 40x20 antenna).
_REFRESH_COST = 16


@dataclass
class MotionState:
    """State of the structure at one instant.

    Parameters
    ----------
    time
        [s].
    q, v, a
        Free unknowns, their velocities and accelerations, shape (size,).
    forces
        All forces but inertia at this instant, shape (size,); None until a method asks for them.
    """

    time: float
    q: Array
    v: Array
    a: Array
    forces: Array | None = None
    jerk: Array | None = None


@dataclass(frozen=True)
class _MotionTerms:
    """Rotating-frame terms at one instant: G = M(velocity), K_T = M(displacement), Q_T = load."""

    key: tuple[float, ...]
    velocity: Array
    displacement: Array
    load: Array


@dataclass
class Stepper:
    """Implicit steps of one run.

    Parameters
    ----------
    state
        Prestressed state.
    method
        Integrator.
    damping
        Damping model.
    coupling
        Switches of the rotating-frame terms.
    tolerance
        Newton tolerance: residual norm over force scale.
    max_iterations
        Newton steps allowed in one step.
    """

    state: PrestressedState
    method: ImplicitMethod
    damping: Rayleigh
    coupling: Coupling
    tolerance: float
    max_iterations: int = 25
    statistics: Statistics = field(default_factory=Statistics)

    def __post_init__(self) -> None:
        system = self.state.system
        self._system, self._pattern, self._inertia = system, system.pattern, system.inertia
        self._damping_entries = self.damping.entries(self._inertia.mass_entries, self.state.tangent_entries)
        damped = bool(self._damping_entries.any())
        self._damping_matrix = self._pattern.symmetric_matrix(self._damping_entries) if damped else None
        self._factor = SymmetricFactorization(self._pattern)
        self._factor_size = 0.0
        self._fewest_iterations, self._lost_iterations, self._judged = 0, 0, 0
        self._memory = SecantMemory()
        self._mass_factor = SymmetricFactorization(self._pattern)
        self._terms: _MotionTerms | None = None
        self._linear: tuple[float, csr_array] | None = None
        self._largest_scale = 0.0

    # -- forces ---------------------------------------------------------------------------------------------------

    def _motion_terms(self, motion: RigidMotion) -> _MotionTerms:
        """Gyroscopic and K_T matrices and the load of a motion; kept while the motion does not change."""
        key = (*motion.angular_velocity, *motion.angular_acceleration, *motion.origin_acceleration)
        if self._terms is not None and self._terms.key == key:
            return self._terms
        self._terms = _MotionTerms(
            key,
            self.coupling.velocity_weight(motion),
            self.coupling.displacement_weight(motion),
            self.coupling.load(motion, self._inertia),
        )
        return self._terms

    def _force(self, q: Array) -> Array:
        """Internal force above the reference."""
        self.statistics.force_evaluations += 1
        force, _ = self._system.force(q)
        force -= self.state.reference_force
        return force

    def _frame_forces(self, q: Array, v: Array, terms: _MotionTerms) -> Array:
        """Forces of damping and of the moving frame."""
        total = terms.load.copy()
        if self._damping_matrix is not None:
            total += self._damping_matrix @ v
        if terms.velocity.any():
            total += self._inertia.apply(terms.velocity, v)
        if terms.displacement.any():
            total += self._inertia.apply(terms.displacement, q)
        return total

    def start(self, time: float, q: Array, v: Array, motion: RigidMotion) -> MotionState:
        """State with the acceleration that balances all forces at ``time``."""
        forces = self._force(q) + self._frame_forces(q, v, self._motion_terms(motion))
        return MotionState(time, q, v, self._mass_solve(-forces), forces)

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion) -> MotionState:
        """Same position and velocity under another rigid motion; the acceleration takes up the jump of the forces.

        Only the change is solved for: re-computing the whole acceleration would throw the small imbalance that a
        collocation method leaves in the stiff directions into it.
        """
        old = self._frame_forces(at.q, at.v, self._motion_terms(before))
        change = self._frame_forces(at.q, at.v, self._motion_terms(after)) - old
        if not change.any():
            return at
        forces = None if at.forces is None else at.forces + change
        return MotionState(at.time, at.q, at.v, at.a + self._mass_solve(-change), forces)

    def _mass_solve(self, right: Array) -> Array:
        if not self._mass_factor.ready:
            self._mass_factor.factorize(self._inertia.mass_entries)
        return self._mass_factor.solve(right)

    # -- one step -------------------------------------------------------------------------------------------------

    def step(self, at: MotionState, size: float, segment: Segment) -> tuple[MotionState, NewtonOutcome]:
        """Advance by ``size`` inside one smooth segment.

        Parameters
        ----------
        at
            Start of the step.
        size
            Step size [s].
        segment
            Stretch of the maneuver; evaluated at the method's evaluation instant.

        Returns
        -------
        tuple
            The state at the end of the step (meaningless unless converged) and the Newton outcome.
        """
        scheme = self.method.scheme(size)
        terms = self._motion_terms(segment.motion(at.time + scheme.evaluation * size))
        problem = _StepProblem(self, scheme, terms, at, size)
        reach = scheme.evaluation * size
        guess = reach * at.v + 0.5 * reach**2 * at.a
        if at.jerk is not None:
            guess += reach**3 / 6.0 * at.jerk
        outcome = solve_newton(problem, guess, self.tolerance, self.max_iterations, self._memory)
        self.statistics.iterations += outcome.iterations
        d = outcome.x
        end = MotionState(
            at.time + size,
            at.q + _combine(scheme.end_displacement, d, at),
            _combine(scheme.end_velocity, d, at),
            _combine(scheme.end_acceleration, d, at),
        )
        end.jerk = (end.a - at.a) / size
        if scheme.weight < 1.0 and outcome.converged:
            inertia_force = self._inertia.mass_matrix @ _combine(scheme.inertia, d, at)
            history = (1.0 - scheme.weight) * problem.history
            end.forces = (outcome.residual - inertia_force - history) / scheme.weight
        self._judge_factor(outcome.iterations)
        if outcome.converged:
            self._largest_scale = max(self._largest_scale, problem.scale)
        return end, outcome

    def _judge_factor(self, iterations: int) -> None:
        """Drop the factorization once the iterations that its age cost would have paid for a new one."""
        if self._judged != self._factor.factorizations:
            self._judged = self._factor.factorizations
            self._fewest_iterations, self._lost_iterations = iterations, 0
            return
        self._fewest_iterations = min(self._fewest_iterations, iterations)
        self._lost_iterations += iterations - self._fewest_iterations
        if self._lost_iterations > _REFRESH_COST:
            self._factor_size = 0.0

    def linear_matrix(self, scheme: StepScheme, size: float) -> csr_array:
        """Inertia and damping that multiply the increment in the residual; kept while the step size stays."""
        if self._linear is None or self._linear[0] != size:
            values = scheme.inertia.d * self._inertia.mass_entries
            values = values + scheme.weight * scheme.velocity.d * self._damping_entries
            self._linear = size, self._pattern.symmetric_matrix(values)
        return self._linear[1]

    def refresh(self, q: Array, scheme: StepScheme, terms: _MotionTerms, size: float) -> None:
        """Factorize the symmetric part of the effective stiffness at ``q``.

        The skew parts (gyroscopic, Euler) are small against the inertia of a resolved step and are left to the
        iteration.
        """
        values = scheme.weight * self._system.tangent(q) + self.linear_matrix(scheme, size).data
        symmetric = 0.5 * (terms.displacement + terms.displacement.T)
        if symmetric.any():
            values += scheme.weight * self._inertia.entries(symmetric)
        self._factor.factorize(values)
        self._factor_size = size

    def usable_factor(self, size: float) -> bool:
        """Whether the last factors belong to this step size."""
        return self._factor.ready and self._factor_size == size

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        factors = (self._factor, self._mass_factor)
        self.statistics.factorizations = sum(factor.factorizations for factor in factors)
        self.statistics.back_substitutions = sum(factor.solves for factor in factors)


class _StepProblem:
    """Residual of one step as a function of the increment."""

    def __init__(self, stepper: Stepper, scheme: StepScheme, terms: _MotionTerms, at: MotionState, size: float) -> None:
        self._stepper, self._scheme, self._terms, self._at, self._size = stepper, scheme, terms, at, size
        self._linear = stepper.linear_matrix(scheme, size)
        inertia, velocity = scheme.inertia, scheme.velocity
        known = stepper._inertia.mass_matrix @ (inertia.v * at.v + inertia.a * at.a)
        known += scheme.weight * stepper._frame_forces(at.q, velocity.v * at.v + velocity.a * at.a, terms)
        self.history = np.zeros(0)
        if scheme.weight < 1.0:
            if at.forces is None:
                raise RuntimeError("the method needs the forces at the start of the step")
            self.history = at.forces
            known += (1.0 - scheme.weight) * at.forces
        self._known = known
        self._known_norm = float(np.linalg.norm(known))
        self._round_off = 100.0 * float(np.finfo(float).eps) / stepper.tolerance
        # Gyroscopic and K_T forces are both M(Z) times something, so one product serves the increment.
        self._turning = scheme.weight * (velocity.d * terms.velocity + terms.displacement)
        self._turns = bool(self._turning.any())
        self._load_scale = scheme.weight * float(np.linalg.norm(terms.load))
        self.scale = 0.0

    def residual(self, x: Array) -> tuple[Array, float]:
        force = self._stepper._force(self._at.q + x)
        force *= self._scheme.weight
        norm = float(np.sqrt(force @ force))
        self.scale = max(norm, self._load_scale)
        inertia = self._linear @ x
        # Inertia forces of a tiny step cancel each other; nothing below their round-off can be asked for.
        lost = self._round_off * (self._known_norm + float(np.sqrt(inertia @ inertia)))
        force += self._known
        force += inertia
        if self._turns:
            force += self._stepper._inertia.apply(self._turning, x)
        return force, max(self.scale, lost, _SCALE_FLOOR * self._stepper._largest_scale)

    def refresh(self, x: Array) -> None:
        self._stepper.refresh(self._at.q + x, self._scheme, self._terms, self._size)

    def ready(self) -> bool:
        return self._stepper.usable_factor(self._size)

    def solve(self, right: Array) -> Array:
        return self._stepper._factor.solve(right)


def _combine(c: Combination, d: Array, at: MotionState) -> Array:
    result = c.d * d
    if c.v:
        result += c.v * at.v
    if c.a:
        result += c.a * at.a
    return result
