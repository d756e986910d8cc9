"""Wilson-theta method, the paper's."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex import checks
from tautflex.solvers.transient.methods.scheme import Combination, OneStageMethod, StepScheme


@dataclass(frozen=True)
class WilsonTheta(OneStageMethod):
    """Linear acceleration over theta h, equilibrium at t + theta h [Wilson, Farhoomand & Bathe 1973].

    Parameters
    ----------
    theta
        Collocation parameter in [1, 3]; linearly unconditionally stable for theta >= 1.37, default 1.4 (the paper's).

    Raises
    ------
    InputError
        If theta is below 1.

    Notes
    -----
    Second order, damps high frequencies, overshoots in the first steps of stiff modes. The equilibrium holds at
    t + theta h, not at the end of the step.
    """

    theta: float = 1.4

    def __post_init__(self) -> None:
        checks.between("theta", self.theta, 1.0, 3.0, remedy="1.4 is the usual choice")

    @property
    def name(self) -> str:
        """Name in results."""
        return f"Wilson-theta (theta = {self.theta:g})"

    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""
        h, tau = step, self.theta * step
        collocated = Combination(6.0 / tau**2, -6.0 / tau, -2.0)
        part = 1.0 / self.theta
        end = Combination(part * collocated.d, part * collocated.v, 1.0 + part * (collocated.a - 1.0))
        return StepScheme(
            evaluation=self.theta,
            weight=1.0,
            inertia=collocated,
            velocity=Combination(3.0 / tau, -2.0, -0.5 * tau),
            end_displacement=Combination(h**2 / 6 * end.d, h + h**2 / 6 * end.v, h**2 / 6 * (2.0 + end.a)),
            end_velocity=Combination(0.5 * h * end.d, 1.0 + 0.5 * h * end.v, 0.5 * h * (1.0 + end.a)),
            end_acceleration=end,
        )
