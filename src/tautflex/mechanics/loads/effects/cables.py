"""Cables that an input acts on: which, and their stresses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.model import Model

AXES = ("x", "y", "z")


def cables_along(model: Model, axis: int) -> Mask:
    """Cables that run mainly along an axis, shape (c,)."""
    ends = model.nodes[model.cables]
    along = np.abs(ends[:, 1] - ends[:, 0])
    return along[:, axis] >= along.max(axis=1) * (1.0 - 1e-12)


def chosen_cables(owner: str, system: StructuralSystem, cables: Sequence[int] | str | None) -> Indices:
    """Numbers of the cables that are meant: all, those along an axis, or given ones, each once.

    Raises
    ------
    InputError
        If there is none, one is not in the model, or one stands twice.
    """
    count = len(system.model.cables)
    if not count:
        raise InputError(f"{owner}: expected a model with cables, got none; add cables to the model")
    if cables is None:
        return np.arange(count)
    if isinstance(cables, str):
        along = {axis: np.flatnonzero(cables_along(system.model, number)) for number, axis in enumerate(AXES)}
        there = ", ".join(f"{axis!r} ({rows.size})" for axis, rows in along.items() if rows.size)
        if cables not in AXES or not along[cables].size:
            text = f"cables: expected the axis of some, {there} here, or their numbers, got {cables!r}"
            raise InputError(f"{text}; leave it out for all {count}")
        return along[cables]
    chosen = checks.indices("cables", cables, count, "cable")
    if not chosen.size or len(np.unique(chosen)) < chosen.size:
        raise InputError(f"cables: expected at least one cable, every one once, got {chosen.tolist()}")
    return chosen


def of_cables(system: StructuralSystem, values: Sequence[Array]) -> Array:
    """Values of all cables from those of all blocks, shapes (element, ...)."""
    return np.concatenate([values[index] for index in system.block_index("cable")])


def by_block(system: StructuralSystem, values: Array) -> dict[int, Array]:
    """Values of all cables, shape (c, ...), by the number of their block."""
    index = system.block_index("cable")
    ends = np.cumsum([len(system.blocks[block].dofs) for block in index])[:-1]
    return dict(zip(index, np.split(values, ends), strict=True))


def cable_columns(system: StructuralSystem, chosen: Indices, tension: Array) -> dict[int, Array]:
    """Stresses of the cables' blocks that are tensions [N] of the chosen ones, (chosen, n); (element, 1, n)."""
    area = of_cables(system, [block.size for block in system.blocks])
    columns = np.zeros((area.size, 1, tension.shape[1]))
    columns[chosen, 0] = tension / area[chosen, None]
    return by_block(system, columns)
