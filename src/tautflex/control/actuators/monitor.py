r"""Energy monitor: tension that pumps vibration up is switched off.

A stress that jumps by du where a unit of it has the energy p(q) does the work ``du p`` on the structure. What it does
on the structure that has only answered the stresses u, ``du own u``, comes back when they go; the rest is pumped into
vibration, or out of it. Tension that moves at twice a mode's frequency pumps [parametric resonance]: p of a vibration
is ``(1 + cos) / 2``, and of all work that is moved, in or out, at least half stays. Noise does not do that over a
period.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.drive import Drive
from tautflex.errors import InputError
from tautflex.mechanics.loads.prepared import StressChange
from tautflex.numeric import Array
from tautflex.reduction.bases.vectors import ReferenceSolver
from tautflex.reduction.polynomial.strains import stress_loads
from tautflex.solvers.static.prestress import PrestressedState

# Part of all work moved in a period that stays, beyond which a period pumps; periods in a row that are too many.
SHARE, PERIODS = 0.5, 2


class Watch(NamedTuple):
    """What a monitor has seen: intervals of this period, its work that stays and all of it [J], periods that pumped."""

    intervals: int = 0
    pumped: float = 0.0
    moved: float = 0.0
    strikes: int = 0

    @property
    def off(self) -> bool:
        """Whether the actuator is switched off."""
        return self.strikes >= PERIODS

    def seen(self, work: float, window: int) -> Watch:
        """One interval later, at whose start some work was pumped [J]; a period has ``window`` intervals."""
        if self.off:
            return self
        pumped, moved = self.pumped + work, self.moved + abs(work)
        if self.intervals + 1 < window:
            return Watch(self.intervals + 1, pumped, moved, self.strikes)
        return Watch(strikes=self.strikes + 1 if moved > 0.0 and pumped >= SHARE * moved else 0)


class Monitor(NamedTuple):
    """Constants of the monitors of a plant.

    Parameters
    ----------
    window
        Intervals in the period of the lowest mode; 0: nothing is watched.
    own
        Energy of a unit of each stress in the structure that has answered a unit of each, by actuator, shapes (n, n).
    """

    window: int
    own: dict[str, Array]


def monitor_of(actuators: Mapping[str, Drive], state: PrestressedState, interval: float) -> Monitor:
    """Monitors of the actuators that have one; InputError if one of them changes no stress."""
    own = dict[str, Array]()
    for name, drive in actuators.items():
        if not drive.monitor:
            continue
        bound = drive.effect.prepare(state.system) if isinstance(drive, Actuator) else None
        if not isinstance(bound, StressChange):
            raise InputError(
                f"actuators.{name}.monitor: expected false where no stress is changed, got true; leave it out"
            )
        pulls, solver = stress_loads(state.system, bound.columns), ReferenceSolver(state)
        own[name] = -pulls @ np.array([solver.solve(pull) for pull in pulls]).T
    if not own:
        return Monitor(0, own)
    period = 2.0 * np.pi / float(state.linear.modes(1)[0][0])
    return Monitor(max(1, int(np.ceil(period / interval - 1e-9))), own)
