"""Tension of cables in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import PreparedInput, TimeInput
from tautflex.mechanics.loads.prepared import StressChange, TimeFunction
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.text import brief


@dataclass(frozen=True)
class CableTension(TimeInput):
    """Change of cable tension in time, as an actuator that reels the cable makes it.

    Parameters
    ----------
    change
        Change of tension at unchanged length [N]: a number, one per selected cable, or a function of time.
    cables
        Numbers of the cables (order of ``model.cables``); None selects all.
    breaks
        Instants at which the function jumps [s].
    """

    change: TimeFunction
    cables: Sequence[int] | None = None
    breaks: tuple[float, ...] = ()
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with cables."""
        count = len(system.model.cables)
        if not count:
            raise InputError("CableTension: expected a model with cables, got none; add cables to the model")
        chosen = np.arange(count) if self.cables is None else checks.indices("cables", self.cables, count, "cable")
        if not chosen.size or len(np.unique(chosen)) < chosen.size:
            raise InputError(f"cables: expected at least one cable, every one once, got {chosen.tolist()}")
        return StressChange(self.change, _cable_columns(system, chosen), chosen.size, "change")


def _cable_columns(system: StructuralSystem, chosen: Indices) -> dict[int, Array]:
    """Stress per newton for every cable block, shapes (element, 1, chosen)."""
    columns, first = {}, 0
    for index in system.block_index("cable"):
        group = system.model.groups[index]
        column = np.zeros((len(group.connectivity), 1, chosen.size))
        for number, cable in enumerate(chosen):
            if first <= cable < first + len(column):
                column[cable - first, 0, number] = 1.0 / group.section.area  # type: ignore[union-attr]
        columns[index] = column
        first += len(column)
    return columns
