"""Proper orthogonal modes of training runs as basis of a reduced model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.reduction.bases.snapshots import training_runs, training_snapshots
from tautflex.reduction.bases.static_derivatives import TREATMENTS, add_static_derivatives
from tautflex.reduction.bases.vectors import Basis, BasisVectors, ReferenceSolver, ritz
from tautflex.solvers.modal.rigid import RIGID_DIRECTIONS
from tautflex.solvers.static.across import transverse_unknowns
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import brief


@dataclass(frozen=True)
class PodBasis(Basis):
    """Proper orthogonal modes of training runs, in the inner product of the mass matrix, and static modal derivatives.

    Parameters
    ----------
    data
        Result of a run (``run.data``) with stored fields, ``simulate(..., fields="all", every=...)``, or several: of
        the full structure, or of a reduced model with many coordinates.
    count
        Number of modes; None takes as many as hold all but ``lost`` of the kinetic-energy norm.
    lost
        Part of the snapshots' norm that may be left out.
    derivatives
        As in `ModalBasis`.

    Raises
    ------
    InputError
        If an argument is out of range or a run has no fields.
    """

    data: xr.Dataset | Sequence[xr.Dataset]
    count: int | None = None
    lost: float = 1e-5
    derivatives: str = "condensed"
    __repr__ = brief

    def __post_init__(self) -> None:
        if self.count is not None:
            checks.whole("count", self.count, 1)
        checks.between("lost", self.lost, 0.0, 1.0)
        object.__setattr__(self, "data", training_runs(self.data))
        checks.one_of("derivatives", self.derivatives, TREATMENTS)

    def vectors(self, state: PrestressedState) -> BasisVectors:
        """Find the vectors for a prestressed state."""
        snapshots = training_snapshots(state, self.data) * transverse_unknowns(state)
        mass = state.system.inertia.mass_matrix
        modes = orthogonal_modes(snapshots, (mass @ snapshots.T).T, self.count, self.lost, "count")
        solver, kept = ReferenceSolver(state), ritz(state, modes)
        amplitude = np.sqrt(np.mean((kept @ (mass @ snapshots.T)) ** 2, axis=1))
        text = f"{len(modes)} proper orthogonal modes"
        return add_static_derivatives(state, solver, kept, amplitude, RIGID_DIRECTIONS, self.derivatives, text)


def orthogonal_modes(snapshots: Array, weighted: Array, count: int | None, lost: float, name: str) -> Array:
    """Leading directions of snapshots in the inner product of a matrix W, shape (count, size).

    Method of snapshots: eigenvectors of the Gram matrix, which is as small as the number of snapshots. (Results are
    decomposed by `tautflex.pod`, whose singular values keep the digits of weak modes, at the cost of the whole matrix.)
    ``weighted`` is W times the snapshots; the InputError where they have fewer independent directions names ``name``.
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
