"""What a maneuver asks of a hub at all instants of an episode, at once."""

from __future__ import annotations

import numpy as np

from tautflex.control.runs.following import references
from tautflex.control.sensors.sensor import hub_rows
from tautflex.motion.fixed_axis import Slew
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver, unit_axis
from tautflex.numeric import Array


def reference_table(maneuver: Maneuver, times: Array, hub: FreeHub | None) -> Array:
    """Attitude, rate and acceleration of the reference and attitude of the goal, shape (time, 4 axes)."""
    if hub is None:
        return np.zeros((len(times), 0))
    rows = hub_rows(hub)
    if isinstance(maneuver, AtRest):
        return np.zeros((len(times), 4 * len(rows)))
    if isinstance(maneuver, Slew):
        return _slew(maneuver, times, rows)
    found = references(maneuver, times, hub)
    return np.array([[*each.numbers, *(each.attitude if each.goal is None else each.goal)] for each in found])


def _slew(maneuver: Slew, times: Array, rows: Array) -> Array:
    """By its own formula: rotation about one line."""
    step, angle = maneuver.formula(maneuver.numbers).step, maneuver.angle
    edges = np.array([*step.edges, np.inf])
    values = np.zeros((len(times), 3))
    # A sample on an edge belongs to what follows it, round-off apart.
    stretch = np.searchsorted(edges, times + 1e-9, side="right") - 1
    for number in np.unique(stretch).tolist():
        middle = edges[number] + 1.0 if np.isinf(edges[number + 1]) else 0.5 * (edges[number] + edges[number + 1])
        own = stretch == number
        for order, derivative in enumerate(step.around(middle)(times[own])):
            values[own, order] = derivative
    turn = rows @ unit_axis(maneuver.axis)
    wanted = np.column_stack([angle * values, np.full(len(times), angle)])
    return np.asarray((wanted[:, :, None] * turn).reshape(len(times), -1))
