"""Names for mode shapes of a rectangular membrane: half-waves (m, n) and symmetry [theory, section 6]."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.spatial import Delaunay, QhullError

from tautflex.checks import float_array
from tautflex.numeric import Array

_NOISE = 0.1  # a lobe below this part of the largest one is no half-wave
_OUTSIDE = 0.1  # largest part of the bounding box that the nodes may leave uncovered


class FilmSampler:
    """Samples nodal fields on an even grid over the nodes' bounding box; build it once for many shapes.

    ``nodes_xy`` are positions of the membrane's nodes (node, 2 or more) [m], x and y along the sides of the rectangle;
    InputError if they have the wrong shape or are not finite.
    """

    def __init__(self, nodes_xy: ArrayLike) -> None:
        self.nodes = float_array("nodes_xy", np.asarray(nodes_xy, dtype=np.float64)[..., :2], (None, 2))
        self._shape, self._map = self._build()

    def _build(self) -> tuple[tuple[int, int], csr_array | None]:
        low, high = self.nodes.min(axis=0), self.nodes.max(axis=0)
        if len(self.nodes) < 4 or np.any(high - low <= 1e-9 * np.max(high - low, initial=0.0)):
            return (0, 0), None
        fraction = (self.nodes - low) / (high - low)
        counts = _even_counts(fraction)
        if counts is not None:  # the mesh's own grid: no interpolation, no diagonal that breaks the symmetry
            index = np.rint(fraction * (np.array(counts) - 1)).astype(int)
            row = np.ravel_multi_index(tuple(index.T), counts)
            if np.unique(row).size == row.size:
                return counts, csr_array((np.ones(row.size), (row, np.arange(row.size))))
        side = int(np.clip(2 * np.sqrt(len(self.nodes)), 9, 81))
        axis = np.linspace(1e-9, 1 - 1e-9, side)
        points = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
        return (side, side), _linear_map(fraction, points)

    def sample(self, w: ArrayLike) -> Array | None:
        """Field (node,) on the grid (x, y); None where the nodes do not fill a rectangle."""
        if self._map is None:
            return None
        return np.asarray(self._map @ np.asarray(w, dtype=np.float64)).reshape(self._shape)


def half_wave_labels(
    film: FilmSampler | ArrayLike,
    w: ArrayLike,
    in_plane: ArrayLike | None = None,
    separable: float = 0.5,
) -> tuple[int, int] | None:
    """Count the half-waves (m, n) of a transverse shape along x and y.

    The shape, on a grid, is split into products of a function of x and a function of y (singular value decomposition);
    the half-waves are the lobes of the leading pair, which must hold the part ``separable`` of the squared
    displacement. Edges may move: a lobe counts from its sign, so a cosine of less than half a wave is one.

    ``film`` is a `FilmSampler`, or the positions of the membrane's nodes (node, 2 or more) [m]; ``w`` their transverse
    displacement (node,) and ``in_plane`` (node, 2) that in the plane, any unit. None for shapes that are zero, mostly
    in-plane, flat (rigid) or no product of functions of x and y; InputError if the arrays do not fit together or are
    not finite.
    """
    sampler = film if isinstance(film, FilmSampler) else FilmSampler(film)
    shape = float_array("w", w, (len(sampler.nodes),))
    energy = float(shape @ shape)
    across = 0.0 if in_plane is None else float(np.sum(np.square(np.asarray(in_plane, dtype=np.float64))))
    if energy <= max(across, np.finfo(float).tiny) or _is_flat(sampler.nodes, shape):
        return None
    grid = sampler.sample(shape)
    if grid is None:
        return None
    left, singular, right = np.linalg.svd(grid, full_matrices=False)
    if singular[0] ** 2 < separable * np.sum(singular**2):
        return None
    return _lobes(left[:, 0]), _lobes(right[0])


def symmetry_class(film: FilmSampler | ArrayLike, w: ArrayLike, tolerance: float = 0.8) -> str:
    """Return two letters: symmetry of a transverse shape under x -> -x, then under y -> -y; arguments as above.

    "S" symmetric, "A" antisymmetric, "-" neither. Reflections are about the middle of the nodes' bounding box. On a
    mesh whose cells are all cut along the same diagonal the symmetry is only approximate. ``tolerance`` is the least
    correlation, in absolute value, of the shape with its reflection; 0.8 asks for 90 % of the squared displacement to
    be in the symmetric (or antisymmetric) part.
    """
    sampler = film if isinstance(film, FilmSampler) else FilmSampler(film)
    shape = float_array("w", w, (len(sampler.nodes),))
    grid = sampler.sample(shape)
    if grid is None or not np.any(grid):
        return "--"
    total = float(np.sum(grid**2))
    correlations = (float(np.sum(grid * grid[::-1])) / total, float(np.sum(grid * grid[:, ::-1])) / total)
    return "".join("S" if c >= tolerance else "A" if c <= -tolerance else "-" for c in correlations)


def _is_flat(nodes: Array, shape: Array) -> bool:
    """Tell whether a plane a + b x + c y holds 99.9 % of the squared displacement."""
    plane = np.column_stack([np.ones(len(nodes)), nodes])
    fit, *_ = np.linalg.lstsq(plane, shape, rcond=None)
    return bool(np.sum((shape - plane @ fit) ** 2) < 1e-3 * np.sum(shape**2))


def _linear_map(nodes: Array, points: Array) -> csr_array | None:
    """Piecewise linear interpolation (point, node); points outside read zero, None if there are too many."""
    try:
        mesh = Delaunay(nodes)
    except QhullError:
        return None
    simplex = mesh.find_simplex(points, tol=1e-9)
    inside = np.flatnonzero(simplex >= 0)
    if len(points) - inside.size > _OUTSIDE * len(points):
        return None
    corners = mesh.simplices[simplex[inside]]
    base, first, second = nodes[corners[:, 2]], nodes[corners[:, 0]], nodes[corners[:, 1]]
    (ax, ay), (bx, by), (px, py) = (first - base).T, (second - base).T, (points[inside] - base).T
    area = ax * by - ay * bx
    share = np.stack([px * by - py * bx, ax * py - ay * px], axis=1) / area[:, None]
    weights = np.column_stack([share, 1.0 - share.sum(axis=1)])
    rows = np.repeat(inside, 3)
    return csr_array((weights.ravel(), (rows, corners.ravel())), shape=(len(points), len(nodes)))


def _even_counts(fraction: Array) -> tuple[int, int] | None:
    """Numbers of grid lines along x and y if the nodes fill an evenly spaced grid."""
    counts = tuple(np.unique(np.round(fraction[:, axis], 6)).size for axis in (0, 1))
    if counts[0] * counts[1] != fraction.shape[0] or min(counts) < 2:
        return None
    steps = fraction * (np.array(counts) - 1)
    return (counts[0], counts[1]) if np.abs(steps - np.rint(steps)).max() < 1e-3 else None


def _lobes(values: Array) -> int:
    """Count the stretches of one sign, those below the noise ignored."""
    signs = np.sign(values[np.abs(values) > _NOISE * np.abs(values).max()])
    return 1 + int(np.count_nonzero(signs[1:] != signs[:-1]))
