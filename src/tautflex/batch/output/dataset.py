"""The record of a batch as a Dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from tautflex.batch.output.response import Response
from tautflex.motion.hub import FreeHub
from tautflex.motion.rotations import product
from tautflex.numeric import Array
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.status import Status
from tautflex.solvers.variables import BATCH, COMPONENTS, described


def to_dataset(
    record: Response,
    parameters: dict[str, Array],
    axes: dict[str, int | None],
    runs: int,
    problem: TransientProblem,
) -> xr.Dataset:
    """Dataset with dimensions run, time, probe and the variable names of `tautflex.simulate`.

    The record has the run as first axis; parameters with axis 0 become coordinates of the runs.
    """
    arrays: dict[str, Any] = {}
    for values, suffix in ((record.displacement, ""), (record.velocity, "_velocity")):
        if values is not None:
            arrays |= {name + suffix: np.asarray(values)[..., axis] for axis, name in enumerate("uvw")}
    if record.energy is not None:
        arrays["kinetic_energy"], arrays["strain_energy"] = np.moveaxis(np.asarray(record.energy), -1, 0)
    quaternion = {}
    if record.hub is not None:
        arrays |= _of_hub(np.asarray(record.hub), problem)
        quaternion = {"quaternion": ["w", "x", "y", "z"]}
    done = np.asarray(record.converged)
    arrays["status"] = np.where(done, Status.COMPLETED.value, Status.NOT_CONVERGED.value)
    arrays["iterations"] = np.asarray(record.iterations)
    arrays["maneuver_end"] = np.asarray(record.maneuver_end)
    arrays["probe_position"] = problem.placed.positions
    coordinates: dict[str, Any] = {
        **described(BATCH, {"time": np.asarray(record.time)[0]}),
        "probe": list(problem.placed.names),
        "component": COMPONENTS,
        "run": np.arange(runs),
        **quaternion,
    }
    for name, given in parameters.items():
        if axes[name] == 0:
            dims = ("run",) if given.ndim == 1 else ("run", f"{name}.row")
            coordinates[name] = (dims, given)
    attributes = {name: problem.attributes[name] for name in ("method", "maneuver", "time_step")}
    return xr.Dataset(described(BATCH, arrays), coords=coordinates, attrs=attributes)


def _of_hub(record: Any, problem: TransientProblem) -> dict[str, Any]:
    """Angle, attitude and angular velocity of a hub that turns about one axis, from angle and rate, (run, time, 2)."""
    hub = problem.maneuver
    assert isinstance(hub, FreeHub)
    line, (angle, rate) = hub.freedom[3:], np.moveaxis(record, -1, 0)
    half, attitude = 0.5 * angle[..., None], np.asarray(hub.attitude, dtype=float)
    attitude = attitude / np.linalg.norm(attitude)
    whole = np.cos(half) * attitude + np.sin(half) * product(attitude, np.append(0.0, line))
    return {"angle": angle, "attitude": whole, "angular_velocity": rate[..., None] * line}
