"""One implicit step of an equation of motion, with everything that can be re-used kept."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tautflex.motion.kinematics import Segment
from tautflex.numeric import Array, Indices
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.low_rank import LowRankUpdate
from tautflex.solvers.nonlinear.anderson import AndersonAcceleration
from tautflex.solvers.nonlinear.newton import NewtonOutcome, relative_error, solve_newton
from tautflex.solvers.remembering import Memory, Remembering
from tautflex.solvers.transient.corotation import Corotation, still
from tautflex.solvers.transient.equation import EquationOfMotion, StepForces, StepNumbers
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.state import MotionState, Resolved
from tautflex.solvers.transient.step_kernel import first_guess

# The force scale of a step never falls below this part of the largest one met so far: after the motion has died
# away there is nothing to resolve at full relative accuracy.
_SCALE_FLOOR = 1e-3
# Iterations lost to an old factorization, summed over steps, that pay for a new one (measured: 40x20 film and antenna),
# where tangents turn with the structure and where they do not.
_REFRESH_COST, _REFRESH_COST_UNTURNED = 20, 12
_NONE = np.zeros(0)
_ROUND_OFF = 100.0 * float(np.finfo(float).eps)
_MANY = 2**62  # more than any number of iterations


class Stepper(Remembering):
    """Implicit steps of one run.

    Parameters
    ----------
    equation
        Equation of motion.
    method
        Integrator.
    tolerance
        Newton tolerance: residual norm over force scale.
    max_iterations
        Newton steps allowed in one step.
    """

    MEMORY = (
        "factor", "solver", "_factor_size", "_factor_inertia", "_fewest_iterations", "_lost_iterations", "_corotation",
        "_memory", "_largest_scale", "_met_forces", "_diagonal",
    )  # fmt: skip

    def __init__(self, equation: EquationOfMotion, method: Method, tolerance: float, max_iterations: int = 25) -> None:
        self.equation, self.method, self.tolerance, self._max_iterations = equation, method, tolerance, max_iterations
        self._pattern = equation.system.pattern
        self.factor = SymmetricFactorization(self._pattern)
        self.solver = LowRankUpdate(self.factor)
        self._factor_size, self._factor_inertia = 0.0, 0.0
        self._fewest_iterations, self._lost_iterations, self._judged = 0, 0, 0
        # Tangents that do not turn keep linear momentum to round-off at any tolerance, as conserving methods should.
        self._corotation = None if method.average_stress else Corotation(equation.system)
        self._refresh_cost = _REFRESH_COST_UNTURNED if self._corotation is None else _REFRESH_COST
        self._memory = AndersonAcceleration(axes=self._corotation)
        self._numbers: dict[int, tuple[float, StepNumbers]] = {}
        self._largest_scale, self._met_forces = 0.0, 0.0
        self._renewed: tuple[Any, ...] | None = None
        self._diagonal = equation.state.tangent_entries[self._pattern.diagonal]

    def recall(self, memory: Memory) -> None:
        """Go on with the kept tangent of another stepper of this method."""
        super().recall(memory)
        self._judged = self.factor.factorizations

    def step(
        self,
        at: MotionState,
        size: float,
        segment: Segment,
        place: int = 0,
        recalled: Array | None = None,
    ) -> tuple[MotionState, NewtonOutcome]:
        """Advance by one stage of a step inside one smooth segment; a method of one stage is done then.

        Parameters
        ----------
        at
            Start of the stage.
        size
            Size of the whole step [s].
        segment
            Stretch of the maneuver; evaluated at the stage's evaluation instant.
        place
            Number of the stage.
        recalled
            What the stage takes for velocity and acceleration at its start, shape (2, size), see `Stage`; None: those
            of ``at``.

        Returns
        -------
        tuple
            The state at the end of the stage (its start unless converged) and the Newton outcome.
        """
        numbers, statistics = self.numbers(size, place), self.equation.statistics
        part = numbers.share * size
        start = at if recalled is None else replace(at, v=recalled[0], a=recalled[1])
        forces = self.equation.step_forces(numbers, start, part, segment, self._diagonal)
        problem = _StepProblem(self, forces, size)
        guess = first_guess(numbers.scheme.evaluation * part, at.v, at.a, _NONE if at.jerk is None else at.jerk)
        if self._corotation is not None:
            self._corotation.follow(at.q + guess, numbers.turning_share)
        outcome = solve_newton(problem, guess, self.tolerance, self._max_iterations, self._memory)
        statistics.iterations += outcome.iterations
        statistics.force_evaluations += len(outcome.history)
        self._judge_factor(outcome.iterations)
        if not outcome.converged:
            return at, outcome
        self._largest_scale = max(self._largest_scale, problem.scale)
        end = forces.end(outcome.x, outcome.residual)
        if recalled is not None:
            end.jerk = (end.a - at.a) / part
        return end, outcome

    def _judge_factor(self, iterations: int) -> None:
        """Drop the factorization once the iterations that its age cost would have paid for a new one."""
        if self._judged != self.factor.factorizations:
            self._judged = self.factor.factorizations
            self._fewest_iterations, self._lost_iterations = iterations, 0
            return
        self._fewest_iterations = min(self._fewest_iterations, iterations)
        self._lost_iterations += iterations - self._fewest_iterations
        self._give_up_factor()

    def _give_up_factor(self) -> None:
        if self._lost_iterations > self._refresh_cost:
            self._factor_size = 0.0

    def numbers(self, size: float, place: int = 0) -> StepNumbers:
        """What a stage knows from the step size alone; kept while it stays."""
        if self._numbers.get(place, (0.0,))[0] != size:
            self._numbers[place] = size, StepNumbers(self.method.stages(size)[place], self.equation)
        return self._numbers[place][1]

    def refresh(self, forces: StepForces, x: Array, size: float) -> None:
        """Factorize the symmetric part of the effective stiffness at an increment.

        The skew parts (gyroscopic, Euler) and forces that follow the motion are small against the inertia of a
        resolved step and are left to the iteration.
        """
        equation, numbers, q = self.equation, forces.numbers, forces.at.q + x
        self._met_forces = float(np.linalg.norm(equation.workspace.force_sizes(q)))
        values = equation.workspace.upper_tangent(q, forces.at.q if numbers.scheme.average_stress else _NONE)
        self._diagonal = values[self._pattern.upper_diagonal]
        if numbers.scheme.weight != 1.0:
            values *= numbers.scheme.weight
        values += numbers.constant_stiffness
        symmetric = 0.5 * (forces.displacement + forces.displacement.T)
        if symmetric.any():
            values += numbers.scheme.weight * equation.inertia.entries(symmetric)[self._pattern.upper[0]]
        self.factor.factorize_upper(values)
        self.solver.correct(*equation.correction(q, numbers.scheme))
        self._factor_size, self._factor_inertia = size, numbers.scheme.inertia.d
        if self._corotation is not None:
            self._corotation.restart(q)

    def prepare(self, at: MotionState, size: float, segment: Segment, place: int = 0) -> None:
        """Factorize the tangent of a step from a state unless there is one, for `resolved` alone: steps make theirs."""
        if not self.factor.ready:
            numbers = self.numbers(size, place)
            forces = self.equation.step_forces(numbers, at, numbers.share * size, segment, self._diagonal)
            self.refresh(forces, np.zeros_like(at.q), size)
            self._factor_size = 0.0

    def usable_factor(self, size: float) -> bool:
        """Whether the last factors belong to this step size."""
        return self.factor.ready and self._factor_size == size

    @property
    def only(self) -> Stepper:
        """The stepper itself, see `StagedStepper`."""
        return self

    def tangent(self, at: MotionState, size: float, segment: Segment) -> tuple[Any, ...] | None:
        """Tangent, axes, pairs, limits, counts and scales of `take_steps`, a new one if the step from here begins so.

        None where such steps cannot be taken with it.
        """
        before, self._renewed = (self._diagonal, self._met_forces), None
        if not self.usable_factor(size) and self.factor.ready and self.factor.parts is not None:
            self._renew(at, size, segment)
        factors = self.factor.parts if self.usable_factor(size) else None
        if factors is None:
            self._undo()
            return None
        unknowns = len(self._diagonal)
        pairs = self._memory.parts(unknowns)
        axes = still(unknowns) if self._corotation is None else self._corotation.parts
        round_off = _ROUND_OFF / self.tolerance
        limits = self.tolerance, self._max_iterations, round_off, self._met_forces, _SCALE_FLOOR, self._refresh_cost
        counts = np.array([self._memory.learned, self._fewest_iterations, self._lost_iterations, 0, 0, 0])
        diagonals = np.array([before[0], self._diagonal])
        return (
            (*factors, diagonals, self._factor_inertia, *self.solver.parts), axes, pairs, limits, counts,
            np.array([self._largest_scale, before[1]]),
        )  # fmt: skip

    def _renew(self, at: MotionState, size: float, segment: Segment) -> None:
        """Factorize at the first guess of a step if that is not balanced, as the step would."""
        numbers, factor = self.numbers(size), self.factor
        part = numbers.share * size
        guess = first_guess(numbers.scheme.evaluation * part, at.v, at.a, _NONE if at.jerk is None else at.jerk)
        try:
            problem = _StepProblem(self, self.equation.step_forces(numbers, at, part, segment, self._diagonal), size)
            if self.tolerance < problem.residual(guess)[1] < np.inf:
                self._renewed = self._diagonal, self._met_forces, self._judged, factor.factorizations, factor.solves
                problem.refresh(guess)
        except (np.linalg.LinAlgError, FloatingPointError):  # the driver's to meet
            self._undo()
        if self._renewed is not None:
            self._memory.clear()
            self._judged, self._fewest_iterations, self._lost_iterations = factor.factorizations, _MANY, 0

    def _undo(self) -> None:
        """Leave the tangent of `_renew` to the step itself."""
        if self._renewed is not None:
            self._diagonal, self._met_forces, self._judged, *counts = self._renewed
            self.factor.factorizations, self.factor.solves = counts
            self._factor_size, self._renewed = 0.0, None

    def took(self, steps: int, counts: Indices, scales: Array) -> bool:
        """Take up what `take_steps` has left in the counts and scales of `tangent`.

        Whether the next step is one that it cannot take.
        """
        learned, self._fewest_iterations, self._lost_iterations, iterations, evaluations, solves = counts.tolist()
        self._memory.learned, self._largest_scale = learned, float(scales[0])
        self._give_up_factor()
        if not steps:
            self._undo()
        statistics = self.equation.statistics
        statistics.steps += steps
        statistics.iterations += iterations
        statistics.force_evaluations += evaluations
        self.factor.solves += solves
        return not steps or self._factor_size > 0.0

    def resolved(self, end: MotionState, error: Array) -> Array:
        """Part of a vector that the step to ``end`` resolves, shape (size,).

        It goes through ``(c M + K)^-1 c M`` with the factors at hand: unchanged for motion slower than the
        step, about zero for faster motion, whose accelerations would otherwise pass for displacement errors [Hairer &
        Wanner, Solving Ordinary Differential Equations II, IV.8].
        """
        if not self.factor.ready:
            return error
        return self.solver.solve(self._factor_inertia * self.equation.mobile_mass(end, error))

    @property
    def dulling(self) -> Resolved | None:
        """What takes the edge off stresses that jump; None where the method does not overshoot in what it leaves out.

        Forces weighed at both ends of a step, or beyond it, overshoot by ``(w h)^2`` where w is far beyond the step.
        """
        schemes = [stage.scheme for stage in self.method.stages(1.0)]
        return self.resolved if any(one.weight < 1.0 or one.evaluation > 1.0 for one in schemes) else None

    def collect_counts(self) -> None:
        """Bring the solvers' counters into the statistics."""
        self.equation.count(self.factor)


class _StepProblem:
    """A step's forces against the scale that they are measured by."""

    def __init__(self, stepper: Stepper, forces: StepForces, size: float) -> None:
        self._stepper, self._forces, self._size = stepper, forces, size
        round_off = _ROUND_OFF / stepper.tolerance
        # Inertia forces of a tiny step cancel each other; nothing below their round-off can be asked for. Stiff
        # elements far from their reference position: the round-off of q alone makes forces of this size.
        self._round_off, self._lost = round_off, round_off * (forces.known_norm + 0.1 * forces.stiff_norm)
        self._least_scale = _SCALE_FLOOR * stepper._largest_scale
        self.scale = 0.0

    def residual(self, x: Array) -> tuple[Array, float]:
        residual, norm, self.scale, inertia = self._forces.residual(x)
        # Taut elements pull at their nodes from all sides, and what is left may be far below the last place of each.
        lost = self._lost + self._round_off * (inertia + 0.02 * self._stepper._met_forces)
        return residual, relative_error(norm, max(self.scale, lost, self._least_scale))

    def refresh(self, x: Array) -> None:
        self._stepper.refresh(self._forces, x, self._size)

    def ready(self) -> bool:
        return self._stepper.usable_factor(self._size)

    def solve(self, right: Array) -> Array:
        return self._stepper.solver.solve(right)
