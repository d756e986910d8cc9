"""Load cells in cables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.sensors.sensor import PreparedSensor, Sensor, SensorRows
from tautflex.errors import InputError
from tautflex.motion.hub import FreeHub
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import brief


@dataclass(frozen=True)
class CableTensionSensor(Sensor):
    """Tension of cables [N], one number each.

    Parameters
    ----------
    cables
        Numbers of the cables, in the order of ``model.cables``; none given: all.
    """

    kind: ClassVar[str] = "cable-tension"

    cables: Sequence[int] | None = None
    __repr__ = brief

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Rows on the stresses of the cables: tension = stress times area."""
        system, total = state.system, len(state.model.cables)
        if not total:
            raise InputError("CableTensionSensor: expected a model with cables, got none; add cables to the model")
        chosen = np.arange(total) if self.cables is None else checks.indices("cables", self.cables, total, "cable")
        if not chosen.size:
            raise InputError("cables: expected at least one cable, got none; leave cables out for all")
        weights, first = {}, 0
        for index in system.block_index("cable"):
            block = system.blocks[index]
            rows = len(system.initial_stress[index])
            weight = np.zeros((chosen.size, rows, 1))
            own = np.flatnonzero((chosen >= first) & (chosen < first + rows))
            weight[own, chosen[own] - first, 0] = block.size[chosen[own] - first]
            weights[index] = weight
            first += rows
        return PreparedSensor("N", chosen.size, SensorRows(stress=weights))
