"""Temperature of the membrane in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import PreparedInput, TimeInput
from tautflex.mechanics.loads.prepared import StressChange, TimeFunction
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class MembraneTemperature(TimeInput):
    """Uniform temperature change of the film.

    Parameters
    ----------
    change
        Temperature above the reference [K], a number or a function of time.
    expansion
        Coefficient of thermal expansion [1/K].
    breaks
        Instants at which the function jumps [s].
    """

    change: TimeFunction
    expansion: float
    breaks: tuple[float, ...] = ()
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film: stress change -D (expansion, expansion, 0) per kelvin."""
        blocks = system.block_index("membrane")
        if not blocks:
            raise InputError("MembraneTemperature: expected a model with a film, got none; add triangles to the model")
        strain = checks.finite("expansion", self.expansion) * np.array([1.0, 1.0, 0.0])
        per_kelvin = {index: (-system.blocks[index].elasticity @ strain)[:, :, None] for index in blocks}
        return StressChange(self.change, per_kelvin, 1, "change")
