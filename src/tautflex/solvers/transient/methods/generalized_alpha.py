"""Generalized-alpha method and its special cases Newmark and HHT-alpha."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex import checks
from tautflex.errors import InputError
from tautflex.solvers.transient.methods.scheme import Combination, OneStageMethod, StepScheme


def alpha_scheme(step: float, alpha_m: float, alpha_f: float, beta: float, gamma: float) -> StepScheme:
    """Coefficients of ``M a_{1-alpha_m} + P_{1-alpha_f} = 0`` with Newmark's interpolation.

    Parameters
    ----------
    step
        Step size [s].
    alpha_m, alpha_f
        Shares of the start of the step in the inertia force and in the other forces [Chung & Hulbert 1993].
    beta, gamma
        Newmark parameters.

    Returns
    -------
    StepScheme
    """
    h = step
    end = Combination(1.0 / (beta * h**2), -1.0 / (beta * h), -(0.5 - beta) / beta)
    inertia = Combination((1.0 - alpha_m) * end.d, (1.0 - alpha_m) * end.v, (1.0 - alpha_m) * end.a + alpha_m)
    velocity = Combination(gamma * h * end.d, 1.0 + gamma * h * end.v, h * (1.0 - gamma + gamma * end.a))
    return StepScheme(
        evaluation=1.0,
        weight=1.0 - alpha_f,
        inertia=inertia,
        velocity=velocity,
        end_displacement=Combination(1.0, 0.0, 0.0),
        end_velocity=velocity,
        end_acceleration=end,
    )


@dataclass(frozen=True)
class GeneralizedAlpha(OneStageMethod):
    """Second-order method with chosen damping at high frequency [Chung & Hulbert 1993].

    Parameters
    ----------
    rho_inf
        Spectral radius at infinite frequency, in [0, 1]; 1 is the trapezoidal rule, 0 kills high frequencies in one
        step.

    Raises
    ------
    InputError
        If ``rho_inf`` is out of range.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.GeneralizedAlpha(rho_inf=0.8)
    GeneralizedAlpha(rho_inf=0.8)
    """

    rho_inf: float = 0.8

    def __post_init__(self) -> None:
        checks.between("rho_inf", self.rho_inf, 0.0, 1.0, remedy="0.8 damps only what the step cannot resolve")

    @property
    def name(self) -> str:
        """Name in results."""
        return f"generalized-alpha (rho_inf = {self.rho_inf:g})"

    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""
        rho = self.rho_inf
        alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 - alpha_m + alpha_f
        return alpha_scheme(step, alpha_m, alpha_f, 0.25 * (1.0 - alpha_m + alpha_f) ** 2, gamma)


@dataclass(frozen=True)
class Newmark(OneStageMethod):
    """Newmark's method [Newmark 1959]; the default is the trapezoidal (average acceleration) rule.

    Parameters
    ----------
    gamma
        Velocity parameter in [0.5, 1]; above 1/2 it damps and falls to first order.
    beta
        Displacement parameter in (0, 1]; unconditionally stable for beta >= (gamma + 1/2)^2 / 4.

    Raises
    ------
    InputError
        If the parameters are out of range.
    """

    gamma: float = 0.5
    beta: float = 0.25

    def __post_init__(self) -> None:
        checks.between("gamma", self.gamma, 0.5, 1.0, remedy="0.5 is second order")
        if not 0.0 < checks.finite("beta", self.beta) <= 1.0:
            raise InputError(f"beta: expected a number in (0, 1], got {self.beta!r}; 0.25 is the trapezoidal rule")

    @property
    def name(self) -> str:
        """Name in results."""
        return f"Newmark (gamma = {self.gamma:g}, beta = {self.beta:g})"

    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""
        return alpha_scheme(step, 0.0, 0.0, self.beta, self.gamma)


@dataclass(frozen=True)
class HHT(OneStageMethod):
    """Hilber-Hughes-Taylor method [Hilber, Hughes & Taylor 1977].

    Parameters
    ----------
    alpha
        Damping parameter in [0, 1/3]; 0 is the trapezoidal rule.

    Raises
    ------
    InputError
        If alpha is out of range.
    """

    alpha: float = 0.05

    def __post_init__(self) -> None:
        checks.between("alpha", self.alpha, 0.0, 1.0 / 3.0, remedy="0.05 is a usual choice")

    @property
    def name(self) -> str:
        """Name in results."""
        return f"HHT-alpha (alpha = {self.alpha:g})"

    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""
        return alpha_scheme(step, 0.0, self.alpha, 0.25 * (1.0 + self.alpha) ** 2, 0.5 + self.alpha)
