"""Minimum of a potential energy, also where Newton's tangent is singular or indefinite far from it.

Statics of wrinkling and inflated films start without transverse stiffness and pass unstable shapes on their way.
What is wanted is a minimum of the potential, so every step must lower it: the tangent is shifted until its factors
have no negative pivot, and the shift follows how well the quadratic model foretold the change (Levenberg, Marquardt).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.nonlinear.newton import relative_error

# Shifts relative to the largest diagonal entry of the tangent met so far (wrinkled film may be soft everywhere).
_RESTART, _LEAST_SHIFT, _LARGEST_SHIFT = 1e-8, 1e-14, 1e3
# Energy differences below this part of the energy's terms are round-off.
_ROUND_OFF = 1e-13


class Potential(Protocol):
    """Potential energy of the free unknowns."""

    def gradient(self, x: Array) -> tuple[Array, float, float, float]:
        """Gradient [N], potential [J], force scale [N] and sum of the sizes of the potential's terms [J]."""
        ...

    def tangent(self, x: Array) -> Array:
        """Second derivative, values in the pattern, shape (entries,)."""
        ...


@dataclass
class MinimumOutcome:
    """Result of one minimisation.

    Parameters
    ----------
    x
        Last accepted point.
    converged
        Whether the gradient's norm fell below tolerance times scale.
    history
        Norms of the gradient divided by their scales, one per accepted step.
    iterations
        Factorizations made.
    """

    x: Array
    converged: bool = False
    history: list[float] = field(default_factory=list)
    iterations: int = 0


def find_minimum(
    potential: Potential,
    pattern: SparsityPattern,
    start: Array,
    tolerance: float,
    *,
    first_shift: float = 0.0,
    floor: float = 0.0,
    max_iterations: int = 300,
) -> MinimumOutcome:
    """Go down from ``start`` to a point where the potential is stationary and its tangent has no negative pivot.

    Parameters
    ----------
    potential
        Energy, gradient and tangent.
    pattern
        Sparsity pattern of the tangent.
    start
        First point, shape (size,).
    tolerance
        Allowed ratio of gradient norm to force scale.
    first_shift
        Shift of the first step, relative to the largest diagonal entry of the tangent.
    floor
        Least shift; > 0 where the tangent stays singular in directions that do not matter.
    max_iterations
        Allowed number of factorizations.

    Returns
    -------
    MinimumOutcome
    """
    outcome, factor = MinimumOutcome(start), SymmetricFactorization(pattern)
    diagonal = pattern.diagonal
    x, shift = start, max(first_shift, floor)
    gradient, energy, scale, terms = potential.gradient(x)
    error = relative_error(float(np.linalg.norm(gradient)), scale)
    outcome.history.append(error)
    values = potential.tangent(x)
    stiffest = float(np.abs(values[diagonal]).max())
    while error > tolerance and outcome.iterations < max_iterations and shift <= _LARGEST_SHIFT:
        outcome.iterations += 1
        moved = values.copy()
        moved[diagonal] += shift * stiffest
        if not _positive(factor, moved):
            shift = max(10.0 * shift, _RESTART)
            continue
        step = -factor.solve(gradient)
        # Change foretold by the quadratic model with the true tangent.
        foretold = float(gradient @ step) + 0.5 * float(step @ (pattern.matrix(values) @ step))
        trial = potential.gradient(x + step)
        change, trial_error = trial[1] - energy, relative_error(float(np.linalg.norm(trial[0])), trial[2])
        blind = abs(foretold) <= _ROUND_OFF * max(terms, trial[3])
        if not np.isfinite(trial_error) or (change > 0.1 * foretold and not (blind and trial_error < error)):
            shift = max(4.0 * shift, _LEAST_SHIFT)
            continue
        if blind or change < 0.75 * foretold:
            shift = max(floor, 0.0 if shift <= _LEAST_SHIFT else 0.1 * shift)
        elif change > 0.25 * foretold:
            shift = 4.0 * shift
        x, (gradient, energy, scale, terms), error = x + step, trial, trial_error
        values = potential.tangent(x)
        stiffest = max(stiffest, float(np.abs(values[diagonal]).max()))
        outcome.history.append(error)
    outcome.x, outcome.converged = x, bool(error <= tolerance)
    return outcome


def _positive(factor: SymmetricFactorization, values: Array) -> bool:
    """Factorize; whether the matrix is positive definite."""
    try:
        factor.factorize(values)
    except np.linalg.LinAlgError:
        return False
    return factor.negative_pivots() == 0
