"""What all laws share that minimise a cost over a linear model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.control.estimate import Noise, model_for
from tautflex.control.linear import LinearPlant
from tautflex.control.riccati import Weights, bryson_weights, require_columns
from tautflex.control.signals import LoopSpec, check_numbers, labelled
from tautflex.numeric import Indices
from tautflex.text import brief


@dataclass(frozen=True)
class Optimal:
    """Quadratic cost by Bryson's rule, and the model that it is for.

    Parameters
    ----------
    tolerances
        Name of a sensor, of one of its numbers (``"film[0]"``) or of a state of the model (``"eta1"``) -> deviation
        that counts as much as any other's, > 0, in its unit.
    efforts
        Name of an actuator -> command that counts as much, > 0, in its unit; others are not used.
    modes
        Number of the lowest coordinates of the model that the law knows; none given: all.
    feedforward
        Whether the commands turn the spacecraft along the reference by themselves.
    """

    tolerances: Mapping[str, float]
    efforts: Mapping[str, float]
    modes: int | None = None
    feedforward: bool = True
    __repr__ = brief

    def __post_init__(self) -> None:
        for name in ("tolerances", "efforts"):
            check_numbers(name, getattr(self, name), 1)
        if self.modes is not None:
            checks.whole("modes", self.modes, 1)
        checks.flag("feedforward", self.feedforward)

    def design(self, spec: LoopSpec) -> tuple[LinearPlant, Indices]:
        """Continuous model with the commands that have an effort, and the places of these in the command."""
        plant = model_for(type(self).__name__, spec, self.modes)
        labelled("tolerances", self.tolerances, [*plant.outputs, *plant.states])
        used = sorted(labelled("efforts", self.efforts, spec.commanded))
        plant = plant.selected([spec.commanded[k] for k in used], plant.outputs)
        require_columns(plant)
        return plant, np.array(used, dtype=np.int64)

    def weights(self, plant: LinearPlant) -> Weights:
        """Cost of a model."""
        return bryson_weights(plant, self.tolerances, self.efforts)


@dataclass(frozen=True)
class Filtered(Optimal):
    """The same on what a Kalman filter makes of the measurements.

    Parameters
    ----------
    coordinate_noise
        Standard deviation of random accelerations of the coordinates, from sample to sample [m kg^1/2/s^2], > 0: large
        trusts the measurement, small the model.
    hub_noise
        The same of the hub [rad/s^2], > 0.
    measurement_noise
        Name of a sensor or of one of its numbers -> standard deviation of its noise, > 0, in its unit; those left out
        have that of the sensor.
    """

    coordinate_noise: float = 1e-4
    hub_noise: float = 1e-4
    measurement_noise: Mapping[str, float] | None = None
    __repr__ = brief

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.positive("coordinate_noise", self.coordinate_noise)
        checks.positive("hub_noise", self.hub_noise)
        check_numbers("measurement_noise", self.measurement_noise)

    @property
    def noise(self) -> Noise:
        """What the filter is told."""
        return Noise(self.coordinate_noise, self.hub_noise, self.measurement_noise or {})
