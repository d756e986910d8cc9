"""One implicit step of the equation of motion (49), with everything that can be re-used kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.nonlinear.anderson import AndersonAcceleration
from tautflex.solvers.nonlinear.newton import NewtonOutcome, relative_error, solve_newton
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.corotation import Corotation
from tautflex.solvers.transient.equation import EquationOfMotion, MotionState, MotionTerms
from tautflex.solvers.transient.methods.scheme import Combination, ImplicitMethod, StepScheme
from tautflex.solvers.transient.status import Statistics
from tautflex.solvers.transient.step_kernel import (
    assemble_residual,
    begin_step,
    end_of_step,
    first_guess,
    step_residual,
)

Array = NDArray[np.float64]

# The force scale of a step never falls below this part of the largest one met so far: after the motion has died
# away there is nothing to resolve at full relative accuracy.
_SCALE_FLOOR = 1e-3
# Iterations lost to an old factorization, summed over steps, that pay for a new one (measured: 40x20 film and antenna),
# where tangents turn with the structure and where they do not.
_REFRESH_COST, _REFRESH_COST_UNTURNED = 20, 12
_NONE = np.zeros(0)
_ROUND_OFF = 100.0 * float(np.finfo(float).eps)


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
        # Tangents that do not turn keep linear momentum to round-off at any tolerance, as conserving methods should.
        self._corotation = None if self.method.scheme(1.0).average_stress else Corotation(system)
        self._refresh_cost = _REFRESH_COST_UNTURNED if self._corotation is None else _REFRESH_COST
        self._memory = AndersonAcceleration(axes=self._corotation)
        self._scheme: tuple[float, _Coefficients] | None = None
        self._largest_scale = 0.0
        self._diagonal = self.state.tangent_entries[self._pattern.diagonal]

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
        coefficients = self.coefficients(size)
        scheme = coefficients.scheme
        instant = at.time + scheme.evaluation * size
        terms = self.equation.motion_terms(segment.motion(instant))
        self.equation.set_time(instant, segment.end)
        problem = _StepProblem(self, coefficients, terms, at, size)
        guess = first_guess(scheme.evaluation * size, at.v, at.a, _NONE if at.jerk is None else at.jerk)
        if self._corotation is not None:
            self._corotation.follow(at.q + guess, coefficients.turning_share)
        outcome = solve_newton(problem, guess, self.tolerance, self.max_iterations, self._memory)
        self.statistics.iterations += outcome.iterations
        self.statistics.force_evaluations += len(outcome.history)
        q, v, a, jerk = end_of_step(coefficients.end, size, outcome.x, at.q, at.v, at.a)
        end = MotionState(at.time + size, q, v, a, jerk=jerk)
        if scheme.weight < 1.0 and outcome.converged:
            inertia_force = self.equation.products.mass_product(_combine(scheme.inertia, outcome.x, at))
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
        if self._lost_iterations > self._refresh_cost:
            self._factor_size = 0.0

    def coefficients(self, size: float) -> _Coefficients:
        """What follows from the step size alone; kept while it stays."""
        if self._scheme is None or self._scheme[0] != size:
            self._scheme = size, _Coefficients(self.method.scheme(size), self.equation)
        return self._scheme[1]

    def refresh(self, q: Array, scheme: StepScheme, terms: MotionTerms, size: float) -> None:
        """Factorize the symmetric part of the effective stiffness at ``q``.

        The skew parts (gyroscopic, Euler) are small against the inertia of a resolved step and are left to the
        iteration.
        """
        values = self._system.upper_tangent(q)
        self._diagonal = values[self._pattern.upper_diagonal]
        if scheme.weight != 1.0:
            values *= scheme.weight
        values += self.coefficients(size).constant_stiffness
        symmetric = 0.5 * (terms.displacement + terms.displacement.T)
        if symmetric.any():
            values += scheme.weight * self._inertia.entries(symmetric)[self._pattern.upper[0]]
        self._factor.factorize_upper(values)
        self._factor_size, self._factor_inertia = size, scheme.inertia.d
        if self._corotation is not None:
            self._corotation.restart(q)

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
        return self._factor.solve(self._factor_inertia * self.equation.products.mass_product(error))

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(self._factor)


class _Coefficients:
    """Scheme of one step size as compiled code reads it."""

    def __init__(self, scheme: StepScheme, equation: EquationOfMotion) -> None:
        self.scheme = scheme
        # Damping in proportion to stiffness resists in the axes of the reference: it does not turn with the structure.
        self.turning_share = 1.0 / (1.0 + scheme.velocity.d * equation.damping.beta)
        ends = (scheme.end_displacement, scheme.end_velocity, scheme.end_acceleration)
        self.end = np.array([(part.d, part.v, part.a) for part in ends])
        inertia, velocity = scheme.inertia, scheme.velocity
        self.known = np.array([scheme.weight, inertia.v, inertia.a, velocity.v, velocity.a, velocity.d])
        self.linear = equation.products.combined(inertia.d, scheme.weight * velocity.d)
        # The same in the pattern's upper triangle, for the effective stiffness.
        constant = inertia.d * equation.inertia.mass_entries
        if equation.products.damped:
            constant += scheme.weight * velocity.d * equation.damping_entries
        self.constant_stiffness = constant[equation.system.pattern.upper[0]]


class _StepProblem:
    """Residual of one step as a function of the increment."""

    def __init__(
        self, stepper: Stepper, coefficients: _Coefficients, terms: MotionTerms, at: MotionState, size: float
    ) -> None:
        self._stepper, self._at, self._size, self._terms = stepper, at, size, terms
        self._scheme = scheme = coefficients.scheme
        equation, pairs = stepper.equation, stepper._inertia.pairs
        products = equation.products
        load = terms.load - equation.input_load if equation.inputs else terms.load
        known, turning, known_norm, load_norm, stiff_norm = begin_step(
            products.start, products.column, products.mass, products.damping, products.damped, pairs,
            coefficients.known, terms.velocity, terms.displacement, load, stepper._diagonal, at.q, at.v, at.a,
        )  # fmt: skip
        self.history = _NONE
        if scheme.weight < 1.0:
            if at.forces is None:
                raise RuntimeError("the method needs the forces at the start of the step")
            self.history = at.forces
            known += (1.0 - scheme.weight) * at.forces
            known_norm = float(np.linalg.norm(known))
        round_off = _ROUND_OFF / stepper.tolerance
        # Inertia forces of a tiny step cancel each other; nothing below their round-off can be asked for. Stiff
        # elements far from their reference position: the round-off of q alone makes forces of this size.
        self._round_off, self._lost = round_off, round_off * (known_norm + 0.1 * stiff_norm)
        self._least_scale, self._load_scale = _SCALE_FLOOR * stepper._largest_scale, load_norm
        self._fixed: Any = (
            products.start, products.column, coefficients.linear, pairs, turning, scheme.weight,
            stepper.state.reference_force, known,
        )  # fmt: skip
        self._forces: Any = stepper._system.store, stepper._system.stresses
        self.scale = 0.0

    def residual(self, x: Array) -> tuple[Array, float]:
        if self._scheme.average_stress:
            start = self._at.q
            force = self._stepper._system.average_force(start, start + x / self._scheme.evaluation)
            residual, norm, internal, inertia = assemble_residual(x, force, *self._fixed)
        else:
            residual, norm, internal, inertia = step_residual(x, self._at.q, *self._forces, *self._fixed)
        self.scale = max(internal, self._load_scale)
        lost = self._lost + self._round_off * inertia
        return residual, relative_error(norm, max(self.scale, lost, self._least_scale))

    def refresh(self, x: Array) -> None:
        self._stepper.refresh(self._at.q + x, self._scheme, self._terms, self._size)

    def ready(self) -> bool:
        return self._stepper.usable_factor(self._size)

    def solve(self, right: Array) -> Array:
        return self._stepper._factor.solve(right)


def _combine(c: Combination, d: Array, at: MotionState) -> Array:
    return c.d * d + c.v * at.v + c.a * at.a
