"""Attitude and film under disturbances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.tasks.task import Range, Task
from tautflex.mechanics.loads.effects.nodal_force import NodalForce
from tautflex.mechanics.loads.effects.temperature.membrane import MembraneTemperature
from tautflex.mechanics.loads.inputs import Effect
from tautflex.structure.model import Model


@dataclass(frozen=True, kw_only=True)
class HoldTask(Task):
    """Stay where you are: the film is struck twice, then its temperature snaps.

    Parameters
    ----------
    point
        Point of the film that is struck [m].
    impulse
        Largest impulse across the film that is drawn [N s], > 0; it is given within one interval.
    snap
        Largest change of the film's temperature that is drawn [K], >= 0.
    expansion
        Coefficient of thermal expansion of the film [1/K].
    """

    point: tuple[float, float] = (0.5, 0.2)
    impulse: float = 2e-3
    snap: float = 2.0
    expansion: float = 2e-5

    kind: ClassVar[str] = "hold"
    directions: ClassVar[tuple[str, ...]] = ("z", "rx")
    drawn: ClassVar[tuple[str, ...]] = (
        "first",
        "second",
        "first_time",
        "second_time",
        "snap",
        "snap_time",
        *Task.drawn,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.float_array("point", self.point, (2,))
        checks.positive("impulse", self.impulse)
        checks.non_negative("snap", self.snap)
        checks.finite("expansion", self.expansion)

    def limits(self) -> dict[str, Range]:
        """Those of all tasks, impulses [N s] and instants [s], temperature [K] and its instant [s]."""
        strength, end = (-self.impulse, self.impulse), self.duration
        return {
            "first": strength,
            "second": strength,
            "first_time": (0.0, 0.2 * end),
            "second_time": (0.2 * end, 0.4 * end),
            "snap": (-self.snap, self.snap),
            "snap_time": (0.4 * end, 0.6 * end),
        } | super().limits()

    def nominal(self) -> dict[str, float]:
        """Both impulses at their largest, of one sign, and a film that cools."""
        end = self.duration
        times = {"first_time": 0.05 * end, "second_time": 0.25 * end, "snap_time": 0.5 * end}
        return {"first": self.impulse, "second": self.impulse, "snap": -self.snap} | times | super().nominal()

    def grid(self, count: int = 4) -> list[dict[str, float]]:
        """Draws of a source of their own."""
        random, limits = np.random.default_rng(0), self.limits()
        own = [name for name in self.drawn if name not in Task.drawn]
        return [self.nominal() | {name: float(random.uniform(*limits[name])) for name in own} for _ in range(count)]

    def effects(self, model: Model) -> dict[str, Effect]:
        """Force at the node nearest to the point, and temperature of the film."""
        node = int(np.linalg.norm(model.nodes - [*self.point, 0.0], axis=1).argmin())
        strike = NodalForce([node], direction=(0.0, 0.0, 1.0))
        return {"strike": strike, "film temperature": MembraneTemperature(None, self.expansion)}

    def acting(self, parameters: dict[str, Any], place: Any, interval: float, xp: Any = np) -> list[Any]:
        """An impulse is given within the interval that its instant lies in; the temperature stays."""

        def since(instant: str) -> Any:
            return place - xp.floor(parameters[instant] / interval)

        force = sum(
            xp.where(since(f"{strike}_time") == 0, parameters[strike] / interval, 0.0) for strike in ("first", "second")
        )
        return [force, xp.where(since("snap_time") >= 0, parameters["snap"], 0.0)]
