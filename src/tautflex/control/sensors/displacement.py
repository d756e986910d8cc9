"""Optical tracking: where points of the structure are."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex.control.sensors.points import Points, check_points, point_rows
from tautflex.control.sensors.sensor import PreparedSensor, Sensor, SensorRows
from tautflex.motion.hub import FreeHub
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import brief


@dataclass(frozen=True)
class Displacement(Sensor):
    """Elastic displacement of points in the hub's axes [m], one number each.

    Parameters
    ----------
    points
        Point (x, y) or (x, y, z) [m], or a list of them: any of the film, or where a node of frame or cables is.
    component
        ``"u"``, ``"v"`` or ``"w"``: along x, y or z.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Displacement([(0.7, 0.4), (-0.7, 0.4)], noise=1e-6).component
    'w'
    """

    points: Points
    component: str = "w"
    __repr__ = brief

    def __post_init__(self) -> None:
        super().__post_init__()
        check_points(self.points, self.component)

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """Rows of the points."""
        rows = point_rows(state.system, self.points, self.component)
        return PreparedSensor("m", rows.shape[0], SensorRows(displacement=rows))
