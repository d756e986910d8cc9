"""Linear-quadratic regulator on an estimated state."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex.control.estimate import kalman_estimator, steady_reference
from tautflex.control.law import LawMatrices, LinearLaw, LinearMemory
from tautflex.control.laws.lqr import of_all, started
from tautflex.control.laws.optimal import Filtered
from tautflex.control.riccati import regulator
from tautflex.control.signals import LoopSpec
from tautflex.text import brief


@dataclass(frozen=True)
class LQG(Filtered, LinearLaw):
    """Linear-quadratic regulator on the state that a steady Kalman filter estimates [Kwakernaak & Sivan 1972].

    Poles of the loop are those of regulator and filter (separation principle), as long as the plant is the model.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.LQG(tolerances={"attitude": 1e-2, "film": 3e-4}, efforts={"torque": 0.1}, modes=8).modes
    8
    """

    __repr__ = brief

    def start(self, spec: LoopSpec) -> LinearMemory:
        """At rest; a law of fewer modes than the model has must leave the others stable."""
        return started(self, spec)

    def matrices(self, spec: LoopSpec) -> LawMatrices:
        """Filter, then the gain; the state is that of the filter and the last command."""
        plant, used = self.design(spec)
        estimator = kalman_estimator(plant, spec, self.noise)
        gain = regulator(estimator.plant, self.weights(estimator.plant)).gain
        state, command = steady_reference(plant, estimator.plant, self.feedforward)
        return of_all(estimator.with_gain(gain, gain @ state + command), used, len(spec.commanded))
