"""Rest to rest through an angle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.tasks.task import Range, Task, rising_range
from tautflex.motion.fixed_axis import Slew


@dataclass(frozen=True, kw_only=True)
class SlewTask(Task):
    """Turn about an axis by a drawn angle, from rest to rest, and stand still as soon as possible.

    Laws follow a bang-bang turn of constant acceleration; the agent may take another way.

    Parameters
    ----------
    angle_range
        Least and largest angle that is drawn [rad].
    acceleration
        Angular acceleration of the turn that laws follow [rad/s^2], > 0.
    axis
        Axis of the turn.
    """

    angle_range: Range = (0.2, 0.7)
    acceleration: float = 0.5
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)

    kind: ClassVar[str] = "slew"
    drawn: ClassVar[tuple[str, ...]] = ("angle", *Task.drawn)

    def __post_init__(self) -> None:
        super().__post_init__()
        rising_range("angle_range", self.angle_range, 1e-6)
        checks.positive("acceleration", self.acceleration)
        checks.vector3("axis", self.axis)

    def limits(self) -> dict[str, Range]:
        """Those of all tasks, and of the angle [rad]."""
        return {"angle": self.angle_range} | super().limits()

    def nominal(self) -> dict[str, float]:
        """The middle of the angles."""
        return {"angle": 0.5 * sum(self.angle_range)} | super().nominal()

    def maneuver(self, parameters: dict[str, float]) -> Slew:
        """Half the way at one acceleration, half at its opposite."""
        angle = parameters["angle"]
        return Slew(angle, 2.0 * float(np.sqrt(angle / self.acceleration)), "bang-bang", axis=self.axis)

    def reference(self, time: Any, parameters: dict[str, Any], xp: Any = np) -> list[Any]:
        """The formula of the bang-bang turn; an instant on an edge belongs to what follows it."""
        size, angle = self.acceleration, parameters["angle"]
        half = xp.sqrt(angle / size)
        first, done = time + 1e-9 < half, time + 1e-9 >= 2.0 * half
        left = 2.0 * half - time
        place = xp.where(first, 0.5 * size * time**2, xp.where(done, angle, angle - 0.5 * size * left**2))
        rate = xp.where(first, size * time, xp.where(done, 0.0, size * left))
        return [place, rate, xp.where(first, size, xp.where(done, 0.0, -size))]

    def goal(self, parameters: dict[str, Any]) -> Any:
        """The drawn angle."""
        return parameters["angle"]
