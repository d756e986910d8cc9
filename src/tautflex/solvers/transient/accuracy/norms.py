"""Norms that adaptive steps control errors by."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tautflex.mechanics.products import MassDamping
from tautflex.numeric import Array
from tautflex.solvers.transient.state import MotionState


class ErrorNorms:
    """Norms in the mass of a structure, whose ``products`` a subclass has."""

    products: MassDamping

    def speeds(self, at: MotionState, since: MotionState) -> Array:
        """Norms ``sqrt(x' M x)`` of the velocities that adaptive steps control each error against."""
        return np.array([self._norm(at.v)])

    def pushes(self, at: MotionState) -> Array:
        """The same norms of the accelerations."""
        return np.array([self._norm(at.a)])

    def errors(self, at: MotionState, end: MotionState, share: float, smoothed: Callable[[Array], Array]) -> Array:
        """The same norms of ``share`` times the change of the accelerations, less what ``smoothed`` takes out."""
        return np.array([self._norm(smoothed(share * (end.a - at.a)))])

    def _norm(self, x: Array) -> float:
        return float(np.sqrt(max(self.products.mass_norm(x), 0.0)))
