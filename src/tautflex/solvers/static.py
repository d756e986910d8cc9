"""Static equilibrium, in particular the steady spinning start of a maneuver."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import NotConvergedError
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.solvers.linear import SymmetricFactorization
from tautflex.solvers.newton import solve_newton

if TYPE_CHECKING:
    from tautflex.solvers.prestress import PrestressedState

Array = NDArray[np.float64]


class _StaticProblem:
    """Residual ``f_int(q) - f_ref + K_T q + load`` with K_T given by its values in the pattern."""

    def __init__(self, state: PrestressedState, load: Array, extra: Array | None = None) -> None:
        self._state, self._load = state, load
        pattern = state.system.pattern
        self._extra = None if extra is None else pattern.matrix(extra)
        self._symmetric = None if extra is None else 0.5 * (extra + extra[pattern.transpose_slots])
        self._factor = SymmetricFactorization(pattern)

    def residual(self, x: Array) -> tuple[Array, float]:
        force, _ = self._state.system.force(x)
        force -= self._state.reference_force
        total = force + self._load
        if self._extra is not None:
            total += self._extra @ x
        scale = max(float(np.linalg.norm(self._load)), float(np.linalg.norm(force)))
        return total, scale

    def refresh(self, x: Array) -> None:
        values = self._state.system.tangent(x)
        self._factor.factorize(values if self._symmetric is None else values + self._symmetric)

    def ready(self) -> bool:
        return self._factor.ready

    def solve(self, right: Array) -> Array:
        return self._factor.solve(right)


def solve_static(state: PrestressedState, load: Array, extra: Array | None = None, tolerance: float = 1e-9) -> Array:
    """Nonlinear static equilibrium ``f_int(q) - f_ref + K_T q + load = 0``.

    Parameters
    ----------
    state
        Prestressed state.
    load
        Load on the left-hand side (its negative acts on the structure) [N, N m], shape (size,).
    extra
        Values of an additional stiffness K_T in the pattern, shape (entries,).
    tolerance
        Allowed ratio of residual norm to load norm.

    Returns
    -------
    numpy.ndarray
        Free unknowns [m, rad], shape (size,).

    Raises
    ------
    NotConvergedError
        If Newton's method fails.
    """
    problem = _StaticProblem(state, load, extra)
    try:
        outcome = solve_newton(problem, np.zeros(state.system.size), tolerance)
    except np.linalg.LinAlgError as error:
        raise NotConvergedError(f"static equilibrium: {error}; check supports and pretension") from error
    if not outcome.converged:
        raise NotConvergedError(
            f"static equilibrium: residual {outcome.history[-1]:.2e} of the load after {outcome.iterations} "
            "iterations; reduce the load (angular rate) or raise the pretension",
            history=tuple(outcome.history),
        )
    return outcome.x


def spinning_equilibrium(state: PrestressedState, motion: RigidMotion, coupling: Coupling) -> Array:
    """Steady equilibrium in a frame that moves with constant ``motion`` [theory.md 4], shape (size,)."""
    inertia = state.system.inertia
    load = coupling.load(motion, inertia)
    weight = coupling.displacement_weight(motion)
    if not load.any() and not weight.any():
        return np.zeros(state.system.size)
    return solve_static(state, load, inertia.entries(weight) if weight.any() else None)
