"""Newton's method with line search and a tangent that is re-used while it serves."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from tautflex.numeric import Array
from tautflex.solvers.nonlinear.anderson import AndersonAcceleration

# A slower old tangent is given up. A refactorization costs nine iterations (40x20 film), but a rate is a pessimistic
# guess while Anderson acceleration learns; the first one of a step tells nothing about the next ones at all.
PATIENCE = 20
SLOPE_ACCEPTED = 0.9


class NonlinearProblem(Protocol):
    """Residual and approximate tangent of ``residual(x) = 0``."""

    def residual(self, x: Array) -> tuple[Array, float]:
        """Residual [N] and its norm over the force scale that it is measured against, see `relative_error`."""
        ...

    def solve(self, right: Array) -> Array:
        """Apply the inverse of the current tangent."""
        ...

    def refresh(self, x: Array) -> None:
        """Factorize the tangent at ``x``."""
        ...

    def ready(self) -> bool:
        """Whether a factorized tangent, perhaps of an earlier point, is at hand."""
        ...


@dataclass
class NewtonOutcome:
    """Result of one solution.

    Parameters
    ----------
    x
        Last iterate.
    converged
        Whether the residual norm fell below tolerance times scale.
    residual
        Residual at ``x`` [N].
    history
        Relative errors, one per evaluation.
    iterations
        Number of back-substitutions that made a step.
    """

    x: Array
    converged: bool = False
    residual: Array = field(default_factory=lambda: np.zeros(0))
    history: list[float] = field(default_factory=list)
    iterations: int = 0


def relative_error(norm: float, scale: float) -> float:
    """Norm of a residual over its force scale; zero forces are in balance whatever the scale."""
    if norm == 0.0:
        return 0.0
    return norm / scale if 0.0 < scale < math.inf else math.inf


def solve_newton(
    problem: NonlinearProblem,
    start: Array,
    tolerance: float,
    max_iterations: int = 40,
    memory: AndersonAcceleration | None = None,
) -> NewtonOutcome:
    """Solve ``residual(x) = 0``.

    Every step is judged by the slope of the potential along it, ``step . residual``: if that does not fall, an old
    tangent is refreshed at once, and a fresh one is followed by a secant line search. A converging but slow old
    tangent is refreshed when, from its second step on, it would need more than `PATIENCE` further iterations.

    Parameters
    ----------
    problem
        Residual, scale and tangent.
    start
        First iterate.
    tolerance
        Allowed ratio of residual norm to force scale.
    max_iterations
        Allowed number of steps.
    memory
        Pairs seen since the current factorization, used and extended; None for plain steps.

    Returns
    -------
    NewtonOutcome
    """
    memory = memory if memory is not None else AndersonAcceleration(0)
    memory.begin()
    outcome = NewtonOutcome(start)
    x = start
    residual, error = _measure(problem, x, outcome)
    fresh = False

    def refresh() -> None:
        nonlocal fresh
        problem.refresh(x)
        memory.clear()
        fresh = True

    while error > tolerance and outcome.iterations < max_iterations and math.isfinite(error):
        if not (fresh or problem.ready()):
            refresh()
        step, slope = memory.propose(problem.solve, residual)
        outcome.iterations += 1
        end = x + step
        trial, trial_error = _measure(problem, end, outcome)
        # A tiny residual may bounce at round-off level, where slopes mean nothing.
        good = trial_error <= tolerance or abs(float(step @ trial)) <= SLOPE_ACCEPTED * abs(slope)
        if not good and not fresh:
            refresh()
            continue
        if not good:
            fraction, trial, trial_error = _line_search(problem, x, step, slope, trial, outcome)
            memory.shorten(fraction)
            end = x + fraction * step
        patience = PATIENCE if outcome.iterations > 1 or trial_error >= error else math.inf
        slow = _iterations_left(error, trial_error, tolerance) > patience
        x, residual, error = end, trial, trial_error
        fresh = False
        if slow and error > tolerance and math.isfinite(error):
            refresh()
    outcome.x, outcome.residual, outcome.converged = x, residual, bool(error <= tolerance)
    return outcome


def _measure(problem: NonlinearProblem, x: Array, outcome: NewtonOutcome) -> tuple[Array, float]:
    residual, error = problem.residual(x)
    outcome.history.append(error)
    return residual, error


def _iterations_left(before: float, after: float, tolerance: float) -> float:
    """Further iterations at the observed linear rate."""
    if after <= tolerance:
        return 0.0
    if not after < before:
        return math.inf
    return math.log(after / tolerance) / math.log(before / after)


def _line_search(
    problem: NonlinearProblem, x: Array, step: Array, slope: float, full: Array, outcome: NewtonOutcome
) -> tuple[float, Array, float]:
    """Fraction of ``step`` where the potential's slope has fallen to half, by safeguarded secants."""
    low, low_slope = 0.0, slope
    high, high_slope = 1.0, float(step @ full)
    fraction, residual, error = 1.0, full, outcome.history[-1]
    for _ in range(8):
        if np.isfinite(high_slope) and high_slope != low_slope:
            guess = low - low_slope * (high - low) / (high_slope - low_slope)
        else:
            guess = low
        fraction = min(max(guess, low + 0.1 * (high - low)), high - 0.1 * (high - low))
        residual, error = _measure(problem, x + fraction * step, outcome)
        here = float(step @ residual)
        if np.isfinite(here) and abs(here) <= 0.5 * abs(slope):
            break
        if np.isfinite(here) and np.sign(here) == np.sign(slope):
            low, low_slope = fraction, here
        else:
            high, high_slope = fraction, here
    return fraction, residual, error
