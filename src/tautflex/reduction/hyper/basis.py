"""Basis for wrinkling film: proper orthogonal modes of the motion across the film and of the motion in it, apart.

Displacements in the plane are of second order in those across it, so one decomposition of both would not see them; and
nothing couples the two in the reference, so that vectors of one have zeros where the other has its unknowns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import InputError
from tautflex.reduction.bases.basis import BasisVectors, ritz
from tautflex.reduction.bases.snapshots import transverse_unknowns
from tautflex.solvers.static.prestress import PrestressedState

Array = NDArray[np.float64]


def two_part_basis(
    state: PrestressedState, snapshots: Array, counts: tuple[int | None, int | None], lost: tuple[float, float]
) -> BasisVectors:
    """Proper orthogonal modes across and in the film's plane, as Ritz vectors in the inner product of the mass.

    Parameters
    ----------
    state
        Prestressed state.
    snapshots
        Free unknowns of a run, shape (n, size).
    counts
        Number of vectors across and in the plane; None takes as many as leave out ``lost``.
    lost
        Part of the norm of the snapshots across and in the plane that may be left out.

    Raises
    ------
    InputError
        If the snapshots do not have that many independent vectors.
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


def orthogonal_modes(snapshots: Array, weighted: Array, count: int | None, lost: float, name: str) -> Array:
    """Leading directions of snapshots (n, size) in an inner product, ``weighted = W snapshots``, shape (count, size).

    Method of snapshots: eigenvectors of the Gram matrix, which is as small as the number of snapshots.
    """
    values, weights = np.linalg.eigh(snapshots @ weighted.T)
    values, weights = values[::-1], weights[:, ::-1]
    left = 1.0 - np.cumsum(values) / values.sum()
    most = int(np.sum(values > 1e-12 * values[0]))
    wanted = count if count is not None else min(most, int(np.argmax(left <= lost)) + 1)
    if wanted > most:
        raise InputError(
            f"{name}: expected at most {most} vectors, the rank of the snapshots, got {wanted}; store more fields"
        )
    modes: Array = (weights[:, :wanted] / np.sqrt(values[:wanted])).T @ snapshots
    return modes
