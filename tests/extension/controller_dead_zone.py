"""A control law: pushes against a displacement that leaves a dead zone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import tautflex as tf


@tf.register
@dataclass(frozen=True)
class DeadZone(tf.ControlLaw):
    """Constant push against a displacement outside a dead zone, on the first command.

    Parameters
    ----------
    push
        Size of the command, in its unit, > 0.
    zone
        Displacement that is let be [m], >= 0.
    measurement
        Name of the sensor.
    """

    push: float
    zone: float
    measurement: str = "film"

    def __post_init__(self) -> None:
        if self.push <= 0.0:
            raise tf.InputError(f"push: expected a number > 0, got {self.push!r}; give the size of the command")

    def start(self, spec):
        return spec.measurement("measurement", self.measurement)[0], len(spec.commanded)

    def act(self, memory, measurement, reference):
        place, count = memory
        y, command = measurement[place], np.zeros(count)
        command[0] = -self.push * np.sign(y) if abs(y) > self.zone else 0.0
        return memory, command
