"""Pressure on the film in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import FilmPressure, PreparedInput
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.loads.signals import Signal, check_signal, value_at
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class Pressure(Effect):
    """Pressure that stays normal to the film while it moves.

    Parameters
    ----------
    pressure
        Pressure along the right-hand normal of the corner order of most of the film, which is +z for the built-in
        mesh [Pa]: a number, one per film element, or a function of time; None where a plant commands it.
    breaks
        Instants at which the function jumps [s].
    """

    pressure: Signal | None = None
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "pressure"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film."""
        check_signal("pressure", self.pressure)
        unit = PressureLoad(system, 1.0)
        if self.pressure is not None and value_at("pressure", self.pressure, 0.0).size != 1:
            return _UnevenPressure(unit, self.pressure)
        return FilmPressure(self.pressure, "pressure", ("pressure [Pa]",), -np.inf, unit)


@dataclass(frozen=True)
class _UnevenPressure(PreparedInput):
    """Pressure of one number per film element."""

    film: PressureLoad
    function: Signal
    name: ClassVar[str] = "pressure"

    def follower(self, time: float) -> PressureLoad:
        """The pressure at an instant [s]."""
        return self.film.scaled(value_at(self.name, self.function, time))
