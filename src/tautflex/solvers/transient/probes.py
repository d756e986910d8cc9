"""Measuring points: linear interpolation inside the film's triangles, or the nearest node."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.products import product
from tautflex.mechanics.system import StructuralSystem

Array = NDArray[np.float64]

READINGS = ("interpolate", "nearest-node")


@dataclass(frozen=True)
class ProbeSet:
    """Linear map from free unknowns to the displacements of named points.

    Parameters
    ----------
    names
        Names of the probes.
    positions
        Points actually read [m], shape (probe, 3).
    map
        Interpolation matrix, shape (3 probes, size).
    """

    names: tuple[str, ...]
    positions: Array
    map: csr_array

    def read(self, q: Array) -> Array:
        """Displacements (or velocities) of the probes, shape (probe, 3)."""
        return product(*self._rows, q).reshape(-1, 3)

    @cached_property
    def _rows(self) -> tuple[NDArray[np.int64], NDArray[np.uint32], Array]:
        return self.map.indptr.astype(np.int64), self.map.indices.astype(np.uint32), self.map.data


def place_probes(system: StructuralSystem, probes: Mapping[str, ArrayLike], reading: str = "interpolate") -> ProbeSet:
    """Locate probes on the structure.

    Parameters
    ----------
    system
        The structure.
    probes
        Name -> position (x, y) or (x, y, z) [m]; two numbers mean a point of the film seen along z.
    reading
        ``"interpolate"`` inside the triangle that contains the point, or ``"nearest-node"``.

    Returns
    -------
    ProbeSet

    Raises
    ------
    InputError
        If a probe lies outside the film, or there is no film to interpolate in.
    """
    checks.one_of("probe_reading", reading, READINGS)
    if not isinstance(probes, Mapping):
        raise InputError(f"probes: expected a mapping such as {{'A': (0.7, 0.4)}}, got {probes!r}")
    model = system.model
    triangles = model.triangles
    candidates = np.unique(triangles) if len(triangles) else np.arange(len(model.nodes))
    rows, columns, values, positions = [], [], [], []
    for number, (name, position) in enumerate(probes.items()):
        try:
            point = np.asarray(position, dtype=float).ravel()
        except (TypeError, ValueError):
            point = np.zeros(0)
        if point.size not in (2, 3) or not np.all(np.isfinite(point)):
            raise InputError(f"probes.{name}: expected two or three finite coordinates [m], got {position!r}")
        if reading == "nearest-node" or not len(triangles):
            offset = model.nodes[candidates][:, : point.size] - point
            nodes, weights = np.array([candidates[int(np.argmin(np.sum(offset**2, axis=1)))]]), np.ones(1)
        else:
            nodes, weights = _containing_triangle(model.nodes, triangles, name, point)
        positions.append(weights @ model.nodes[nodes])
        for node, weight in zip(nodes, weights, strict=True):
            for axis in range(3):
                slot = int(system.place[model.translation_dofs[node, axis]])
                if slot < system.size:
                    rows.append(3 * number + axis)
                    columns.append(slot)
                    values.append(float(weight))
    shape = (3 * len(probes), system.size)
    matrix = csr_array((values, (rows, columns)), shape=shape)
    return ProbeSet(tuple(probes), np.array(positions).reshape(-1, 3), matrix)


def _containing_triangle(
    nodes: Array, triangles: NDArray[np.int64], name: str, point: Array
) -> tuple[NDArray[np.int64], Array]:
    """Nodes and area coordinates of the triangle under a point."""
    corners = nodes[triangles][:, :, :2]
    edge = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    determinant = edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0]
    usable = np.abs(determinant) > 1e-14 * np.abs(edge).max() ** 2
    offset = point[:2] - corners[:, 0]
    safe = np.where(usable, determinant, 1.0)
    second = (offset[:, 0] * edge[:, 1, 1] - offset[:, 1] * edge[:, 0, 1]) / safe
    third = (offset[:, 1] * edge[:, 0, 0] - offset[:, 0] * edge[:, 1, 0]) / safe
    share = np.stack([1.0 - second - third, second, third], axis=1)
    inside = usable & (share.min(axis=1) >= -1e-9)
    if point.size == 3:
        height = np.einsum("nc,nc->n", share, nodes[triangles][:, :, 2])
        inside &= np.abs(height - point[2]) <= 1e-6 * np.ptp(nodes, axis=0).max()
    found = np.flatnonzero(inside)
    if not found.size:
        used = nodes[np.unique(triangles)]
        low, high = used.min(axis=0), used.max(axis=0)
        raise InputError(
            f"probes.{name}: expected a point on the film ({low[0]:g} <= x <= {high[0]:g}, {low[1]:g} <= y <= "
            f"{high[1]:g} m), got {point.tolist()}; the origin is at the antenna's centre"
        )
    best = int(found[0])
    return triangles[best], np.clip(share[best], 0.0, 1.0)
