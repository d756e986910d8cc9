"""Temperature of the frame in time, and its gradient across the section."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PreparedInput, StressChange
from tautflex.mechanics.loads.signals import Signal, check_signal, value_at
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief

# Strains of a beam that are free: extension, and the first of the two bending strains about z and about y.
_FREE = 0, 1, 3


@dataclass(frozen=True)
class FrameTemperature(Effect):
    """Temperature change of beams, alike across their section, or rising across it as on a boom with a sunlit side.

    A field ``T + G_y y + G_z z`` over a section that is free makes it longer by ``expansion T`` and bends it to the
    curvatures ``v'' = -expansion G_y`` and ``w'' = -expansion G_z`` [Boley & Weiner 1960, 10.2].

    Parameters
    ----------
    change
        Temperature above the reference [K], or three numbers: that, and its gradients along the local y and z axes of
        the beams [K/m]; or a function of time; None where a plant commands the temperature.
    expansion
        Coefficient of thermal expansion along the beams [1/K].
    beams
        Numbers of the beams (order of ``model.beams``); None is all.
    breaks
        Instants at which the function jumps [s].
    """

    change: Signal | None
    expansion: float
    beams: Sequence[int] | None = None
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "change"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with beams: what holds back the free strain, -D (expansion T, ...)."""
        expansion = checks.finite("expansion", self.expansion)
        check_signal("change", self.change)
        count = len(system.model.beams)
        if not count:
            raise InputError("FrameTemperature: expected a model with beams, got none; add a frame to the model")
        chosen = np.arange(count) if self.beams is None else checks.indices("beams", self.beams, count, "beam")
        numbers = 1 if self.change is None else value_at("change", self.change, 0.0).size
        if numbers not in (1, 3):
            raise InputError(
                f"change: expected one number [K], or three with the gradients along y and z [K/m], got {numbers}"
            )
        columns, first = {}, 0
        for index in system.block_index("beam"):
            block = system.blocks[index]
            warm = np.isin(np.arange(first, first + len(block.dofs)), chosen)
            first += len(block.dofs)
            free = np.zeros((len(block.dofs), block.initial_stress.shape[1], numbers))
            for k, strain in enumerate(_FREE[:numbers]):
                # Bending strains are turns from end to end: curvature times length.
                free[warm, strain, k] = expansion if k == 0 else -expansion * block.measure[warm]
            columns[index] = -np.einsum("nst,ntk->nsk", block.elasticity, free)
        labels = ("change [K]", "gradient_y [K/m]", "gradient_z [K/m]")[:numbers]
        return StressChange(self.change, "change", labels, -np.inf, columns)
