"""A maneuver: the spin axis leaves its direction and cones, as after a lateral thruster fires on a spinning craft."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import tautflex as tf


@tf.register
@dataclass(frozen=True)
class Coning(tf.Maneuver):
    """Steady spin about z whose axis begins to cone at t = 0: w = (a sin nt, a (1 - cos nt), rate).

    Parameters
    ----------
    rate
        Spin about z, before and after t = 0 [rad/s].
    transverse_rate
        Half of the largest angular velocity across the spin axis, a [rad/s].
    coning_rate
        Angular frequency of the cone, n [rad/s], > 0.

    Raises
    ------
    InputError
        If ``coning_rate`` is not positive.
    """

    rate: float
    transverse_rate: float
    coning_rate: float

    def __post_init__(self) -> None:
        if self.coning_rate <= 0.0:
            raise tf.InputError(f"coning_rate: expected a number > 0, got {self.coning_rate!r}; turn its axis around")

    def start(self) -> tf.RigidMotion:
        return tf.RigidMotion(np.array([0.0, 0.0, self.rate]), np.zeros(3), np.zeros(3))

    def segments(self) -> tuple[tf.Segment, ...]:
        a, n = self.transverse_rate, self.coning_rate

        def motion(time: float) -> tf.RigidMotion:
            sine, cosine = np.sin(n * time), np.cos(n * time)
            velocity = np.array([a * sine, a * (1.0 - cosine), self.rate])
            return tf.RigidMotion(velocity, a * n * np.array([cosine, sine, 0.0]), np.zeros(3))

        return (tf.Segment(0.0, np.inf, motion),)
