"""Local axes of elements: the conventions that given stresses and second moments of area are read in."""

from __future__ import annotations

import numpy as np
import pytest

from tautflex.elements.axes import film_axes, line_axes

UP = np.array([0.0, 0.0, 1.0])
ALONG_X = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("span", "expected"),
    [
        ((2.0, 0, 0), [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ((0, 2.0, 0), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        ((-2.0, 0, 0), [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
        # Along the orientation vector, global y takes its place.
        ((0, 0, 2.0), [[0, 0, 1], [1, 0, 0], [0, 1, 0]]),
        ((3.0, 0, 4.0), [[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]]),
    ],
)
def test_axes_of_lines(span, expected):
    start = np.array([0.3, -0.2, 0.1])
    axes, length = line_axes(np.array([[start, start + span]]), UP)
    np.testing.assert_allclose(axes[0], expected, atol=1e-15)
    assert length[0] == pytest.approx(np.linalg.norm(span), rel=1e-14)


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 1, 0]])
@pytest.mark.parametrize(
    ("corners", "area", "expected"),
    [
        # In z = 0 the normal points up whatever the order of the corners.
        ([[0, 0, 0], [2, 1, 0], [0, 3, 0]], 3.0, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        # Normal to the orientation vector, global y takes its place.
        ([[0, 0, 0], [0, 2, 0], [0, 0, 3]], 3.0, [[0, 1, 0], [0, 0, 1], [1, 0, 0]]),
        ([[0, 0, 0], [2, 0, 0], [0, 0, 3]], 3.0, [[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
        ([[0, 0, 0], [4, 0, 3], [0, 2, 0]], 5.0, [[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]]),
    ],
)
def test_axes_of_films(corners, area, expected, order):
    points = np.array(corners, dtype=float)[order]
    axes, stretch = film_axes((points[1:] - points[0])[None], ALONG_X)
    np.testing.assert_allclose(axes[0], expected, atol=1e-15)
    assert stretch[0] == pytest.approx(2.0 * area, rel=1e-14)
