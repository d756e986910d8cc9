"""Temperature of cables in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.mechanics.loads.effects.cables import by_block, chosen_cables, of_cables
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PreparedInput, StressChange
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class CableTemperature(Effect):
    """Temperature change of cables: warm ones lengthen and lose tension.

    Parameters
    ----------
    change
        Temperature above the reference [K], a number or a function of time; None where a plant commands it.
    expansion
        Coefficient of thermal expansion along the cable [1/K]; of aramid about -2e-6.
    cables
        Numbers of the cables (order of ``model.cables``), or those along ``"x"``, ``"y"`` or ``"z"``; None is all.
    breaks
        Instants at which the function jumps [s].
    """

    change: Signal | None
    expansion: float
    cables: Sequence[int] | str | None = None
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "change"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with cables: stress change -E expansion per kelvin, in series with a tendon if there is."""
        expansion = checks.finite("expansion", self.expansion)
        chosen = chosen_cables("CableTemperature", system, self.cables)
        modulus = of_cables(system, [block.elasticity[:, 0, 0] for block in system.blocks])
        stress = np.zeros((modulus.size, 1, 1))
        stress[chosen, 0, 0] = -expansion * modulus[chosen]
        return StressChange(self.change, "change", ("change [K]",), -np.inf, by_block(system, stress))
