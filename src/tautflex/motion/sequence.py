"""Maneuvers one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment


@dataclass(frozen=True)
class Sequence(Maneuver):
    """Maneuvers in a row, each beginning where the one before has ended.

    A maneuver ends where its last segment begins; its last motion is then held until the next one begins. Angular
    acceleration and acceleration of the origin may jump from one to the next, the angular velocity may not.

    Parameters
    ----------
    steps
        The maneuvers; the run starts in the steady motion of the first.
    holds
        How long the last motion of each is held [s], >= 0, one number for each but the last, whose motion is held for
        ever; empty for none.

    Raises
    ------
    InputError
        If there are no maneuvers, or the angular velocity would jump between two of them.

    Examples
    --------
    >>> import tautflex as tf
    >>> there, back = tf.Slew(angle=0.3, duration=2.0), tf.Slew(angle=-0.3, duration=2.0)
    >>> len(tf.Sequence((there, back), holds=(1.0,)).steps)
    2
    """

    steps: tuple[Maneuver, ...]
    holds: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", checks.several("steps", self.steps, Maneuver, "Slew(0.1, 2.0)"))
        object.__setattr__(self, "holds", tuple(checks.float_array("holds", self.holds, (None,)).tolist()))
        if not self.steps:
            raise InputError("steps: expected at least one maneuver, got none; add for example Slew(0.1, 2.0)")
        if self.holds and len(self.holds) != len(self.steps) - 1:
            raise InputError(
                f"holds: expected {len(self.steps) - 1} durations, one for each step but the last, "
                f"got {len(self.holds)}"
            )
        for hold in self.holds:
            checks.non_negative("holds", hold)
        self._check_junctions()

    def _check_junctions(self) -> None:
        for number, (step, following) in enumerate(pairwise(self.steps), start=1):
            last = step.segments()[-1]
            before = last.motion(last.start).angular_velocity
            after = following.segments()[0].motion(0.0).angular_velocity
            if not np.allclose(after, before, rtol=1e-9, atol=1e-12):
                raise InputError(
                    f"steps: expected step {number + 1} to begin with the angular velocity {before.tolist()} rad/s "
                    f"that step {number} ends with, got {after.tolist()}; put a SpinUp between them"
                )

    def start(self) -> RigidMotion:
        """Steady motion before the first maneuver."""
        return self.steps[0].start()

    def segments(self) -> tuple[Segment, ...]:
        """Segments of all maneuvers, moved to where they begin."""
        found: list[Segment] = []
        begin, holds = 0.0, self.holds or (0.0,) * (len(self.steps) - 1)
        for step, hold in zip(self.steps, (*holds, np.inf), strict=True):
            *moving, last = step.segments()
            end = last.start + hold
            for part in (*moving, Segment(last.start, end, last.motion)):
                if part.end > part.start:
                    found.append(Segment(begin + part.start, begin + part.end, _later(part.motion, begin)))
            begin += end
        return tuple(found)


def _later(motion: Callable[[float], RigidMotion], delay: float) -> Callable[[float], RigidMotion]:
    return lambda time: motion(time - delay)
