"""Local axes of lines and films: what given stresses and second moments of area are read in."""

from __future__ import annotations

import numpy as np

from tautflex.numeric import Array


def line_axes(ends: Array, direction: Array) -> tuple[Array, Array]:
    """Local axes as rows, the first along the element, shape (element, 3, 3), and lengths [m], shape (element,).

    ``ends`` are the positions of both ends [m], shape (element, 2, 3). Local z is the part of ``direction``, shape (3,)
    or (element, 3), normal to the element; where it is parallel, global y is used instead.
    """
    span = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(span, axis=1)
    along = span / length[:, None]
    third = direction - np.sum(along * direction, axis=1)[:, None] * along
    parallel = np.linalg.norm(third, axis=1) < 1e-6 * np.linalg.norm(direction, axis=-1)
    third[parallel] = np.array([0.0, 1.0, 0.0]) - along[parallel, 1:2] * along[parallel]
    third /= np.linalg.norm(third, axis=1)[:, None]
    return np.stack([along, np.cross(third, along), third], axis=1), length


def film_axes(tangents: Array, direction: Array) -> tuple[Array, Array]:
    """Local axes of films as rows, shape (n, 3, 3), the normal's last non-zero component positive, and their stretch.

    The stretch [m^2], shape (n,), is the area of the parallelogram of two vectors in each film: ``tangents``,
    derivatives of the position along two local coordinates [m], such as two sides of a triangle, shape (n, 2, 3). Local
    x is the projection of ``direction`` on the film; where it is normal to the film, global y is projected instead.
    """
    normal = np.cross(tangents[:, 0], tangents[:, 1])
    stretch = np.linalg.norm(normal, axis=1)
    normal /= stretch[:, None]
    sign = np.ones(len(normal))
    for component in (0, 1, 2):
        clear = np.abs(normal[:, component]) > 1e-9
        sign[clear] = np.sign(normal[clear, component])
    normal *= sign[:, None]
    first = direction - np.sum(normal * direction, axis=1)[:, None] * normal
    flat = np.linalg.norm(first, axis=1) < 1e-6 * np.linalg.norm(direction)
    first[flat] = np.array([0.0, 1.0, 0.0]) - normal[flat, 1:2] * normal[flat]
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normal, first), normal], axis=1), stretch
