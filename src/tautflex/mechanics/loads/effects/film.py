"""Strain that the film would take if it were free: the stresses that hold it back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array

Region = tuple[float, float, float, float]


def free_strain(owner: str, system: StructuralSystem, strain: float, region: Region | None) -> dict[int, Array]:
    """Columns of `StressChange` of an equal free strain in all directions of the film, ``-D (strain, strain, 0)``.

    Parameters
    ----------
    owner
        Name of the input, for messages.
    system
        The structure.
    strain
        Free strain per unit of the input.
    region
        Lowest and highest x, lowest and highest y [m]: elements whose middle lies there; None is the whole film.

    Returns
    -------
    dict
        Block -> stress change per unit, shape (row, 3, 1).

    Raises
    ------
    InputError
        If there is no film, or none in the region.
    """
    blocks = system.block_index("membrane")
    if not blocks:
        raise InputError(f"{owner}: expected a model with a film, got none; add triangles to the model")
    free = strain * np.array([1.0, 1.0, 0.0])
    columns = {index: (-system.blocks[index].elasticity @ free)[:, :, None] for index in blocks}
    if region is None:
        return columns
    for index in blocks:
        inside = _inside(system.model.nodes[system.model.element_groups[index].connectivity].mean(axis=1), region)
        columns[index] *= system.blocks[index].rows_of(inside)[:, None, None]
    if not any(column.any() for column in columns.values()) and strain:
        raise InputError(
            f"region: expected film elements whose middle lies there, got none in {list(region)}; widen it"
        )
    return columns


def _inside(middle: Array, region: Sequence[float]) -> Array:
    """1 where a middle [m], shape (element, 3), lies in a region, else 0."""
    low_x, high_x, low_y, high_y = checks.float_array("region", region, (4,))
    x, y = middle[:, 0], middle[:, 1]
    return np.asarray((low_x <= x) & (x <= high_x) & (low_y <= y) & (y <= high_y), dtype=float)
