"""Damping models."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tautflex import checks


@dataclass(frozen=True)
class Rayleigh:
    """Proportional damping ``C = alpha M + beta K(reference)`` [paper sec. 3].

    Parameters
    ----------
    alpha
        Mass factor [1/s], >= 0.
    beta
        Stiffness factor [s], >= 0; K is the tangent of the prestressed reference state.
    """

    alpha: float = 0.0
    beta: float = 0.0

    def __post_init__(self) -> None:
        checks.non_negative("alpha", self.alpha)
        checks.non_negative("beta", self.beta)

    def entries(self, mass: NDArray[np.float64], stiffness: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of C in the pattern from those of M and K, shape (entries,)."""
        return self.alpha * mass + self.beta * stiffness
