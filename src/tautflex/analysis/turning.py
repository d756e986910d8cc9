"""Attitude of the floating frame as a run recorded it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from tautflex.motion.rotations import IDENTITY, exponential, product
from tautflex.numeric import Array


def recorded_attitude(run: xr.Dataset, times: Array) -> Array:
    """Attitude quaternions, scalar first, of the samples nearest to instants [s], shape (n, 4).

    Of a free hub they are stored; else the angular velocity is added up from the first sample on, where the axes are
    those of space: in axes that turn along, exact where the spin changes at a steady rate about one axis.
    """
    stored = run["time"].values
    if not stored.size or not ("attitude" in run or "angular_velocity" in run):
        return np.tile(IDENTITY, (len(times), 1))
    if "attitude" in run:
        quaternions = run["attitude"].values
    else:
        spin, quaternions = run["angular_velocity"].values, np.zeros((stored.size, 4))
        quaternions[0] = IDENTITY
        for k, step in enumerate(np.diff(stored)):
            quaternions[k + 1] = product(quaternions[k], exponential(0.5 * step * (spin[k] + spin[k + 1])))
    return np.asarray(quaternions[np.searchsorted(0.5 * (stored[1:] + stored[:-1]), times)])
