"""Coordinate systems of files, and what is held in their directions as directions of the axes x, y, z."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from tautflex.numeric import Array
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.equation import LinkEquation
from tautflex.structure.links.link import Link

_SQUARE = 1e-9
_ROUND_OFF = 1e-12


@dataclass(frozen=True)
class System:
    """Rectangular (R), cylindrical (C) or spherical (S) system: origin and axes as rows, in basic coordinates."""

    kind: str
    origin: Array
    axes: Array

    def position(self, coordinates: Array) -> Array:
        """Point in basic coordinates; angles in degrees: (r, theta, z), or (r, theta from z, phi)."""
        first, second, third = coordinates
        if self.kind == "C":
            turn = np.radians(second)
            coordinates = np.array([first * np.cos(turn), first * np.sin(turn), third])
        elif self.kind == "S":
            tilt, turn = np.radians([second, third])
            ring = first * np.sin(tilt)
            coordinates = np.array([ring * np.cos(turn), ring * np.sin(turn), first * np.cos(tilt)])
        return np.asarray(self.origin + coordinates @ self.axes)

    def directions(self, point: Array) -> Array:
        """Unit vectors of the system at a point in basic coordinates, as rows; those of its origin on its axis."""
        if self.kind == "R":
            return self.axes
        x, y, z = self.axes @ (point - self.origin)
        ring = np.hypot(x, y)
        cosine, sine = (x / ring, y / ring) if ring > 0.0 else (1.0, 0.0)
        around = np.array([-sine, cosine, 0.0])
        if self.kind == "C":
            local = np.array([[cosine, sine, 0.0], around, [0.0, 0.0, 1.0]])
        else:
            radius = np.hypot(ring, z)
            height, width = (z / radius, ring / radius) if radius > 0.0 else (1.0, 0.0)
            out = np.array([width * cosine, width * sine, height])
            local = np.array([out, [height * cosine, height * sine, -width], around])
        return np.asarray(local @ self.axes)


def held_directions(directions: Iterable[int], axes: Array | None, node: int) -> tuple[tuple[str, ...], list[Link]]:
    """Names of held directions, and equations for those along axes that are not x, y or z.

    Parameters
    ----------
    directions
        0 to 5: three translations and three rotations in a system with ``axes`` as rows, shape (3, 3).
    axes
        None for the global ones.
    node
        Number of the node, for the equations.
    """
    held, links = set(directions), list[Link]()
    if axes is not None:
        turned = set()
        for first in (0, 3):
            own = axes[[k for k in range(3) if first + k in held]]
            spanned = own.T @ own
            flags = np.diag(spanned) > 0.5
            if np.allclose(spanned, np.diag(flags), atol=_SQUARE):
                turned |= {first + k for k in range(3) if flags[k]}
            else:
                links += equal_along(own, node, None, DIRECTIONS[first : first + 3])
        held = turned
    return tuple(DIRECTIONS[k] for k in sorted(held)), links


def equal_along(kept: Array, node: int, other: int | None, names: tuple[str, ...]) -> Iterator[LinkEquation]:
    """Equations ``e . (u - u_other) = 0`` for independent directions e, shape (m, 3); ``u_other = 0`` for None.

    Each is solved for a displacement of ``node`` that no other of them is solved for.
    """
    _, triangle, order = qr(kept, mode="economic", pivoting=True)
    count = len(kept)
    of_rest = np.linalg.solve(triangle[:, :count], triangle[:, count:])
    for row, pivot in enumerate(order[:count]):
        weights = [(pivot, 1.0), *zip(order[count:], of_rest[row].tolist(), strict=True)]
        terms = [(node, names[k], weight) for k, weight in weights if abs(weight) > _ROUND_OFF]
        if other is not None:
            terms += [(other, names[k], -weight) for k, weight in weights if abs(weight) > _ROUND_OFF]
        yield LinkEquation(tuple(terms))
