r"""Energy monitor: tension that pumps vibration up is switched off.

A stress that jumps by du where a unit of it has the energy p(q) does the work ``du p`` on the structure. What it does
on the structure that has only answered the stresses u, ``du own u``, comes back when they go; the rest is pumped into
vibration, or out of it. Tension that moves at twice a mode's frequency pumps [parametric resonance]: p of a vibration
is ``(1 + cos) / 2``, and of all work that is moved, in or out, at least half stays. Noise does not do that over a
period.

Most of the work on a full structure goes into waves in its plane, which every jump sends out and which no law can meet.
There, p is that of the modes that tension commanded once per interval T can pump, up to ``1/(4 T)``: with coordinates
``xi = Phi M q`` that the stresses u hold at ``xi_s = -W^-2 beta u``,

    p = beta (xi - xi_s) + xi' Khat xi / 2,   beta = Phi b, Khat as in `stiffness_changes`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.drive import Drive
from tautflex.control.columns import InputColumns, stiffness_changes
from tautflex.errors import InputError
from tautflex.mechanics.loads.prepared import StressChange
from tautflex.numeric import Array
from tautflex.reduction.bases.vectors import ReferenceSolver
from tautflex.reduction.polynomial.strains import stress_loads
from tautflex.solvers.static.prestress import PrestressedState

# Part of all work moved in a period that stays, beyond which a period pumps; periods in a row that are too many.
SHARE, PERIODS = 0.5, 2
# Modes of a full structure that are looked at.
_MOST = 40


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


class Vibration(NamedTuple):
    """Modes of a full structure that tension can pump.

    Parameters
    ----------
    weights
        Coordinates of displacements, shape (r, size).
    squares
        Squared frequencies [rad^2/s^2], shape (r,).
    push, stiffness
        beta and Khat of each stress by actuator, shapes (n, r) and (n, r, r).
    """

    weights: Array
    squares: Array
    push: dict[str, Array]
    stiffness: dict[str, Array]

    def pumped(self, name: str, q: Array, change: Array, values: Mapping[str, Array]) -> float:
        """Work of a change of one actuator's stresses under those that act until then, by actuator [J]."""
        xi = self.weights @ q
        lean = sum((values[each] @ push for each, push in self.push.items()), np.zeros(len(xi))) / self.squares
        bent = np.einsum("nij,i,j->n", self.stiffness[name], xi, xi)
        return float(change @ (self.push[name] @ (xi + lean) + 0.5 * bent))


class Monitor(NamedTuple):
    """Constants of the monitors of a plant.

    Parameters
    ----------
    window
        Intervals in the period of the lowest mode; 0: nothing is watched.
    own
        Energy of a unit of each stress in the structure that has answered a unit of each, by actuator, shapes (n, n).
    vibration
        Modes by which work is told on a full structure; None: of a reduced model.
    """

    window: int
    own: dict[str, Array]
    vibration: Vibration | None = None


def monitor_of(
    actuators: Mapping[str, Drive], state: PrestressedState, interval: float, *, full: bool = False
) -> Monitor:
    """Monitors of the actuators that have one; InputError if one of them changes no stress."""
    own, stresses = dict[str, Array](), dict[str, StressChange]()
    for name, drive in actuators.items():
        bound = drive.effect.prepare(state.system) if isinstance(drive, Actuator) else None
        if isinstance(bound, StressChange):
            stresses[name] = bound
        if not drive.monitor:
            continue
        if not isinstance(bound, StressChange):
            raise InputError(
                f"actuators.{name}.monitor: expected false where no stress is changed, got true; leave it out"
            )
        pulls, solver = stress_loads(state.system, bound.columns), ReferenceSolver(state)
        own[name] = -pulls @ np.array([solver.solve(pull) for pull in pulls]).T
    if not own:
        return Monitor(0, own)
    period = 2.0 * np.pi / float(state.linear.modes(1)[0][0])
    vibration = _vibration(stresses, own, state, 0.5 * np.pi / interval) if full else None
    return Monitor(max(1, int(np.ceil(period / interval - 1e-9))), own, vibration)


def _vibration(
    stresses: Mapping[str, StressChange], watched: Iterable[str], state: PrestressedState, fastest: float
) -> Vibration:
    """Modes up to a frequency [rad/s], `_MOST` at most, and what stresses do to them."""
    system = state.system
    frequencies, vectors = state.linear.modes(min(_MOST, system.size))
    vectors = vectors[: max(1, int(np.sum(frequencies <= fastest)))]
    solver, rest = ReferenceSolver(state), np.zeros(system.size)
    push, stiffness = dict[str, Array](), dict[str, Array]()
    for name, bound in stresses.items():
        effect, pulls = InputColumns.of(name, bound, system), stress_loads(system, bound.columns)
        push[name] = pulls @ vectors.T
        if name in watched:
            answers = -np.array([solver.solve(pull) for pull in pulls]).T
            stiffness[name] = stiffness_changes(effect, system, rest, answers, vectors)
    weights = (system.inertia.mass_matrix @ vectors.T).T
    return Vibration(weights, frequencies[: len(vectors)] ** 2, push, stiffness)
