"""The record of a batch as a Dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.batch.output.response import Response
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.recorder import COMPONENTS
from tautflex.solvers.transient.status import Status


def to_dataset(
    record: Response,
    parameters: dict[str, NDArray[np.float64]],
    axes: dict[str, int | None],
    runs: int,
    problem: TransientProblem,
) -> xr.Dataset:
    """Dataset with dimensions run, time, probe and the variable names of `tautflex.simulate`.

    Parameters
    ----------
    record
        Arrays with the run as first axis.
    parameters, axes
        Numbers of the runs; those with axis 0 become coordinates of the runs.
    runs
        Number of runs.
    problem
        What the runs have in common.
    """
    data: dict[str, Any] = {}
    for values, suffix, units, words in (
        (record.displacement, "", "m", "elastic displacement"),
        (record.velocity, "_velocity", "m s-1", "elastic velocity"),
    ):
        for axis, name in enumerate("uvw"):
            if values is not None:
                about = {"long_name": f"{words} along {COMPONENTS[axis]}", "units": units}
                data[name + suffix] = (("run", "time", "probe"), np.asarray(values)[..., axis], about)
    if record.energy is not None:
        for column, (name, words) in enumerate(
            (
                ("kinetic_energy", "kinetic energy of the elastic motion"),
                ("strain_energy", "strain energy above the reference"),
            )
        ):
            about = {"long_name": words, "units": "J"}
            data[name] = (("run", "time"), np.asarray(record.energy)[..., column], about)
    done = np.asarray(record.converged)
    data["status"] = ("run", np.where(done, Status.COMPLETED.value, Status.NOT_CONVERGED.value))
    data["iterations"] = ("run", np.asarray(record.iterations), {"long_name": "nonlinear iterations", "units": "1"})
    about = {"long_name": "end of the maneuver", "units": "s"}
    data["maneuver_end"] = ("run", np.asarray(record.maneuver_end), about)
    about = {"long_name": "reference position of the probe", "units": "m"}
    data["probe_position"] = (("probe", "component"), problem.placed.positions, about)
    coordinates: dict[str, Any] = {
        "time": ("time", np.asarray(record.time)[0], {"long_name": "time", "units": "s"}),
        "probe": list(problem.placed.names),
        "component": COMPONENTS,
        "run": np.arange(runs),
    }
    for name, given in parameters.items():
        if axes[name] == 0:
            dims = ("run",) if given.ndim == 1 else ("run", f"{name}.row")
            coordinates[name] = (dims, given)
    attributes = {name: problem.attributes[name] for name in ("method", "maneuver", "time_step")}
    return xr.Dataset(data, coords=coordinates, attrs=attributes)
