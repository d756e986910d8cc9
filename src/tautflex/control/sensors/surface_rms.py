"""How far the film is from a plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex.control.sensors.sensor import PreparedSensor, SensedMotion, Sensor
from tautflex.errors import InputError
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array
from tautflex.solvers.static.prestress import PrestressedState


@dataclass(frozen=True)
class SurfaceRms(Sensor):
    """Root mean square over the film's area of its deflection from the best plane [m]; no instrument has it."""

    privileged: ClassVar[bool] = True

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Bind to a structure with a film, see `FilmSurface`; its reading is not linear."""
        surface = state.system.surface
        if not surface.area:
            raise InputError("SurfaceRms: expected a model with a film, got none; add triangles to the model")

        def rms(motion: SensedMotion) -> Array:
            measures = np.empty(4)
            surface.measure(motion.q, measures)
            return measures[:1]

        return PreparedSensor("m", 1, None, rms)
