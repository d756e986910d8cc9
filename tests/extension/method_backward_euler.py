"""An integrator: backward Euler, first order, damps whatever the step does not resolve."""

from __future__ import annotations

from dataclasses import dataclass

import tautflex as tf


@tf.register
@dataclass(frozen=True)
class BackwardEuler(tf.OneStageMethod):
    """Backward differences of velocity and acceleration: v1 = (q1 - q0)/h, a1 = (v1 - v0)/h.

    Parameters
    ----------
    implicitness
        Weight of the forces at the end of the step, in [0.5, 1]; the rest weighs those at its start.

    Raises
    ------
    InputError
        If ``implicitness`` is out of range.
    """

    implicitness: float = 1.0

    def __post_init__(self) -> None:
        if not 0.5 <= self.implicitness <= 1.0:
            raise tf.InputError(
                f"implicitness: expected a number in [0.5, 1], got {self.implicitness!r}; 1 is backward Euler"
            )

    @property
    def name(self) -> str:
        return f"backward Euler (implicitness = {self.implicitness:g})"

    def scheme(self, step: float) -> tf.StepScheme:
        end = tf.Combination(1.0 / step**2, -1.0 / step, 0.0)
        velocity = tf.Combination(1.0 / step, 0.0, 0.0)
        return tf.StepScheme(
            evaluation=1.0,
            weight=self.implicitness,
            inertia=end,
            velocity=velocity,
            end_displacement=tf.Combination(1.0, 0.0, 0.0),
            end_velocity=velocity,
            end_acceleration=end,
        )
