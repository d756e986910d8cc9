"""A damping: Rayleigh's, given by what is measured, the ratios at two frequencies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import tautflex as tf


@tf.register
@dataclass(frozen=True)
class TwoRatios(tf.Damping):
    """Proportional damping that has a given ratio at two frequencies: ratio = alpha/(2 w) + beta w/2 there.

    Parameters
    ----------
    ratio
        Ratio of critical damping at both frequencies, >= 0.
    low, high
        The frequencies [Hz], > 0.

    Raises
    ------
    InputError
        If the frequencies are not positive and different.
    """

    ratio: float
    low: float
    high: float

    def __post_init__(self) -> None:
        if not 0.0 < self.low < self.high:
            raise tf.InputError(f"high: expected more than low = {self.low:g} Hz > 0, got {self.high:g}; swap them?")

    def matrix(self, structure: tf.LinearStructure) -> tf.DampingMatrix:
        first, second = 2.0 * np.pi * self.low, 2.0 * np.pi * self.high
        share = 2.0 * self.ratio / (first + second)
        return tf.DampingMatrix(mass=share * first * second, stiffness=share)
