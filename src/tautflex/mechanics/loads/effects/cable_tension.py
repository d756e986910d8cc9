"""Tension of cables in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex.mechanics.loads.effects.cables import cable_columns, chosen_cables
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PreparedInput, StressChange
from tautflex.mechanics.loads.signals import Signal, check_signal, value_at
from tautflex.mechanics.system import StructuralSystem
from tautflex.text import brief


@dataclass(frozen=True)
class CableTension(Effect):
    """Change of cable tension at unchanged length, as reeling in a cable of this model makes it.

    The change that is left once the structure has given way is smaller: `TensionGroup` prescribes that.

    Parameters
    ----------
    change
        Change of tension at unchanged length [N]: a number, one per selected cable, or a function of time; None where
        a plant commands one number per selected cable.
    cables
        Numbers of the cables (order of ``model.cables``); None selects all.
    breaks
        Instants at which the function jumps [s].
    """

    change: Signal | None = None
    cables: Sequence[int] | None = None
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "change"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with cables."""
        check_signal("change", self.change)
        chosen = chosen_cables("CableTension", system, self.cables)
        # One number for all cables is one input, not as many as there are cables.
        together = self.change is not None and value_at("change", self.change, 0.0).size == 1
        tension = np.ones((chosen.size, 1)) if together else np.eye(chosen.size)
        labels = ("change [N]",) if together else tuple(f"change_{cable} [N]" for cable in chosen)
        return StressChange(self.change, "change", labels, -np.inf, cable_columns(system, chosen, tension))
