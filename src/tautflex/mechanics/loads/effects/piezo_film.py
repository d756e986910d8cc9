"""Piezoelectric film: an electric field across it strains it in its plane."""

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
class PiezoFilm(Effect):
    """Piezoelectric film, or a part of it, under an electric field across its thickness.

    The free strain is ``coefficient * field`` in all directions of the film: of film that is poled across and the same
    in its plane. Held film answers with the stress ``-D (coefficient, coefficient, 0) field``.

    Parameters
    ----------
    coefficient
        Piezoelectric coefficient d31 [m/V]; of a layer in a laminate, times its share of the stiffness.
    field
        Electric field, voltage over thickness [V/m], a number or a function of time; None where a plant commands it.
    region
        Lowest and highest x, lowest and highest y [m] of the part with electrodes: elements whose middle lies there;
        None is the whole film.
    breaks
        Instants at which the function jumps [s].
    """

    coefficient: float
    field: Signal | None = None
    region: Region | None = None
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "field"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film."""
        columns = free_strain("PiezoFilm", system, checks.finite("coefficient", self.coefficient), self.region)
        return StressChange(self.field, "field", ("field [V/m]",), -np.inf, columns)
