"""Static equilibrium under dead loads, steady rotation and follower pressure."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import NotConvergedError
from tautflex.mechanics.loads.pressure import PressureLoad, nodal_load
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.nonlinear.minimum import find_minimum
from tautflex.solvers.nonlinear.newton import relative_error, solve_newton
from tautflex.solvers.static.prestress import PrestressedState, require_state
from tautflex.solvers.static.tensioning import largest_force

# First shift of a descent that starts without transverse stiffness; steps of the order of the final deflection.
_SOFT_START = 1e-4


class _StaticProblem:
    """Residual ``f_int(q) - f_ref + K_T q + load - f_pressure(q)`` and the potential it is the gradient of.

    K_T is symmetric, as it is in steady rotation.
    """

    def __init__(
        self,
        state: PrestressedState,
        load: Array,
        extra: Array | None,
        pressure: PressureLoad | None,
        tolerance: float,
    ) -> None:
        self._state, self._load, self._pressure, self._share = state, load, pressure, 1.0
        self._workspace = state.system.workspace()
        pattern = state.system.pattern
        self._symmetric = None if extra is None else 0.5 * (extra + extra[pattern.transpose_slots])
        self._extra = None if self._symmetric is None else pattern.symmetric_matrix(self._symmetric)
        self._factor = SymmetricFactorization(pattern)
        self._first_scale: float | None = None
        # Element forces of the prestress cancel each other; nothing below their round-off can be asked for.
        force = largest_force(state.system, state.stress)
        self._round_off = 4.0 * float(np.finfo(float).eps * np.sqrt(state.system.size)) * force / tolerance

    def set_share(self, share: float) -> None:
        """Apply this share of load and pressure."""
        self._share = share

    def gradient(self, x: Array) -> tuple[Array, float, float, float]:
        """Gradient [N], potential [J], force scale [N] and size of the potential's terms [J]."""
        force, energy = self._workspace.force(x)
        force -= self._state.reference_force
        load = self._share * self._load
        terms = [energy - float(self._state.reference_force @ x), float(load @ x)]
        total, scale = force + load, max(float(np.linalg.norm(load)), float(np.linalg.norm(force)))
        if self._extra is not None:
            turning = self._extra @ x
            terms.append(0.5 * float(turning @ x))
            total += turning
        if self._pressure is not None:
            push = self._share * self._pressure.force(x)
            terms.append(-self._share * self._pressure.work(x))
            total -= push
            scale = max(scale, float(np.linalg.norm(push)))
        if self._first_scale is None:
            # A given stress that relaxes has no load to be measured against but its own imbalance.
            self._first_scale = float(np.linalg.norm(total))
        scale = max(scale, self._first_scale, self._round_off)
        return total, sum(terms), scale, sum(abs(term) for term in terms)

    def tangent(self, x: Array) -> Array:
        """Derivative of the gradient, values in the pattern."""
        values = self._workspace.tangent(x)
        if self._symmetric is not None:
            values = values + self._symmetric
        if self._pressure is not None:
            values = values - self._share * self._pressure.tangent(x)
        return values

    def residual(self, x: Array) -> tuple[Array, float]:
        total, _, scale, _ = self.gradient(x)
        return total, relative_error(float(np.linalg.norm(total)), scale)

    def refresh(self, x: Array) -> None:
        self._factor.factorize(self.tangent(x))

    def ready(self) -> bool:
        return self._factor.ready

    def solve(self, right: Array) -> Array:
        return self._factor.solve(right)


def solve_static(
    state: PrestressedState,
    load: Array | None = None,
    extra: Array | None = None,
    tolerance: float = 1e-9,
    *,
    forces: ArrayLike | None = None,
    pressure: PressureLoad | None = None,
    steps: int = 1,
    start: Array | None = None,
) -> Array:
    """Nonlinear static equilibrium ``f_int(q) - f_ref + K_T q + load - f_pressure(q) = 0``.

    Parameters
    ----------
    state
        Prestressed state.
    load
        Load on the left-hand side (its negative acts on the structure) [N, N m], shape (size,); None is none.
    extra
        Values of an additional symmetric stiffness K_T in the pattern, shape (entries,).
    tolerance
        Allowed ratio of residual norm to load norm.
    forces
        Dead forces that act on the nodes [N], shape (node, 3); None is none.
    pressure
        Follower pressure on the film.
    steps
        Equal steps in which load, forces and pressure are applied.
    start
        First guess [m, rad], shape (size,); None is the reference.

    Returns
    -------
    numpy.ndarray
        Free unknowns [m, rad], shape (size,); ``state.system.translations`` makes displacements of the nodes of them.

    Raises
    ------
    InputError
        If ``forces`` has the wrong shape or ``steps`` is no whole number of at least 1.
    NotConvergedError
        If no equilibrium is found.

    Notes
    -----
    Newton's method is tried first; where it fails, and always under pressure, the equilibrium is sought as a minimum
    of the potential, which also finds inflated and wrinkled shapes from a flat film without tension.
    """
    require_state(state)
    system = state.system
    checks.whole("steps", steps, 1)
    checks.positive("tolerance", tolerance)
    pressure = checks.instance(
        "pressure", pressure, (PressureLoad, type(None)), "a load on a state", remedy="write PressureLoad(state, 1.0)"
    )
    dead = np.zeros(system.size) if load is None else checks.float_array("load", load, (system.size,))
    if extra is not None:
        extra = checks.float_array("extra", extra, (system.pattern.entries,))
    if forces is not None:
        dead = dead - nodal_load(system, forces)
    problem = _StaticProblem(state, dead, extra, pressure, tolerance)
    x = np.zeros(system.size) if start is None else checks.float_array("start", start, (system.size,))
    for step in range(1, steps + 1):
        problem.set_share(step / steps)
        x = _solve(problem, state, x, tolerance, inflate=pressure is not None)
    return x


def _solve(problem: _StaticProblem, state: PrestressedState, start: Array, tolerance: float, inflate: bool) -> Array:
    if not inflate:
        try:
            outcome = solve_newton(problem, start, tolerance)
            if outcome.converged:
                return outcome.x
        except np.linalg.LinAlgError:
            pass  # a singular tangent is what the descent is for
    descent = find_minimum(problem, state.system.pattern, start, tolerance, first_shift=_SOFT_START)
    if not descent.converged:
        raise NotConvergedError(
            f"static equilibrium: residual {descent.history[-1]:.2e} of the load after {descent.iterations} "
            "factorizations; reduce the load (angular rate, pressure), raise the pretension, or check the supports",
            history=tuple(descent.history),
        )
    return descent.x


def spinning_equilibrium(state: PrestressedState, motion: RigidMotion, coupling: Coupling) -> Array:
    """Steady equilibrium in a frame that moves with constant ``motion`` [theory.md 4], shape (size,)."""
    inertia = state.system.inertia
    load = coupling.load(motion, inertia)
    weight = coupling.displacement_weight(motion)
    if not load.any() and not weight.any():
        return np.zeros(state.system.size)
    return solve_static(state, load, inertia.entries(weight) if weight.any() else None)
