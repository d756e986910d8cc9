"""What laws share that work by a change of the stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from tautflex import checks
from tautflex.control.estimate import Estimator, Noise, any_estimator, model_for
from tautflex.control.signals import LoopSpec, check_numbers
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.text import brief


class TensionMemory(NamedTuple):
    """Estimator, places of the commands and how many there are in all, expected state and last command."""

    estimator: Estimator
    used: Indices
    total: int
    expected: Array
    last: Array

    def motion(self, measurement: Array) -> tuple[Array, Array, Array]:
        """State, coordinates and rates at a sample."""
        plant = self.estimator.plant
        x = self.estimator.update(self.expected, self.last, measurement)
        return x, x[plant.positions], x[plant.positions + plant.half]

    def done(self, x: Array, command: Array) -> tuple[TensionMemory, Array]:
        """Memory behind a command of the used inputs, and the command of all."""
        every = np.zeros(self.total)
        every[self.used] = command
        return self._replace(expected=self.estimator.expect(x, every), last=every), every


@dataclass(frozen=True)
class ParametricLaw:
    """Commands that change the stiffness, and the state that they look at.

    Parameters
    ----------
    commands
        Names of the actuators, or of one of their numbers.
    limit
        Largest command of either sign, > 0, in its unit.
    modes
        Number of the lowest coordinates of the model that the law knows; none given: all.
    floor
        Energy [J] below which the law fades out, >= 0: it is otherwise as strong for the smallest motion.
    coordinate_noise
        Standard deviation of random accelerations of the coordinates, from sample to sample [m kg^1/2/s^2], > 0, where
        the sensors do not tell the whole state and a Kalman filter must.
    hub_noise
        The same of the hub [rad/s^2], > 0.
    measurement_noise
        Name of a sensor or of one of its numbers -> standard deviation of its noise, > 0, in its unit; those left out
        have that of the sensor.
    """

    commands: tuple[str, ...]
    limit: float
    modes: int | None = None
    floor: float = 0.0
    coordinate_noise: float = 1e-4
    hub_noise: float = 1e-4
    measurement_noise: Mapping[str, float] | None = None
    __repr__ = brief

    def __post_init__(self) -> None:
        if not checks.several("commands", self.commands, str, "'tension'"):
            raise InputError("commands: expected at least one name, got none; write for example ['tension']")
        if self.modes is not None:
            checks.whole("modes", self.modes, 1)
        checks.non_negative("floor", self.floor)
        for name in ("limit", "coordinate_noise", "hub_noise"):
            checks.positive(name, getattr(self, name))
        check_numbers("measurement_noise", self.measurement_noise)

    def start(self, spec: LoopSpec) -> TensionMemory:
        """At rest."""
        plant = model_for(type(self).__name__, spec, self.modes)
        used = np.concatenate(checks.together(*(partial(spec.command, "commands", name) for name in self.commands)))
        for place in used:
            if not np.any(plant.bilinear[place]):
                raise InputError(
                    f"commands: expected inputs that change the stiffness, got {spec.commanded[place]!r}, which does "
                    "not; take LQG for it"
                )
        noise = Noise(self.coordinate_noise, self.hub_noise, self.measurement_noise or {})
        estimator, total = any_estimator(plant, spec, noise), len(spec.commanded)
        return TensionMemory(estimator, used, total, np.zeros(len(estimator.plant.A)), np.zeros(total))
