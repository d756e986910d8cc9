"""Damping in proportion to mass and stiffness."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex import checks
from tautflex.mechanics.dampings.damping import Damping, LinearStructure
from tautflex.mechanics.dampings.matrix import DampingMatrix


@dataclass(frozen=True)
class Rayleigh(Damping):
    """Proportional damping ``C = alpha M + beta K(reference)`` [paper sec. 3].

    Parameters
    ----------
    alpha
        Mass factor [1/s], >= 0.
    beta
        Stiffness factor [s], >= 0; K is the tangent of the prestressed reference state.

    Notes
    -----
    A mode of angular frequency w has the ratio ``alpha / (2 w) + beta w / 2`` [Clough & Penzien, Dynamics of
    Structures, 12-4].
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        checks.non_negative("alpha", self.alpha)
        checks.non_negative("beta", self.beta)

    def matrix(self, structure: LinearStructure) -> DampingMatrix:
        """``alpha M + beta K``."""
        return DampingMatrix(self.alpha, self.beta)
