"""Attitude and film under disturbances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from tautflex import checks
from tautflex.control.tasks.task import Range, Task


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
