"""Stable balance of forces, also where Newton's tangent is singular or indefinite far from it.

Statics of wrinkling and inflated films start without transverse stiffness and pass unstable shapes on their way. What
is wanted is where every motion costs work, a minimum of the potential if the forces have one, so every step must go
along with them: the symmetric part of the tangent is shifted until its factors have no negative pivot, and the shift
follows how well the linear model foretold the work on the step's straight way (Levenberg, Marquardt).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from tautflex.mechanics.pattern import SparsityPattern
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.lu import general_solver
from tautflex.solvers.nonlinear.newton import NewtonOutcome

# Shifts relative to the largest diagonal entry of the tangent met so far (wrinkled film may be soft everywhere).
_RESTART, _LEAST_SHIFT = 1e-8, 1e-14


class Forces(Protocol):
    """Forces that have to balance each other."""

    def residual(self, x: Array) -> tuple[Array, float]:
        """Sum of the forces [N] and its norm over the force scale that it is measured against."""
        ...

    def tangent(self, x: Array) -> Array:
        """Derivative of the sum, values in the pattern, shape (entries,)."""
        ...


def find_minimum(
    forces: Forces,
    pattern: SparsityPattern,
    start: Array,
    tolerance: float,
    *,
    first_shift: float = 0.0,
    floor: float = 0.0,
    max_iterations: int = 300,
) -> NewtonOutcome:
    """Go down from ``start`` to a point of balance where the symmetric part of the tangent has no negative pivot.

    Parameters
    ----------
    forces
        Residual and tangent.
    pattern
        Sparsity pattern of the tangent.
    start
        First point, shape (size,).
    tolerance
        Allowed ratio of residual norm to force scale.
    first_shift
        Shift of the first step, relative to the largest diagonal entry of the tangent.
    floor
        Least shift; > 0 where the tangent stays singular in directions that do not matter.
    max_iterations
        Allowed number of factorizations.

    Returns
    -------
    NewtonOutcome
        Its iterations are the factorizations made.
    """
    outcome, factor = NewtonOutcome(start), SymmetricFactorization(pattern)
    diagonal = pattern.diagonal
    x, shift = start, max(first_shift, floor)
    residual, error = forces.residual(x)
    outcome.history.append(error)
    values = forces.tangent(x)
    stiffest = float(np.abs(values[diagonal]).max())
    while error > tolerance and outcome.iterations < max_iterations:
        outcome.iterations += 1
        if not is_positive(factor, values, shift * stiffest):
            shift = max(10.0 * shift, _RESTART)
            continue
        solve: Callable[[Array], Array] = factor.solve
        if not pattern.is_symmetric(values):
            moved = values.copy()
            moved[diagonal] += shift * stiffest
            solve = general_solver(pattern.matrix(moved))
        step = -solve(residual)
        # Change of the energy foretold with the true tangent, and found.
        foretold = float(residual @ step) + 0.5 * float(step @ (pattern.matrix(values) @ step))
        if np.array_equal(x + step, x):
            break
        trial, trial_error = forces.residual(x + step)
        middle, _ = forces.residual(x + 0.5 * step)
        # Simpson's rule is exact for the cubic forces of quadratic strains and those of pressure.
        change = float((residual + 4.0 * middle + trial) @ step) / 6.0
        if not change <= 0.1 * foretold:
            shift = max(4.0 * shift, _LEAST_SHIFT)
            continue
        if change < 0.75 * foretold:
            shift = max(floor, 0.0 if shift <= _LEAST_SHIFT else 0.1 * shift)
        elif change > 0.25 * foretold:
            shift = 4.0 * shift
        x, residual, error = x + step, trial, trial_error
        values = forces.tangent(x)
        stiffest = max(stiffest, float(np.abs(values[diagonal]).max()))
        outcome.history.append(error)
    outcome.x, outcome.residual, outcome.converged = x, residual, bool(error <= tolerance)
    return outcome


def is_positive(factor: SymmetricFactorization, values: Array, shift: float = 0.0) -> bool:
    """Factorize the symmetric part of a matrix, its diagonal shifted; whether it is positive definite."""
    moved = 0.5 * (values + values[factor.pattern.transpose_slots])
    moved[factor.pattern.diagonal] += shift
    try:
        factor.factorize(moved)
    except np.linalg.LinAlgError:
        return False
    return factor.negative_pivots() == 0
