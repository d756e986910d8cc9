"""Star tracker: which way the hub points."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex.control.sensors.sensor import PreparedSensor, Sensor, SensorRows, hub_rows
from tautflex.motion.hub import FreeHub
from tautflex.solvers.static.prestress import PrestressedState


@dataclass(frozen=True)
class Attitude(Sensor):
    """Rotation vector of the hub from the inertial frame [rad]: one number on a hub of one axis, else three.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Attitude(noise=1e-6, delay=0.01).noise
    1e-06
    """

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Rows of the hub's axes."""
        rows = hub_rows(hub)
        return PreparedSensor("rad", len(rows), SensorRows(rotation=rows))
