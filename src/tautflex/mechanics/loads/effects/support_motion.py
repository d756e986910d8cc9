"""Supports that move by a given course, each against the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.nodes import checked_nodes, unit_vector
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.mechanics.loads.prepared import MovedSupport
from tautflex.mechanics.loads.signals import Signal, check_signal, value_at
from tautflex.mechanics.loads.time_table import TimeTable
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.structure.groups import DIRECTIONS
from tautflex.text import brief

QUANTITIES = ("displacement", "velocity", "acceleration")
# Part of the largest value that a start from rest may be off.
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class SupportMotion(TimeInput):
    """Motion of supports in the floating frame, from rest where they hold the structure at the start.

    Displacement, velocity and acceleration of the supports act at once: by the strains of the elements that they hold,
    however far they go, by these elements' share of the inertia, and by their damping.

    Parameters
    ----------
    nodes
        Node numbers, held along the direction by supports.
    direction
        Direction of the motion in floating-frame axes, of any length.
    motion
        Course along it: a `TimeTable` of the ``quantity``, a function of time that gives displacement, velocity and
        acceleration together [m, m/s, m/s^2], or a number, which is an acceleration that stays.
    quantity
        Of a table: ``"displacement"``, a cubic spline through its rows that starts and ends at rest; ``"velocity"`` or
        ``"acceleration"``, straight between the rows and integrated exactly.
    breaks
        Instants at which the acceleration of a function jumps [s].

    Notes
    -----
    With x the free displacements and s those of supports, ``M_ff a + C_ff v + f(x, s) = F - M_fs s'' - C_fs s'``: the
    block form of the equations of the unsupported structure [Clough & Penzien, Dynamics of Structures, 26-2]. Damping
    in modes resists motion beside the static answer ``-K_ff^-1 K_fs s``, any other the whole motion.
    """

    nodes: Sequence[int]
    direction: Sequence[float]
    motion: Signal
    quantity: str = "displacement"
    breaks: tuple[float, ...] = ()
    moves_supports: ClassVar[bool] = True
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.one_of("quantity", self.quantity, QUANTITIES)
        unit_vector("direction", self.direction)
        check_signal("motion", self.motion)
        course = _course(self.motion, self.quantity)
        place = course(0.0)
        size = np.abs(np.asarray(self.motion.values)).max() if isinstance(self.motion, TimeTable) else 0.0
        if np.any(np.abs(place[:2]) > _ROUND_OFF * size):
            raise InputError(
                f"motion: expected supports at rest where they hold the structure at t = 0, got {place[0]:.4g} m and "
                f"{place[1]:.4g} m/s; let the motion rise from zero"
            )

    def prepare(self, system: StructuralSystem) -> MovedSupport:
        """Bind to a system whose supports hold the nodes along the direction."""
        nodes, along = checked_nodes(system, self.nodes), unit_vector("direction", self.direction)
        axes = np.flatnonzero(np.abs(along) > _ROUND_OFF)
        dofs = system.model.translation_dofs[nodes][:, axes]
        held = np.isin(dofs, system.model.fixed_dofs)
        if not held.all():
            row, column = np.argwhere(~held)[0]
            raise InputError(
                f"nodes: expected supports that hold what they move, got node {nodes[row]} free along "
                f"{DIRECTIONS[axes[column]]}; add a Support, or push the node by a NodalForce"
            )
        shares = np.broadcast_to(along[axes], dofs.shape)
        return MovedSupport(dofs.ravel(), shares.ravel(), _course(self.motion, self.quantity))


def _course(motion: Any, quantity: str) -> Callable[[float], Array]:
    """Displacement, velocity and acceleration at an instant [s], shape (3,)."""
    if callable(motion) and not isinstance(motion, TimeTable):
        return lambda time: checks.float_array("motion", value_at("motion", motion, time), (3,))
    if not isinstance(motion, TimeTable):
        acceleration = checks.finite("motion", motion)
        if quantity != "acceleration" and acceleration:
            raise InputError(
                f"motion: expected a table or a function of the {quantity}, got {acceleration:g}, with which supports "
                'would start by a jump; give a TimeTable that rises from zero, or quantity = "acceleration"'
            )
        return lambda time: acceleration * np.array([0.5 * time**2, time, 1.0])
    times, values = np.asarray(motion.times), np.asarray(motion.values)
    if values.ndim > 1 or times[0] < 0.0:
        raise InputError(
            f"motion: expected rows of one number from t = 0 on, got shape {values.shape} from {times[0]:g} s on; give "
            "one SupportMotion for each direction"
        )
    jumps = np.flatnonzero(np.diff(times) == 0.0)
    if jumps.size and quantity != "acceleration":
        raise InputError(f"motion: expected a {quantity} without jumps, got one at {times[jumps[0]]:g} s; give it time")
    # Still before the first row and steady after the last one, as tables are.
    times = np.concatenate([[min(0.0, times[0] - 1.0)], times, [times[-1] + 1.0]])
    values = np.concatenate([values[:1], values, values[-1:]])
    if quantity == "displacement":
        inner = CubicSpline(times[1:-1], values[1:-1], bc_type="clamped") if len(times) > 3 else None
        pieces = np.zeros((4, len(times) - 1))
        pieces[3] = values[:-1]
        if inner is not None:
            pieces[:, 1:-1] = inner.c
        place = PPoly(pieces, times)
        speed, rate = place.derivative(), place.derivative(2)
    else:
        kept = np.diff(times) > 0.0
        steps, rises = np.diff(times)[kept], np.diff(values)[kept]
        table = PPoly(np.array([rises / steps, values[:-1][kept]]), np.append(times[:-1][kept], times[-1]))
        speed, rate = (table, table.derivative()) if quantity == "velocity" else (_since(table), table)
        place = _since(speed)
    return lambda time: np.array([place(time), speed(time), rate(time)])


def _since(rate: PPoly) -> PPoly:
    """Integral of a piecewise polynomial from t = 0 on."""
    whole = rate.antiderivative()
    whole.c[-1] -= whole(0.0)
    return whole
