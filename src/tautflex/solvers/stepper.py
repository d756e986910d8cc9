"""One implicit step of the equation of motion (49), with everything that can be re-used kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tautflex.mechanics.damping import Rayleigh
from tautflex.mechanics.inputs import InputSet
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.solvers.equation import EquationOfMotion, MotionState, MotionTerms
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
    inputs
        Forces, tensions and temperatures in time; None is none.
    """

    state: PrestressedState
    method: ImplicitMethod
    damping: Rayleigh
    coupling: Coupling
    tolerance: float
    max_iterations: int = 25
    inputs: InputSet | None = None

    def __post_init__(self) -> None:
        self.equation = EquationOfMotion(self.state, self.damping, self.coupling, inputs=self.inputs)
        system = self.state.system
        self._system, self._pattern, self._inertia = system, system.pattern, system.inertia
        self._factor = SymmetricFactorization(self._pattern)
        self._factor_size, self._factor_inertia = 0.0, 0.0
        self._fewest_iterations, self._lost_iterations, self._judged = 0, 0, 0
        self._memory = SecantMemory()
        self._linear: tuple[float, csr_array] | None = None
        self._largest_scale = 0.0
        unknowns = np.arange(self._pattern.size)
        self._diagonal_slots = self._pattern.slots(unknowns, unknowns)
        self._diagonal = self.state.tangent_entries[self._diagonal_slots]

    @property
    def statistics(self) -> Statistics:
        """Work done so far."""
        return self.equation.statistics

    def start(self, time: float, q: Array, v: Array, motion: RigidMotion) -> MotionState:
        """State with the acceleration that balances all forces at ``time``."""
        return self.equation.start(time, q, v, motion)

    def jump(self, at: MotionState, before: RigidMotion, after: RigidMotion) -> MotionState:
        """Same position and velocity under another rigid motion."""
        return self.equation.jump(at, before, after)

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
        instant = at.time + scheme.evaluation * size
        terms = self.equation.motion_terms(segment.motion(instant))
        self.equation.set_time(instant, segment.end)
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
            values = values + scheme.weight * scheme.velocity.d * self.equation.damping_entries
            self._linear = size, self._pattern.symmetric_matrix(values)
        return self._linear[1]

    def refresh(self, q: Array, scheme: StepScheme, terms: MotionTerms, size: float) -> None:
        """Factorize the symmetric part of the effective stiffness at ``q``.

        The skew parts (gyroscopic, Euler) are small against the inertia of a resolved step and are left to the
        iteration.
        """
        tangent = self._system.tangent(q)
        self._diagonal = tangent[self._diagonal_slots]
        values = scheme.weight * tangent + self.linear_matrix(scheme, size).data
        symmetric = 0.5 * (terms.displacement + terms.displacement.T)
        if symmetric.any():
            values += scheme.weight * self._inertia.entries(symmetric)
        self._factor.factorize(values)
        self._factor_size, self._factor_inertia = size, scheme.inertia.d

    def usable_factor(self, size: float) -> bool:
        """Whether the last factors belong to this step size."""
        return self._factor.ready and self._factor_size == size

    def smoothed(self, error: Array) -> Array:
        """Error vector without what the step could not resolve anyway, shape (size,).

        ``(c M + K)^-1 c M e`` with the factors at hand: unchanged for motion slower than the step, about zero for
        faster motion, whose accelerations would otherwise pass for displacement errors [Hairer & Wanner, Solving
        Ordinary Differential Equations II, IV.8].
        """
        if not self._factor.ready:
            return error
        return self._factor.solve(self._factor_inertia * (self._inertia.mass_matrix @ error))

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(self._factor)


class _StepProblem:
    """Residual of one step as a function of the increment."""

    def __init__(self, stepper: Stepper, scheme: StepScheme, terms: MotionTerms, at: MotionState, size: float) -> None:
        self._stepper, self._scheme, self._terms, self._at, self._size = stepper, scheme, terms, at, size
        self._linear = stepper.linear_matrix(scheme, size)
        inertia, velocity = scheme.inertia, scheme.velocity
        known = stepper._inertia.mass_matrix @ (inertia.v * at.v + inertia.a * at.a)
        known += scheme.weight * stepper.equation.frame_forces(at.q, velocity.v * at.v + velocity.a * at.a, terms)
        self.history = np.zeros(0)
        if scheme.weight < 1.0:
            if at.forces is None:
                raise RuntimeError("the method needs the forces at the start of the step")
            self.history = at.forces
            known += (1.0 - scheme.weight) * at.forces
        self._known = known
        self._known_norm = float(np.linalg.norm(known))
        self._round_off = 100.0 * float(np.finfo(float).eps) / stepper.tolerance
        # Stiff elements far from their reference position: the round-off of q alone makes forces of this size.
        self._lost_force = 0.1 * self._round_off * float(np.linalg.norm(stepper._diagonal * at.q))
        # Gyroscopic and K_T forces are both M(Z) times something, so one product serves the increment.
        self._turning = scheme.weight * (velocity.d * terms.velocity + terms.displacement)
        self._turns = bool(self._turning.any())
        self._load_scale = scheme.weight * float(np.linalg.norm(terms.load - stepper.equation.input_load))
        self.scale = 0.0

    def residual(self, x: Array) -> tuple[Array, float]:
        force = self._internal_force(x)
        force *= self._scheme.weight
        norm = float(np.sqrt(force @ force))
        self.scale = max(norm, self._load_scale)
        inertia = self._linear @ x
        # Inertia forces of a tiny step cancel each other; nothing below their round-off can be asked for.
        lost = self._round_off * (self._known_norm + float(np.sqrt(inertia @ inertia))) + self._lost_force
        force += self._known
        force += inertia
        if self._turns:
            force += self._stepper._inertia.apply(self._turning, x)
        return force, max(self.scale, lost, _SCALE_FLOOR * self._stepper._largest_scale)

    def _internal_force(self, x: Array) -> Array:
        if self._scheme.average_stress:
            return self._stepper.equation.average_force(self._at.q, self._at.q + x / self._scheme.evaluation)
        return self._stepper.equation.force(self._at.q + x)

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
