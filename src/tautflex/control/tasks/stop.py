"""The paper's maneuver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.tasks.task import Range, Task, rising_range
from tautflex.motion.fixed_axis import Stop


@dataclass(frozen=True, kw_only=True)
class StopTask(Task):
    """The paper's maneuver: a steady spin that stops, after which the film must settle; the hub is driven.

    Parameters
    ----------
    rate_range
        Least and largest spin that is drawn [rad/s].
    stop_duration
        Time to stop [s], > 0.
    axis
        Axis of the spin.
    """

    rate_range: Range = (0.5, 0.7)
    stop_duration: float = 1.0
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)

    kind: ClassVar[str] = "stop"
    drawn: ClassVar[tuple[str, ...]] = ("rate", *Task.drawn)

    def __post_init__(self) -> None:
        super().__post_init__()
        rising_range("rate_range", self.rate_range, 1e-6)
        checks.positive("stop_duration", self.stop_duration)
        checks.vector3("axis", self.axis)

    def limits(self) -> dict[str, Range]:
        """Those of all tasks, and of the spin [rad/s]."""
        return {"rate": self.rate_range} | super().limits()

    def nominal(self) -> dict[str, float]:
        """The paper's spin, pi/5 [rad/s]."""
        return {"rate": float(np.pi / 5.0)} | super().nominal()

    def maneuver(self, parameters: dict[str, float]) -> Stop:
        """Constant deceleration."""
        return Stop(parameters["rate"], self.stop_duration, axis=self.axis)

    def reference(self, time: Any, parameters: dict[str, Any], xp: Any = np) -> list[Any]:
        """The formula of the stop; its end belongs to what follows it."""
        rate, left = parameters["rate"], self.stop_duration - time
        slowing = left > 1e-9
        angle = 0.5 * rate * (self.stop_duration - xp.where(slowing, left, 0.0) ** 2 / self.stop_duration)
        slope = xp.where(slowing, rate / self.stop_duration, 0.0)
        return [angle, slope * left, -slope]
