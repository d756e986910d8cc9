"""Displacement fields of a full run as free unknowns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.variables import dataset_of


def training_runs(data: xr.Dataset | Sequence[xr.Dataset]) -> tuple[xr.Dataset, ...]:
    """Datasets of one training run or of several; InputError if there is none, or one has no fields."""
    each = data if isinstance(data, list | tuple) else (data,)
    if not each:
        raise InputError("data: expected at least one run, got none; simulate with fields='all'")
    remedy = "simulate(..., fields='all') stores it"
    return tuple(dataset_of("data", run, "displacement", remedy=remedy) for run in each)


def training_snapshots(state: PrestressedState, data: xr.Dataset | Sequence[xr.Dataset]) -> Array:
    """Free unknowns of the stored fields of training runs, one after the other, shape (field, size)."""
    return np.concatenate([full_snapshots(state, run) for run in training_runs(data)])


def full_snapshots(state: PrestressedState, data: xr.Dataset) -> Array:
    """Free unknowns of the stored fields of a run, shape (field, size).

    Results store translations only. Rotations of frame nodes follow from them by static equilibrium: the bending
    energy is least for them, ``K_rr theta = -K_rt u``. Raises InputError if there are fewer than two fields, or they
    belong to another mesh.
    """
    fields = data["displacement"].values if "displacement" in data else np.zeros((0, 0, 3))
    nodes = len(state.model.nodes)
    if len(fields) < 2:
        raise InputError(
            f"data: expected a run with at least two stored fields, got {len(fields)}; simulate with fields='all' and "
            "every=10, say"
        )
    if fields.shape[1] != nodes:
        raise InputError(f"data: expected fields of {nodes} nodes, got {fields.shape[1]}; use a run of the same mesh")
    model = state.model
    full = np.zeros((len(fields), model.dof_count))
    full[:, model.translation_dofs] = fields
    snapshots = full[:, model.free_dofs]
    turning = np.setdiff1d(np.arange(state.system.size), state.system.place[model.translation_dofs.ravel()])
    if turning.size:
        snapshots[:, turning] = _rotations(state, snapshots, turning)
    return snapshots


def _rotations(state: PrestressedState, snapshots: Array, turning: Indices) -> Array:
    """Rotations of least energy for given translations, shape (field, rotation)."""
    pattern = state.system.pattern
    stiffness = pattern.matrix(state.tangent_entries)
    load = stiffness @ snapshots.T
    # All other unknowns held: a unit diagonal takes their place.
    held = np.ones(pattern.size, dtype=bool)
    held[turning] = False
    values = np.where(held[pattern.rows] | held[pattern.columns], 0.0, state.tangent_entries)
    unknowns = np.flatnonzero(held)
    values[pattern.diagonal[unknowns]] = 1.0
    factor = SymmetricFactorization(pattern)
    factor.factorize(values)
    load[held] = 0.0
    return -np.array([factor.solve(column) for column in np.ascontiguousarray(load.T)])[:, turning]
