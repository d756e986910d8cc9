"""An input in time: a tap on the film, a half sine of force with a given impulse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import tautflex as tf


@tf.register
@dataclass(frozen=True)
class Tap(tf.TimeInput):
    """Tap across the film, shared by some nodes.

    Parameters
    ----------
    nodes
        Node numbers.
    impulse
        Time integral of the whole force along z [N s].
    begin
        When it begins [s].
    duration
        How long it lasts [s], > 0.

    Raises
    ------
    InputError
        If ``duration`` is not positive.
    """

    nodes: Sequence[int]
    impulse: float
    begin: float = 0.0
    duration: float = 0.05

    def __post_init__(self) -> None:
        if self.duration <= 0.0:
            raise tf.InputError(f"duration: expected a number > 0, got {self.duration!r}; give the length of the tap")

    @property
    def breaks(self) -> tuple[float, ...]:
        """Where the slope of the force jumps [s]."""
        return self.begin, self.begin + self.duration

    def force(self, time: float) -> tuple[float, float, float]:
        """Force on each node [N]; the integral of a half sine over its length T is 2 T / pi."""
        share = (time - self.begin) / self.duration
        peak = self.impulse * np.pi / (2.0 * self.duration * len(self.nodes))
        return 0.0, 0.0, peak * float(np.sin(np.pi * share)) if 0.0 < share < 1.0 else 0.0

    def prepare(self, system):
        return tf.NodalForce(self.nodes, self.force).prepare(system)
