"""Element blocks whose unknowns are the coordinates of a basis: the project's kernel then serves a reduced model.

An element is data, ``g = G q``. On a basis ``q = V eta`` it is the same element with the gradient matrix ``G V_e`` and
the coordinates as its unknowns, and a weight on it is a factor on its measure. So forces, energies, tangents and laws
of a reduced structure come out of the very kernel that serves the full one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.elements.block import ElementBlock
from tautflex.mechanics.store import build_store
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Places

_OF_ROWS = ("gradient", "elasticity", "initial_stress", "measure", "size", "axes")
Store = tuple[NDArray[np.generic], ...]


def basis_blocks(system: StructuralSystem, vectors: Array) -> list[ElementBlock]:
    """All blocks on a basis (r, size), their initial stress that of the prestressed structure.

    Gradient matrices are of shape (row, gradient, r); a row has no owner any more.
    """
    extended = np.concatenate([vectors, np.zeros((len(vectors), 1))], axis=1)
    return [
        replace(
            block,
            gradient=np.matmul(block.gradient, extended[:, places].transpose(1, 2, 0)),
            dofs=np.broadcast_to(np.arange(len(vectors)), (len(places), len(vectors))),
            initial_stress=stress,
            owner=None,
        )
        for block, places, stress in zip(system.blocks, system.row_places, system.initial_stress, strict=True)
    ]


def chosen_blocks(blocks: list[ElementBlock], weights: Array) -> list[ElementBlock]:
    """Rows with a positive weight, their measures times the weights (row,) of all blocks in order."""
    ends = np.cumsum([len(block.measure) for block in blocks])[:-1]
    result = []
    for block, weight in zip(blocks, np.split(weights, ends), strict=True):
        keep = np.flatnonzero(weight > 0.0)
        if keep.size:
            rows: dict[str, Any] = {name: getattr(block, name)[keep] for name in _OF_ROWS}
            result.append(replace(block, dofs=block.dofs[keep], **{**rows, "measure": weight[keep] * rows["measure"]}))
    return result


def blocks_store(blocks: list[ElementBlock], apart: bool = False) -> Store:
    """Blocks on a basis as the kernel reads them.

    With ``apart`` every row has unknowns of its own, so that the kernel's force is a list of forces of rows.
    """
    places, first = list[Places](), 0
    for block in blocks:
        slots = block.dofs.T
        if apart:
            count, own = block.dofs.shape
            slots = slots + own * (first + np.arange(count))
            first += count
        places.append(np.ascontiguousarray(slots).astype(np.uint32))
    return tuple(build_store(tuple(blocks), places, [block.initial_stress for block in blocks]))


def rows_of(stresses: list[Array]) -> Array:
    """Stresses of blocks, shapes (row, strain), as one list in the order of the kernel's."""
    return np.concatenate([stress.T.ravel() for stress in stresses])
