"""Bathe's method: a trapezoidal stage, then a backward difference over the whole step."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from tautflex import checks
from tautflex.solvers.transient.methods.generalized_alpha import alpha_scheme
from tautflex.solvers.transient.methods.scheme import Combination, Method, Stage, StepScheme


@dataclass(frozen=True)
class Bathe(Method):
    """Composite method of two stages [Bathe & Baig 2005; Bathe, Computers & Structures 85 (2007) 437].

    Parameters
    ----------
    split
        Share of the step that the trapezoidal rule takes, in [0.1, 0.9]. The default 2 - sqrt(2) gives both stages the
        same effective stiffness, so that one factorization serves both.

    Raises
    ------
    InputError
        If ``split`` is out of range.

    Notes
    -----
    Second order, unconditionally stable, kills what the step does not resolve at once (spectral radius 0 at infinity)
    and hardly damps what it does. Two solutions a step: compare it with other methods at half their step.

    Examples
    --------
    >>> import tautflex as tf
    >>> round(tf.Bathe().split, 4)
    0.5858
    """

    split: float = 2.0 - sqrt(2.0)

    def __post_init__(self) -> None:
        checks.between("split", self.split, 0.1, 0.9, remedy="leave it out, or give 0.5, Bathe's own choice")

    @property
    def name(self) -> str:
        """Name in results."""
        return f"Bathe (split = {self.split:.4g})"

    def stages(self, step: float) -> tuple[Stage, ...]:
        """Stages of a step of a size [s]; n, g and 1 are its start, the split and its end."""
        g, h = self.split, step
        # v_1 = first q_n + middle q_g + last q_1 and the same of velocities; the three add up to zero, so with
        # d = q_1 - q_g and V = first (q_n - q_g):  v_1 = last d + V,  a_1 = last^2 d + last V + first v_n + middle v_g.
        first, middle, last = (1.0 - g) / (g * h), -1.0 / ((1.0 - g) * g * h), (2.0 - g) / ((1.0 - g) * h)
        move, velocity, change = Combination(1.0, 0.0, 0.0), Combination(last, 1.0, 0.0), Combination(last**2, 0.0, 1.0)
        backward = StepScheme(1.0, 1.0, change, velocity, move, velocity, change)
        passed = Combination(first, 0.0, 0.0), Combination(0.0, 0.0, 0.0)
        slowed = Combination(last * first, first, 0.0), Combination(0.0, middle, 0.0)
        return (
            Stage(alpha_scheme(g * h, 0.0, 0.0, 0.25, 0.5), share=g),
            Stage(backward, share=1.0 - g, velocity=passed, acceleration=slowed),
        )
