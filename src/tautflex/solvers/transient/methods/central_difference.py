"""Explicit central differences."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.explicit import ExplicitMethod, ExplicitStepper


@dataclass(frozen=True)
class CentralDifference(ExplicitMethod):
    """Explicit central differences with the consistent mass matrix [Bathe, Finite Element Procedures, 9.2.1].

    Notes
    -----
    ``M a_n + (C + G) v_n + f(q_n) + K_T q_n + Q_T = 0`` at every step, with v_n the mean of the velocities half a
    step before and after. Second order, no numerical damping, stable for ``h <= 2 / w_max`` with w_max the largest
    angular frequency of (K_tangent, M), whatever the damping, because C v_n is solved for and not lagged. The mass
    matrix, or ``M + h C / 2``, is factorized once.

    A time step above the stable one is refused before the run; where the structure stiffens in the run, steps are
    halved.
    """

    @property
    def name(self) -> str:
        """Name in results."""
        return "central difference"

    def stepper(self, equation: EquationOfMotion) -> ExplicitStepper:
        """Stepper of one run."""
        return ExplicitStepper(equation)
