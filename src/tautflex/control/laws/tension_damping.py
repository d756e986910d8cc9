"""Damping by tension."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.law import ControlLaw, own_memory
from tautflex.control.laws.tension import ParametricLaw, TensionMemory
from tautflex.control.signals import Reference
from tautflex.numeric import Array


@dataclass(frozen=True)
class TensionDamping(ParametricLaw, ControlLaw):
    """Tension that takes energy from every mode at once, ``u = limit tanh(gain eta' Khat deta/dt / 2 E)``.

    An input that changes the stiffness by ``u Khat`` does the work ``-u deta/dt' Khat eta`` per second on the motion,
    which this law keeps negative (Lyapunov); E is the energy of the coordinates [control.md 1].

    Parameters
    ----------
    gain
        Time that makes the power per energy a pure number [s], > 0, per unit of the command: large switches.

    Examples
    --------
    >>> import tautflex as tf
    >>> law = tf.PD(30.0, 22.0) + tf.TensionDamping(commands=("pull",), limit=0.3, modes=6)
    >>> type(law).__name__
    'SumOfLaws'
    """

    gain: float = 1.0
    follows_reference: ClassVar[bool] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("gain", self.gain)

    def act(self, memory: TensionMemory, measurement: Array, reference: Reference) -> tuple[TensionMemory, Array]:
        """Command against the power."""
        x, eta, rate = own_memory(memory, TensionMemory).motion(measurement)
        plant = memory.estimator.plant
        energy = 0.5 * float(rate @ rate + eta @ plant.stiffness @ eta) + self.floor
        power = np.einsum("i,kij,j->k", rate, plant.bilinear[memory.used], eta)
        command = self.limit * np.tanh(self.gain * power / (2.0 * energy)) if energy > 0.0 else 0.0 * power
        return memory.done(x, command)
