"""Forces of a structure at rest: their sum, its derivative, and how much of the sum is round-off."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from tautflex.elements import ElementBlock
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.linear.lu import general_solver
from tautflex.solvers.nonlinear.minimum import is_positive
from tautflex.solvers.nonlinear.newton import relative_error, solve_newton

# Of the largest entry: stiffness that counts as none.
_SINGULAR = 1e-13
_ROUND_OFF = 4.0 * float(np.finfo(float).eps)


class StaticResidual:
    """``f_int(q) - f_ref + K_T q + load - f_pressure(q)``, of which a share is applied.

    K_T is symmetric, as it is in steady rotation. The tangent is not where the pressure's is not.
    """

    def __init__(
        self,
        system: StructuralSystem,
        reference: Array,
        tolerance: float,
        load: Array | float = 0.0,
        extra: Array | None = None,
        pressure: PressureLoad | None = None,
    ) -> None:
        self.system, self._reference, self.share = system, reference, 1.0
        self._load, self._pressure = load, pressure
        self._workspace = system.workspace()
        self.pattern = pattern = system.pattern
        self._extra = None if extra is None else 0.5 * (extra + extra[pattern.transpose_slots])
        self._turning = None if self._extra is None else pattern.symmetric_matrix(self._extra)
        self._symmetric = SymmetricFactorization(pattern)
        self.solve: Callable[[Array], Array] = self._symmetric.solve
        self._first_scale: float | None = None
        self._round_off = _ROUND_OFF / tolerance
        self._diagonal = np.zeros(system.size)
        self._known: tuple[Array, float, Array] | None = None

    def residual(self, x: Array) -> tuple[Array, float]:
        """Residual [N], and its norm over that of the forces in it."""
        force, _ = self._workspace.force(x)
        force -= self._reference
        load = self.share * self._load
        if self._pressure is not None:
            load = load - self.share * self._pressure.force(x)
        total = force + load
        if self._turning is not None:
            total += self._turning @ x
        norm = float(np.linalg.norm(total))
        if self._first_scale is None:
            # A given stress that relaxes has no load to be measured against but its own imbalance.
            self._first_scale = norm
        scale = max(float(np.linalg.norm(load)), float(np.linalg.norm(force)), self._first_scale)
        return total, relative_error(norm, max(scale, self._round_off * self._cancelling(x)))

    def _cancelling(self, x: Array) -> float:
        """Forces of elements cancel each other at nodes, and stiff ones feel the round-off of x: norm of both [N]."""
        elements = largest_force(self.system, self._workspace.stress) * np.sqrt(x.size)
        return float(elements + np.linalg.norm(self._diagonal * x))

    def tangent(self, x: Array) -> Array:
        """Derivative of the residual, values in the pattern; the last one is remembered."""
        if self._known is not None and self._known[1] == self.share and np.array_equal(self._known[0], x):
            return self._known[2]
        values = self._workspace.tangent(x)
        if self._extra is not None:
            values = values + self._extra
        if self._pressure is not None:
            values = values - self.share * self._pressure.tangent(x)
        self._diagonal, self._known = values[self.pattern.diagonal], (x, self.share, values)
        return values

    def refresh(self, x: Array) -> None:
        """Factorize the tangent at ``x``."""
        values = self.tangent(x)
        if self.pattern.is_symmetric(values):
            self._symmetric.factorize(values)
            self.solve = self._symmetric.solve
        else:
            self.solve = general_solver(self.pattern.matrix(values))

    def ready(self) -> bool:
        """Whether an earlier tangent is at hand; under pressure it serves once, the way is long with an old one."""
        return self._pressure is None and self._symmetric.ready

    def use(self, blocks: tuple[ElementBlock, ...]) -> None:
        """Take other laws."""
        self._workspace = self.system.with_initial_stress(self.system.initial_stress, blocks).workspace()
        self._known = None

    def newton(self, start: Array, tolerance: float) -> Array | None:
        """Equilibrium by Newton's method, stable under pressure; None if there is none on its way."""
        if self._pressure is not None and not self.stable(start):
            return None
        try:
            outcome = solve_newton(self, start, tolerance)
        except np.linalg.LinAlgError:
            return None  # a singular tangent is what the descent is for
        found = outcome.converged and (self._pressure is None or self.stable(outcome.x))
        return outcome.x if found else None

    def stable(self, x: Array) -> bool:
        """Whether every small motion away from ``x`` costs work."""
        values = self.tangent(x)
        # Motions without stiffness count as lost: the shift takes the zero pivots away that would need another solver.
        return is_positive(self._symmetric, values, -_SINGULAR * float(np.abs(self._diagonal).max(initial=0.0)))


def largest_force(system: StructuralSystem, stress: Iterable[Array]) -> float:
    """Largest force that one element's stress exerts on a node of the reference shape [N]."""
    largest = 0.0
    for block, values in zip(system.blocks, stress, strict=True):
        nodal = np.einsum("nid,n,ni->nd", block.gradient, block.measure, values @ block.linear)
        largest = max(largest, float(np.abs(nodal).max(initial=0.0)))
    return largest
