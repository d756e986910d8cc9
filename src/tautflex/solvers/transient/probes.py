"""Measuring points: interpolated inside the film's elements, as these do themselves, or the nearest node."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.products import product
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices, Places
from tautflex.structure.locate import locate
from tautflex.structure.model import Model

READINGS = ("interpolate", "nearest-node")
# Part of the structure's size within which a node is meant.
_NEAR = 1e-6


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
        return product(*self.rows, q).reshape(-1, 3)

    @cached_property
    def rows(self) -> tuple[Indices, Places, Array]:
        """The map in compressed rows for compiled code: starts, columns and values."""
        return self.map.indptr.astype(np.int64), self.map.indices.astype(np.uint32), self.map.data


def place_probes(system: StructuralSystem, probes: Mapping[str, ArrayLike], reading: str = "interpolate") -> ProbeSet:
    """Locate probes on the structure.

    Parameters
    ----------
    system
        The structure.
    probes
        Name -> position (x, y) or (x, y, z) [m], two numbers seen along z: a node, of the frame for one, or any point
        of the film.
    reading
        ``"interpolate"`` inside the film element that contains the point, or ``"nearest-node"`` of the film.

    Returns
    -------
    ProbeSet

    Raises
    ------
    InputError
        If a probe lies outside the film and away from the nodes.
    """
    checks.one_of("probe_reading", reading, READINGS)
    if not isinstance(probes, Mapping):
        raise InputError(f"probes: expected a mapping such as {{'A': (0.7, 0.4)}}, got {probes!r}")
    model = system.model
    rows, columns, values, positions = [], [], [], []
    for number, (name, position) in enumerate(probes.items()):
        point = checks.numbers(f"probes.{name}", position).ravel()
        if point.size not in (2, 3) or not np.all(np.isfinite(point)):
            raise InputError(f"probes.{name}: expected two or three finite coordinates [m], got {position!r}")
        nodes, weights = read_at(model, f"probes.{name}", point, reading)
        positions.append(weights @ model.nodes[nodes])
        for axis in range(3):
            rows += [3 * number + axis] * len(nodes)
            columns += model.translation_dofs[nodes, axis].tolist()
            values += weights.tolist()
    matrix = csr_array((values, (rows, columns)), shape=(3 * len(probes), model.dof_count)) @ system.expansion
    matrix.sort_indices()
    return ProbeSet(tuple(probes), np.array(positions).reshape(-1, 3), matrix)


def read_at(model: Model, name: str, point: Array, reading: str = "interpolate") -> tuple[Indices, Array]:
    """Nodes and weights that a displacement at a point is read with; InputError, about ``name``, if there are none."""
    away = np.linalg.norm(model.nodes[:, : point.size] - point, axis=1)
    nearest = int(away.argmin())
    if away[nearest] > _NEAR * np.ptp(model.nodes, axis=0).max():
        if reading == "interpolate" and model.surfaces:
            return _on_film(model, name, point, nearest)
        if reading == "interpolate":
            x, y, z = model.nodes[nearest]
            raise InputError(
                f"{name}: expected the position of a node, because there is no film to interpolate in, got "
                f"{point.tolist()}; the nearest is node {nearest} at ({x:g}, {y:g}, {z:g}) m: give that, or set "
                "probe_reading = 'nearest-node'"
            )
        if model.surfaces:
            film = np.unique(model.triangles)
            nearest = int(film[away[film].argmin()])
    return np.array([nearest]), np.ones(1)


def _on_film(model: Model, name: str, point: Array, nearest: int) -> tuple[Indices, Array]:
    """Nodes and weights of the film element under a point."""
    for group in model.surfaces:
        found = locate(group.shape, model.nodes, group.connectivity, point)
        if found is not None:
            element, weights = found
            return group.connectivity[element], weights
    used = model.nodes[np.unique(model.triangles)]
    low, high = used.min(axis=0), used.max(axis=0)
    x, y, z = model.nodes[nearest]
    raise InputError(
        f"{name}: expected a point on the film ({low[0]:g} <= x <= {high[0]:g}, {low[1]:g} <= y <= {high[1]:g} m) or a "
        f"node, got {point.tolist()}; the nearest is node {nearest} at ({x:g}, {y:g}, {z:g}) m"
    )
