"""Linear-quadratic regulator on a state that is measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tautflex.control.estimate import direct_estimator, steady_reference
from tautflex.control.law import LawMatrices, LinearLaw, LinearMemory
from tautflex.control.laws.optimal import Optimal
from tautflex.control.riccati import regulator
from tautflex.control.signals import LoopSpec
from tautflex.control.spillover import refuse_spillover
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.text import brief


@dataclass(frozen=True)
class LQR(Optimal, LinearLaw):
    """Linear-quadratic regulator: state feedback of least cost over the discretized model [Kwakernaak & Sivan 1972].

    The sensors must tell the whole state of the model at once: attitude and rate, and ``ModalCoordinates`` of as many
    modes as it has coordinates, or displacement and velocity of as many points. Where they do not, take `LQG`.
    """

    __repr__ = brief

    def start(self, spec: LoopSpec) -> LinearMemory:
        """At rest; a law of fewer modes than the model has must leave the others stable."""
        return started(self, spec)

    def matrices(self, spec: LoopSpec) -> LawMatrices:
        """State by least squares, then the gain."""
        plant, used = self.design(spec)
        estimator = direct_estimator(plant, spec.interval)
        if estimator is None:
            raise InputError(
                f"measurements: expected sensors that tell all {len(plant.states)} states for LQR, got "
                f"{len(plant.outputs)} numbers that do not; add sensors such as ModalCoordinates({plant.coordinates}), "
                "take fewer modes, or take LQG"
            )
        gain = regulator(estimator.plant, self.weights(estimator.plant)).gain
        state, command = steady_reference(plant, estimator.plant, self.feedforward)
        return of_all(estimator.with_gain(gain, gain @ state + command), used, len(spec.commanded))


def started(law: Any, spec: LoopSpec) -> LinearMemory:
    """Memory of an optimal law before the first measurement, its loop with all modes looked at."""
    memory: LinearMemory = LinearLaw.start(law, spec)
    if law.modes is not None or spec.beyond is not None:
        refuse_spillover(spec, memory.matrices, type(law).__name__, "modes", "raise modes, or the tolerances")
    return memory


def of_all(law: LawMatrices, used: Indices, commands: int) -> LawMatrices:
    """Matrices of a law on some of the commands as one on all."""
    spread: Array = np.zeros((commands, len(used)))
    spread[used, np.arange(len(used))] = 1.0
    return law._replace(C=spread @ law.C, D=spread @ law.D, d=spread @ law.d)
