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
    """Forces of two unknowns and their derivative, by columns."""

    def __init__(self, forces: Callable, slopes: Callable) -> None:
        self._forces, self._slopes = forces, slopes

    def residual(self, x: Array) -> tuple[Array, float]:
        forces = np.array(self._forces(*x), dtype=float)
        return forces, float(np.linalg.norm(forces))

    def tangent(self, x: Array) -> Array:
        return np.array(self._slopes(*x), dtype=float).T.ravel()


def test_curved_valley():
    valley = Plane(
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
        lambda x, y: (4 * x * (x * x - 1), 2 * y),
        lambda x, y: [[12 * x * x - 4, 0], [0, 2]],
    )
    outcome = find_minimum(wells, PATTERN, np.array([start, 0.3]), 1e-10)
    assert outcome.converged
    np.testing.assert_allclose(outcome.x, [well, 0.0], atol=1e-9)


def test_a_floor_carries_directions_without_stiffness():
    trough = Plane(lambda x, y: (x - 3, 0.0), lambda x, y: [[1, 0], [0, 0]])
    outcome = find_minimum(trough, PATTERN, np.array([0.0, 5.0]), 1e-12, floor=1e-12)
    assert outcome.converged
    np.testing.assert_allclose(outcome.x, [3.0, 5.0])


def test_forces_without_a_potential_find_their_balance():
    """A spring with a force that turns: round a closed path it does work, and its derivative is not symmetric."""
    turning = Plane(lambda x, y: (x + 2 * y - 1, y - 2 * x), lambda x, y: [[1, 2], [-2, 1]])
    outcome = find_minimum(turning, PATTERN, np.array([3.0, -4.0]), 1e-12)
    assert outcome.converged
    np.testing.assert_allclose(outcome.x, [0.2, 0.4], atol=1e-11)


def test_no_minimum_is_said():
    slope = Plane(lambda x, y: (1.0, -1.0), lambda x, y: [[0, 0], [0, 0]])
    outcome = find_minimum(slope, PATTERN, np.zeros(2), 1e-9, max_iterations=50)
    assert not outcome.converged
    assert outcome.history[-1] > 1.0
