"""Pressure on the film in time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.mechanics.loads.prepared import PreparedInput
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.loads.signals import Signal, check_signal, value_at
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class Pressure(TimeInput):
    """Pressure that stays normal to the film while it moves.

    Parameters
    ----------
    pressure
        Pressure along the right-hand normal of the corner order of most of the film, which is +z for the built-in
        mesh [Pa]: a number, one per film element, or a function of time.
    breaks
        Instants at which the function jumps [s].
    """

    pressure: Signal
    breaks: tuple[float, ...] = ()

    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film."""
        check_signal("pressure", self.pressure)
        return _FilmPressure(PressureLoad(system, 0.0), self.pressure)


@dataclass(frozen=True)
class _FilmPressure(PreparedInput):
    film: PressureLoad
    function: Signal
    name: ClassVar[str] = "pressure"

    def follower(self, time: float) -> PressureLoad:
        """The pressure at an instant [s]."""
        return self.film.scaled(value_at(self.name, self.function, time))
