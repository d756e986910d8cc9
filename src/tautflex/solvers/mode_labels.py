"""Names for mode shapes of a rectangular membrane: half-waves (m, n) and symmetry [theory, section 6]."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import QhullError

from tautflex.checks import float_array, index_array

_NOISE = 0.1  # a lobe below this part of the largest one is no half-wave
_OUTSIDE = 0.1  # largest part of the bounding box that the nodes may leave uncovered


def half_wave_labels(
    nodes_xy: ArrayLike,
    w: ArrayLike,
    triangles: ArrayLike | None = None,
    in_plane: ArrayLike | None = None,
    separable: float = 0.5,
) -> tuple[int, int] | None:
    """Count the half-waves of a transverse shape along x and y.

    The shape, on a grid, is split into products of a function of x and a function of y (singular value
    decomposition); the half-waves are the lobes of the leading pair. Edges may move: a lobe counts from its
    sign, so a cosine of less than half a wave is one.

    Parameters
    ----------
    nodes_xy
        Positions of the membrane's nodes (node, 2 or more) [m]; x and y along the sides of the rectangle.
    w
        Transverse displacement of these nodes (node,), any unit.
    triangles
        Node numbers (t, 3) to interpolate in where the nodes form no grid; by default Delaunay's.
    in_plane
        In-plane displacement of the same nodes (node, 2), same unit: with more than half of the motion in the
        plane the shape has no label.
    separable
        Least part of the squared displacement that the leading product must hold.

    Returns
    -------
    (m, n) or None
        None for shapes that are zero, in-plane, flat (rigid) or no product of functions of x and y.

    Raises
    ------
    InputError
        If the arrays do not fit together or are not finite.
    """
    nodes = _points(nodes_xy)
    shape = float_array("w", w, (nodes.shape[0],))
    energy = float(shape @ shape)
    across = 0.0 if in_plane is None else float(np.sum(np.square(np.asarray(in_plane, dtype=np.float64))))
    if energy <= max(across, np.finfo(float).tiny) or _is_flat(nodes, shape):
        return None
    grid = _on_grid(nodes, shape, triangles)
    if grid is None:
        return None
    left, singular, right = np.linalg.svd(grid, full_matrices=False)
    if singular[0] ** 2 < separable * np.sum(singular**2):
        return None
    return _lobes(left[:, 0]), _lobes(right[0])


def symmetry_class(
    nodes_xy: ArrayLike, w: ArrayLike, triangles: ArrayLike | None = None, tolerance: float = 0.8
) -> str:
    """Return two letters: symmetry of a transverse shape under x -> -x, then under y -> -y.

    "S" symmetric, "A" antisymmetric, "-" neither. Reflections are about the middle of the nodes' bounding
    box. On a mesh whose cells are all cut along the same diagonal the symmetry is only approximate.

    Parameters
    ----------
    nodes_xy
        Positions of the membrane's nodes (node, 2 or more) [m].
    w
        Transverse displacement of these nodes (node,), any unit.
    triangles
        As for :func:`half_wave_labels`.
    tolerance
        Least correlation, in absolute value, of the shape with its reflection; 0.8 asks for 90 % of the
        squared displacement to be in the symmetric (or antisymmetric) part.

    Raises
    ------
    InputError
        If the arrays do not fit together or are not finite.
    """
    nodes = _points(nodes_xy)
    shape = float_array("w", w, (nodes.shape[0],))
    grid = _on_grid(nodes, shape, triangles)
    if grid is None or not np.any(grid):
        return "--"
    total = float(np.sum(grid**2))
    correlations = (float(np.sum(grid * grid[::-1])) / total, float(np.sum(grid * grid[:, ::-1])) / total)
    return "".join("S" if c >= tolerance else "A" if c <= -tolerance else "-" for c in correlations)


def _points(nodes_xy: ArrayLike) -> NDArray[np.float64]:
    return float_array("nodes_xy", np.asarray(nodes_xy, dtype=np.float64)[..., :2], (None, 2))


def _is_flat(nodes: NDArray[np.float64], shape: NDArray[np.float64]) -> bool:
    """Tell whether a plane a + b x + c y holds 99.9 % of the squared displacement."""
    plane = np.column_stack([np.ones(len(nodes)), nodes])
    fit, *_ = np.linalg.lstsq(plane, shape, rcond=None)
    return bool(np.sum((shape - plane @ fit) ** 2) < 1e-3 * np.sum(shape**2))


def _on_grid(
    nodes: NDArray[np.float64], shape: NDArray[np.float64], triangles: ArrayLike | None
) -> NDArray[np.float64] | None:
    """Sample a nodal field on an even grid (x, y) over the bounding box; None where that makes no sense."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    if nodes.shape[0] < 4 or np.any(high - low <= 1e-9 * np.max(high - low, initial=0.0)):
        return None
    fraction = (nodes - low) / (high - low)
    counts = _even_counts(fraction)
    if counts is not None:  # the mesh's own grid: no interpolation, no diagonal that breaks the symmetry
        index = np.rint(fraction * (np.array(counts) - 1)).astype(int)
        values = np.full(counts, np.nan)
        values[index[:, 0], index[:, 1]] = shape
        if not np.isnan(values).any():
            return values
    side = int(np.clip(2 * np.sqrt(nodes.shape[0]), 9, 81))
    axis = np.linspace(1e-9, 1 - 1e-9, side)
    if triangles is not None:
        corners = index_array("triangles", triangles, 3, nodes.shape[0])
        values = _interpolated(fraction[corners], shape[corners], axis)
    else:
        try:
            values = LinearNDInterpolator(fraction, shape)(*np.meshgrid(axis, axis, indexing="ij"))
        except QhullError:
            return None
    outside = np.isnan(values)
    return None if outside.mean() > _OUTSIDE else np.where(outside, 0.0, values)


def _interpolated(
    corners: NDArray[np.float64], values: NDArray[np.float64], axis: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Interpolate linearly in each triangle (t, 3, 2) at the grid points inside it; NaN outside all."""
    result = np.full((axis.size, axis.size), np.nan)
    first = np.searchsorted(axis, corners.min(axis=1) - 1e-9)
    last = np.searchsorted(axis, corners.max(axis=1) + 1e-9)
    for corner, value, (x0, y0), (x1, y1) in zip(corners, values, first, last, strict=True):
        sides = (corner[1:] - corner[0]).T
        if x0 == x1 or y0 == y1 or abs(np.linalg.det(sides)) < 1e-14:
            continue
        points = np.stack(np.meshgrid(axis[x0:x1], axis[y0:y1], indexing="ij"), axis=-1)
        second, third = np.moveaxis((points - corner[0]) @ np.linalg.inv(sides).T, -1, 0)
        inside = (second >= -1e-9) & (third >= -1e-9) & (second + third <= 1 + 1e-9)
        block = result[x0:x1, y0:y1]
        block[inside] = (value[0] + second * (value[1] - value[0]) + third * (value[2] - value[0]))[inside]
    return result


def _even_counts(fraction: NDArray[np.float64]) -> tuple[int, int] | None:
    """Numbers of grid lines along x and y if the nodes fill an evenly spaced grid."""
    counts = tuple(np.unique(np.round(fraction[:, axis], 6)).size for axis in (0, 1))
    if counts[0] * counts[1] != fraction.shape[0] or min(counts) < 2:
        return None
    steps = fraction * (np.array(counts) - 1)
    return (counts[0], counts[1]) if np.abs(steps - np.rint(steps)).max() < 1e-3 else None


def _lobes(values: NDArray[np.float64]) -> int:
    """Count the stretches of one sign, those below the noise ignored."""
    signs = np.sign(values[np.abs(values) > _NOISE * np.abs(values).max()])
    return 1 + int(np.count_nonzero(signs[1:] != signs[:-1]))
