"""Runs of a plant as pages make them: what a page is checked against."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from tautflex.control.compiled.compiled_plant import CompiledPlant
from tautflex.control.runs.following import references
from tautflex.motion.fixed_axis import Slew
from tautflex.motion.shaping import SHAPERS
from tautflex.numeric import Array

# An instant this close before a jump is behind it [s].
_STILL = 1e-9


class Turn(NamedTuple):
    """A slew as sliders have it: every copy that the ``shaper`` of a mode makes lasts ``duration`` [s]."""

    angle: float
    duration: float
    profile: str
    shaper: str
    frequency: float
    ratio: float

    @classmethod
    def of(cls, slew: Slew, axis: int, shaper: str, frequency: float, ratio: float) -> Turn:
        """A slew about an axis; a shaper of its own comes first."""
        angle = slew.angle * float(np.sign(slew.axis[axis]) or 1.0)
        if slew.profile != "input-shaped":
            return cls(angle, slew.duration, slew.profile, shaper, frequency, ratio)
        found = cls(angle, slew.duration, slew.base, slew.shaper, float(slew.frequency or 0.0), slew.damping_ratio)
        return found._replace(duration=slew.duration - found.delay)

    @property
    def delay(self) -> float:
        """Delay of the last copy [s]."""
        return SHAPERS.get(self.shaper, 0) * 0.5 / (self.frequency * float(np.sqrt(1.0 - self.ratio**2)))

    def maneuver(self, axis: int) -> Slew:
        """The same for the numerics."""
        along = tuple(np.eye(3)[axis].tolist())
        if self.shaper == "none":
            return Slew(self.angle, self.duration, self.profile, along)
        return Slew(
            self.angle, self.duration + self.delay, "input-shaped", along, frequency=self.frequency,
            damping_ratio=self.ratio, shaper=self.shaper, base=self.profile,
        )  # fmt: skip


def played(
    plant: CompiledPlant,
    turn: Turn,
    gains: Mapping[str, float],
    count: int,
    held: Mapping[int, float] | None = None,
    knocks: Sequence[Mapping[str, Any]] = (),
    told: Callable[[], None] | None = None,
) -> Array:
    """Measurements of a plant over some intervals, shape (count + 1, outputs).

    ``gains`` are those of `PD`; ``held`` numbers of the command stay; ``knocks`` push from ``start`` to ``end`` [s] by
    a ``force`` at a ``number``; ``told`` is called after every interval.
    """
    readings = [channel.name for channel in plant.outputs for _ in range(channel.size)]
    attitude, rate = readings.index("attitude"), readings.index("rate")
    assert plant.hub is not None
    axis = "xyz".index(plant.hub.axes)
    times = np.asarray(plant.interval * np.arange(count), dtype=np.float64)
    measured = [plant.reset()]
    for follow in references(turn.maneuver(axis), times, plant.hub):
        command = np.zeros(sum(channel.size for channel in plant.inputs))
        for number, value in (held or {}).items():
            command[number] = value
        for knock in knocks:
            if knock["start"] - _STILL <= follow.time < knock["end"] - _STILL:
                command[knock["number"]] += knock["force"]
        seen = measured[-1]
        pulled = -gains["stiffness"] * seen[attitude] - gains["damping"] * seen[rate]
        pulled += gains["stiffness"] * follow.attitude[0] + gains["damping"] * follow.rate[0]
        command[0] = pulled + gains["inertia"] * follow.acceleration[0]
        measured.append(plant.step(command).copy())
        if told is not None:
            told()
    return np.array(measured)
