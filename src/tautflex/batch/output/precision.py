"""What single precision costs: the same runs in double precision beside it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from tautflex.solvers.transient.status import Status

# Relative error above which it is said in words.
_TOLD = 1e-3
# Variables that share one unit and are measured by the largest of them.
_GROUPS = {
    "displacement": ("u", "v", "w"),
    "velocity": ("u_velocity", "v_velocity", "w_velocity"),
    "energy": ("kinetic_energy", "strain_energy"),
    "angle": ("angle",),
}


def checked_runs(runs: int) -> list[int]:
    """Runs that are computed in double precision too: the first, the middle and the last."""
    return sorted({0, runs // 2, runs - 1})


def single_precision_errors(single: xr.Dataset, double: xr.Dataset) -> tuple[dict[str, float], list[str]]:
    """Largest errors of runs in single precision, and what has to be said about them.

    Parameters
    ----------
    single, double
        Records of the same runs.

    Returns
    -------
    errors
        Of each group of variables over the largest value of the run; of runs that both have completed, NaN without any.
    words
        Sentences about runs that ended otherwise, and about errors above 1e-3.
    """
    ended = single.status.values == Status.COMPLETED.value
    should = double.status.values == Status.COMPLETED.value
    errors = {}
    for group, members in _GROUPS.items():
        names = [name for name in members if name in double]
        if names:
            one, exact = (
                np.stack([data[name].values for name in names])[:, ended & should] for data in (single, double)
            )
            along = tuple(axis for axis in range(exact.ndim) if axis != 1)
            largest = np.abs(exact).max(axis=along)
            apart = np.abs(one - exact).max(axis=along)
            ratio = np.where(apart > 0.0, apart / np.where(largest > 0.0, largest, 1.0), 0.0)
            errors[group] = float(ratio.max(initial=0.0)) if ratio.size else float("nan")
    words = []
    if not np.array_equal(ended, should):
        places = ", ".join(str(run) for run in double["run"].values[ended != should])
        words.append(f"single precision: runs {places} end otherwise in double precision; take precision='double'")
    worst = max(errors, key=lambda name: np.nan_to_num(errors[name]))
    if errors[worst] > _TOLD:
        words.append(
            f"single precision: the {worst} of a run is off by {errors[worst]:.1e} of its largest value; "
            "take precision='double'"
        )
    return errors, words
