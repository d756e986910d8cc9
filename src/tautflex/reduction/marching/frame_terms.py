"""Terms of the moving frame for many steps at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev

from tautflex.mechanics.inertia import LoadMoments
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.numeric import Array
from tautflex.reduction.polynomial.forces import FrameTerms

# Highest polynomial degree that is tried before every instant is computed by itself.
_DEGREES = (2, 4, 8, 16, 32, 64)
_ACCURACY = 1e-13
# Samples that are read at once: at fixed places, so that no reading depends on where a run begins and ends.
BLOCK = 256
Span = tuple[float, float, int]


def sample(function: Callable[[float], Array], times: Array, span: Span) -> Array:
    """Values of a smooth function at many instants, shape (time, value), or (1, value) if it is constant.

    Interpolated at Chebyshev points once the next finer set of points agrees to round-off; a segment of a maneuver is
    analytic, so few points do. Functions that do not give in are computed at every instant. ``span`` has the limits of
    the interpolation and the number of instants that it is meant for, of which ``times`` may be some.
    """
    low, high, count = span
    if count <= 8:
        return np.array([function(time) for time in times])
    known: dict[float, Array] = {}

    def at(place: float) -> Array:
        key = round(place, 12)
        if key not in known:
            known[key] = function(low + 0.5 * (place + 1.0) * (high - low))
        return known[key]

    for degree in _DEGREES:
        if 2 * degree >= count:
            break
        points = np.cos(np.pi * np.arange(degree + 1) / degree)
        finer = np.cos(np.pi * (np.arange(degree) + 0.5) / degree)
        values, checks = np.array([at(x) for x in points]), np.array([at(x) for x in finer])
        scale = np.abs(values).max(axis=0) + np.abs(checks).max(axis=0)
        series = chebyshev.chebfit(points, values, degree)
        if np.all(np.abs(chebyshev.chebval(finer, series).T - checks) <= _ACCURACY * scale * degree):
            if np.all(values == values[0]) and np.all(checks == values[0]):
                return values[:1]
            return np.asarray(chebyshev.chebval(2.0 * (times - low) / (high - low) - 1.0, series).T, dtype=np.float64)
    return np.array([function(time) for time in times])


def in_blocks(read: Callable[..., Array], before: int, *rows: Array) -> Array:
    """Readings of samples, whose rows are given, in blocks at fixed places; ``before`` samples came earlier."""
    lead, count = before % BLOCK, len(rows[0])
    if not count:
        return read(*rows)
    found = np.zeros(0)
    for first in range(-lead, count, BLOCK):
        padded = np.arange(first, first + BLOCK).clip(0, count - 1)
        block, start, end = read(*(part[padded] for part in rows)), max(first, 0), min(first + BLOCK, count)
        if first == -lead:
            found = np.empty((count, *block.shape[1:]))
        found[start:end] = block[start - first : end - first]
    return found


def frame_terms(
    coupling: Coupling,
    moments: LoadMoments,
    segment: Segment,
    times: Array,
    coordinates: int,
    span: Span,
) -> FrameTerms:
    """Matrices and loads of a segment at instants [s] in order; ``moments`` of the coordinates, then the monomials.

    ``span`` is that of `sample`.
    """

    def terms(time: float) -> Array:
        motion = segment.motion(time)
        weights = coupling.velocity_weight(motion), coupling.displacement_weight(motion)
        return np.concatenate([*(weight.ravel() for weight in weights), coupling.load(motion, moments)])

    values = sample(terms, times, span)
    velocity, displacement = values[:, :9].reshape(-1, 3, 3), values[:, 9:18].reshape(-1, 3, 3)
    load, stress = values[:, 18 : 18 + coordinates], values[:, 18 + coordinates :]
    turns = bool(np.any(values[:, :18]))
    return FrameTerms(velocity.copy(), displacement.copy(), load.copy(), stress.copy(), turns)


def frame_at(coupling: Coupling, moments: LoadMoments, motion: RigidMotion, coordinates: int) -> FrameTerms:
    """Matrices and loads of one motion."""
    segment = Segment(0.0, np.inf, lambda time: motion)
    return frame_terms(coupling, moments, segment, np.zeros(1), coordinates, (0.0, 0.0, 1))
