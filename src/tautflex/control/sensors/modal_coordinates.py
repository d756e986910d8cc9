"""Coordinates of the natural modes, as no instrument reads them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.sensors.sensor import PreparedSensor, Sensor, SensorRows
from tautflex.motion.hub import FreeHub
from tautflex.solvers.static.prestress import PrestressedState


@dataclass(frozen=True)
class ModalCoordinates(Sensor):
    """Coordinates of the lowest natural modes [m kg^1/2], then their rates [m kg^1/2/s]; no instrument has them.

    Parameters
    ----------
    modes
        Number of modes, >= 1: twice as many numbers are read.
    """

    modes: int = 10

    privileged: ClassVar[bool] = True

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.whole("modes", self.modes, 1)

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Rows ``phi' M`` of the modes of the structure at rest, by which the others drop out."""
        _, vectors = state.linear.modes(self.modes)
        rows = (state.system.inertia.mass_matrix @ vectors.T).T
        none = np.zeros_like(rows)
        seen = SensorRows(displacement=np.concatenate([rows, none]), velocity=np.concatenate([none, rows]))
        return PreparedSensor("m kg^1/2", 2 * self.modes, seen)
