"""Gyroscope: how fast the hub turns."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex.control.sensors.sensor import PreparedSensor, Sensor, SensorRows, hub_rows
from tautflex.motion.hub import FreeHub
from tautflex.solvers.static.prestress import PrestressedState


@dataclass(frozen=True)
class Rate(Sensor):
    """Angular velocity of the hub in its own axes [rad/s]: one number on a hub of one axis, else three.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Rate(noise=1e-6).noise
    1e-06
    """

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Rows of the hub's axes."""
        rows = hub_rows(hub)
        return PreparedSensor("rad/s", len(rows), SensorRows(rate=rows))
