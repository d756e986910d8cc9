"""Basis for wrinkling film: proper orthogonal modes of the motion across the film and of the motion in it, apart.

Displacements in the plane are of second order in those across it, so one decomposition of both would not see them; and
nothing couples the two in the reference, so that vectors of one have zeros where the other has its unknowns.
"""

from __future__ import annotations

import numpy as np

from tautflex.numeric import Array
from tautflex.reduction.bases.pod_basis import orthogonal_modes
from tautflex.reduction.bases.vectors import BasisVectors, ritz
from tautflex.solvers.static.across import transverse_unknowns
from tautflex.solvers.static.prestress import PrestressedState


def two_part_basis(
    state: PrestressedState, snapshots: Array, counts: tuple[int | None, int | None], lost: tuple[float, float]
) -> BasisVectors:
    """Proper orthogonal modes across and in the film's plane, as Ritz vectors in the inner product of the mass.

    Arguments as of `hyper_reduce`; snapshots are free unknowns, shape (n, size).
    """
    mass = state.system.inertia.mass_matrix
    across = transverse_unknowns(state)
    found = []
    for name, mask, count, share in zip(("transverse", "in_plane"), (across, ~across), counts, lost, strict=True):
        part = snapshots * mask
        if mask.any() and count != 0:
            # Rounding in the Ritz vectors would fill the zeros that the kernel skips.
            found.append(ritz(state, orthogonal_modes(part, (mass @ part.T).T, count, share, name)) * mask)
    vectors = np.concatenate(found)
    amplitude = np.sqrt(np.mean((vectors @ (mass @ snapshots.T)) ** 2, axis=1))
    text = " and ".join(
        f"{len(part)} proper orthogonal modes {where}"
        for part, where in zip(found, ("across", "in the plane"), strict=False)
    )
    return BasisVectors(vectors, np.zeros((0, state.system.size)), amplitude / amplitude.max(), text)
