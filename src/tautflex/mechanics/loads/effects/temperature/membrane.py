"""Temperature of the membrane in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.mechanics.loads.effects.film import Region, free_strain
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PreparedInput, StressChange
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class MembraneTemperature(Effect):
    """Temperature change of the film, or of a part of it: sun, shadow, or a heater.

    Parameters
    ----------
    change
        Temperature above the reference [K], a number or a function of time; None where a plant commands it.
    expansion
        Coefficient of thermal expansion [1/K].
    breaks
        Instants at which the function jumps [s].
    region
        Lowest and highest x, lowest and highest y [m] of the part that changes: elements whose middle lies there;
        None is the whole film.
    """

    change: Signal | None
    expansion: float
    breaks: tuple[float, ...] = ()
    region: Region | None = None
    signal: ClassVar[str] = "change"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film: stress change -D (expansion, expansion, 0) per kelvin."""
        expansion = checks.finite("expansion", self.expansion)
        columns = free_strain("MembraneTemperature", system, expansion, self.region)
        return StressChange(self.change, "change", ("change [K]",), -np.inf, columns)
