"""Damping by a stiffness that is switched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.law import ControlLaw, own_memory
from tautflex.control.laws.tension import ParametricLaw, TensionMemory
from tautflex.control.signals import LoopSpec, Reference
from tautflex.errors import InputError
from tautflex.numeric import Array


@dataclass(frozen=True)
class StiffnessSwitching(ParametricLaw, ControlLaw):
    """Stiffness of one mode that is high while the mode moves out and low while it comes back.

    With ``1 + d`` and ``1 - d`` times its stiffness the amplitude of the mode falls by ``(1 - d)/(1 + d)`` in every
    period: a damping ratio of ``d/pi`` for small d [Corr & Clark 2001; control.md 1].

    Parameters
    ----------
    mode
        Number of the mode, from 1.
    """

    mode: int = 1
    follows_reference: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.whole("mode", self.mode, 1)

    def start(self, spec: LoopSpec) -> TensionMemory:
        """At rest."""
        memory = super().start(spec)
        if self.mode > memory.estimator.plant.coordinates:
            most = memory.estimator.plant.coordinates
            raise InputError(f"mode: expected at most {most}, the modes of the model, got {self.mode}; raise modes")
        return memory

    def act(self, memory: TensionMemory, measurement: Array, reference: Reference) -> tuple[TensionMemory, Array]:
        """The limit of one sign or the other."""
        x, eta, rate = own_memory(memory, TensionMemory).motion(measurement)
        plant, j = memory.estimator.plant, self.mode - 1
        energy = 0.5 * float(rate[j] ** 2 + plant.stiffness[j, j] * eta[j] ** 2)
        share = energy / (energy + self.floor) if energy > 0.0 else 0.0
        return memory.done(x, self.limit * share * np.sign(eta[j] * rate[j] * plant.bilinear[memory.used, j, j]))
