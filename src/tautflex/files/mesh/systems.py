"""Coordinate systems of files, and what is held in their directions as directions of the axes x, y, z."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from tautflex.errors import MeshError
from tautflex.files.mesh.raw_links import RawLink
from tautflex.numeric import Array
from tautflex.structure.groups import DIRECTIONS
from tautflex.structure.links.equation import LinkEquation

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


def held_directions(
    directions: Iterable[int], axes: Array | None, node: int, where: str
) -> tuple[tuple[str, ...], list[RawLink]]:
    """Names of held directions, and equations for those along axes that are not x, y or z.

    Parameters
    ----------
    directions
        0 to 5: three translations and three rotations in a system with ``axes`` as rows, shape (3, 3).
    axes
        None for the global ones.
    node
        Row of the node, for the equations.
    where
        Place for messages.
    """
    held, links = set(directions), list[RawLink]()
    if axes is not None:
        turned = set()
        for first in (0, 3):
            own = axes[[k for k in range(3) if first + k in held]]
            spanned = own.T @ own
            flags = np.diag(spanned) > 0.5
            if np.allclose(spanned, np.diag(flags), atol=_SQUARE):
                turned |= {first + k for k in range(3) if flags[k]}
            else:
                links += [RawLink(where, one) for one in _held_along(own, node, DIRECTIONS[first : first + 3])]
        held = turned
    return tuple(DIRECTIONS[k] for k in sorted(held)), links


def _held_along(directions: Array, node: int, names: tuple[str, ...]) -> Iterator[LinkEquation]:
    """Equations ``e . u = 0`` for independent directions e, shape (m, 3).

    Each is solved for a displacement that no other of them has.
    """
    _, triangle, order = qr(directions, mode="economic", pivoting=True)
    count = len(directions)
    of_rest = np.linalg.solve(triangle[:, :count], triangle[:, count:])
    for row, pivot in enumerate(order[:count]):
        weights = [(pivot, 1.0), *zip(order[count:], of_rest[row].tolist(), strict=True)]
        yield LinkEquation(tuple((node, names[k], weight) for k, weight in weights if abs(weight) > _ROUND_OFF))


def global_directions(directions: Iterable[int], axes: Array | None, where: str) -> tuple[str, ...]:
    """Names of directions as of `held_directions`; MeshError if they are not spanned by x, y and z."""
    found, turned = held_directions(directions, axes, 0, where)
    if turned:
        raise MeshError(
            f"{where}: expected directions along x, y or z, got one along turned axes; turn the whole model, or give "
            "all three directions of the node"
        )
    return found
