"""Which surface element lies under a point, and what its nodes weigh there."""

from __future__ import annotations

import numpy as np

from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.shapes import Shape

_EDGE = 1e-9  # local coordinates this far outside still belong to the element
_ITERATIONS = 30


def locate(shape: Shape, nodes: Array, connectivity: Indices, point: Array) -> tuple[int, Array] | None:
    """Find the element under a point, seen along z.

    The point is (x, y) or (x, y, z) [m]; three numbers ask for an element that passes through it. The first such
    element and the values of its interpolation functions there, shape (node,), or None. ``nodes`` [m] has shape (node,
    3), ``connectivity`` (element, node).
    """
    corner = nodes[connectivity]
    local, usable = _affine(shape, corner, point)
    straight = len(shape.nodes) == shape.dimension + 1
    if not straight:
        local, met = _refined(shape, corner, local, point)
        usable &= met
    inside = usable & (_depth(shape, local) >= -_EDGE)
    if point.size == 3:
        height = np.einsum("ni,ni->n", shape.functions(np.where(inside[:, None], local, 0.0)), corner[:, :, 2])
        inside &= np.abs(height - point[2]) <= 1e-6 * np.ptp(nodes, axis=0).max()
    found = np.flatnonzero(inside)
    if not found.size:
        return None
    best = int(found[0])
    weights = shape.functions(local[best : best + 1])[0]
    # Round-off at an edge must not extrapolate where the functions are shares.
    return best, np.clip(weights, 0.0, 1.0) if len(shape.nodes) == shape.corners else weights


def _affine(shape: Shape, corner: Array, point: Array) -> tuple[Array, Mask]:
    """Local coordinates from the parallelogram of three corners, (element, 2), and where that has an area."""
    first, last = corner[:, 1, :2] - corner[:, 0, :2], corner[:, shape.corners - 1, :2] - corner[:, 0, :2]
    determinant = first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0]
    largest = max(float(np.abs(first).max(initial=0.0)), float(np.abs(last).max(initial=0.0)))
    usable = np.abs(determinant) > 1e-14 * largest**2
    offset, safe = point[:2] - corner[:, 0, :2], np.where(usable, determinant, 1.0)
    along_first = (offset[:, 0] * last[:, 1] - offset[:, 1] * last[:, 0]) / safe
    along_last = (offset[:, 1] * first[:, 0] - offset[:, 0] * first[:, 1]) / safe
    share = np.stack([along_first, along_last], axis=1)
    return share if shape.domain == "triangle" else 2.0 * share - 1.0, usable


def _refined(shape: Shape, corner: Array, local: Array, point: Array) -> tuple[Array, Mask]:
    """Newton's method for local coordinates of elements near the point; whether each found it."""
    middle = 0.5 * (corner[:, :, :2].max(axis=1) + corner[:, :, :2].min(axis=1))
    reach = np.ptp(corner[:, :, :2], axis=1)  # twice the half size: sides may bulge beyond their nodes
    near = np.flatnonzero(np.all(np.abs(point[:2] - middle) <= reach, axis=1))
    result, met = local.copy(), np.zeros(len(corner), dtype=bool)
    for element in near:
        at, positions = np.clip(local[element], -1.0, 1.0), corner[element, :, :2]
        for _ in range(_ITERATIONS):
            miss = point[:2] - shape.functions(at[None])[0] @ positions
            slope = positions.T @ shape.slopes(at[None])[0]
            determinant = slope[0, 0] * slope[1, 1] - slope[0, 1] * slope[1, 0]
            if abs(determinant) <= 1e-14 * np.abs(slope).max() ** 2:
                break
            step = np.linalg.solve(slope, miss)
            at = np.clip(at + step, -3.0, 3.0)
            if np.abs(step).max() < 1e-13:
                met[element] = True
                break
        result[element] = at
    return result, met


def _depth(shape: Shape, local: Array) -> Array:
    """Smallest distance to the sides of the local domain, negative outside, shape (element,)."""
    if shape.domain == "triangle":
        area = np.column_stack([1.0 - local[:, 0] - local[:, 1], local])
        return np.asarray(area.min(axis=1))
    return np.asarray(1.0 - np.abs(local).max(axis=1))
