"""Descent to a minimum of a potential: from saddles, along curved valleys, and where there is none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from tautflex.mechanics.pattern import SparsityPattern
from tautflex.solvers.nonlinear.minimum import find_minimum

Array = NDArray[np.float64]
PATTERN = SparsityPattern.from_elements(2, [np.array([[0, 1]])])


class Plane:
    """Potential of two unknowns from its value, gradient and second derivative."""

    def __init__(self, value: Callable, gradient: Callable, second: Callable) -> None:
        self._value, self._gradient, self._second = value, gradient, second

    def gradient(self, x: Array) -> tuple[Array, float, float, float]:
        value = float(self._value(*x))
        return np.array(self._gradient(*x), dtype=float), value, 1.0, abs(value)

    def tangent(self, x: Array) -> Array:
        return np.array(self._second(*x), dtype=float).ravel()


def test_curved_valley():
    valley = Plane(
        lambda x, y: (1 - x) ** 2 + 100 * (y - x * x) ** 2,
        lambda x, y: (-2 * (1 - x) - 400 * x * (y - x * x), 200 * (y - x * x)),
        lambda x, y: [[2 - 400 * (y - 3 * x * x), -400 * x], [-400 * x, 200]],
    )
    outcome = find_minimum(valley, PATTERN, np.array([-1.2, 1.0]), 1e-9)
    assert outcome.converged
    np.testing.assert_allclose(outcome.x, 1.0, atol=1e-8)
    assert outcome.iterations < 60


@pytest.mark.parametrize(("start", "well"), [(0.1, 1.0), (-0.1, -1.0)])
def test_next_to_a_saddle_it_goes_down_not_back(start, well):
    """Newton's method would return to the saddle at zero: the curvature there is negative."""
    wells = Plane(
        lambda x, y: (x * x - 1) ** 2 + y * y,
        lambda x, y: (4 * x * (x * x - 1), 2 * y),
        lambda x, y: [[12 * x * x - 4, 0], [0, 2]],
    )
    outcome = find_minimum(wells, PATTERN, np.array([start, 0.3]), 1e-10)
    assert outcome.converged
    np.testing.assert_allclose(outcome.x, [well, 0.0], atol=1e-9)


def test_a_floor_carries_directions_without_stiffness():
    trough = Plane(lambda x, y: 0.5 * (x - 3) ** 2, lambda x, y: (x - 3, 0.0), lambda x, y: [[1, 0], [0, 0]])
    outcome = find_minimum(trough, PATTERN, np.array([0.0, 5.0]), 1e-12, floor=1e-12)
    assert outcome.converged
    np.testing.assert_allclose(outcome.x, [3.0, 5.0])


def test_no_minimum_is_said():
    slope = Plane(lambda x, y: x - y, lambda x, y: (1.0, -1.0), lambda x, y: [[0, 0], [0, 0]])
    outcome = find_minimum(slope, PATTERN, np.zeros(2), 1e-9, max_iterations=50)
    assert not outcome.converged
    assert outcome.history[-1] > 1.0
