"""Unknowns across a flat film, and those in its plane, which only meet in second order."""

from __future__ import annotations

import numpy as np
from scipy.sparse.csgraph import connected_components

from tautflex.numeric import Mask
from tautflex.solvers.static.prestress import PrestressedState


def transverse_unknowns(state: PrestressedState) -> Mask:
    """Unknowns that the film's normal displacements move without stretching anything, shape (size,).

    About a flat reference the stiffness couples them with bending of the frame out of its plane, and with nothing in
    the plane, which follows from them in second order. About a curved reference all unknowns are coupled.
    """
    system = state.system
    matrix = system.matrix(np.where(np.abs(state.tangent_entries) > 0.0, state.tangent_entries, 0.0)).copy()
    matrix.eliminate_zeros()
    _, label = connected_components(matrix, directed=False)
    normal = np.zeros(system.size, dtype=bool)
    for index in system.block_index("membrane"):
        block, places = system.blocks[index], system.row_places[index]
        # Gradients w,1 and w,2 are the last two of a membrane.
        touched = np.any(block.gradient[:, 4:] != 0.0, axis=1)
        normal[places[touched & (places < system.size)]] = True
    return np.isin(label, np.unique(label[normal])) if normal.any() else np.ones(system.size, dtype=bool)
