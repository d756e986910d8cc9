"""One record of one quantity, sampled uniformly in time: the input of the spectrum and the scalogram."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex.checks import finite, float_array, positive
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import dataset_of

Record: TypeAlias = "xr.DataArray | tuple[ArrayLike, float]"
"""A DataArray over ``time`` [s], or a pair (values, time_step [s])."""


class UniformRecord(NamedTuple):
    """A checked record: values and time [s] (sample,), time step [s], unit and name of the values."""

    values: Array
    time: Array
    time_step: float
    units: str
    name: str

    def starting_at(self, instant: float) -> UniformRecord:
        """Return the samples from an instant [s] on; InputError if fewer than four are left."""
        kept = self.time >= finite("after", instant) - 1e-6 * self.time_step
        if np.count_nonzero(kept) < 4:
            raise InputError(
                f"after: expected an instant at least 4 samples before the record's end at {self.time[-1]:g} s, "
                f"got {instant:g} s; simulate longer"
            )
        return self._replace(values=self.values[kept], time=self.time[kept])


def maneuver_end(run: xr.Dataset | Run) -> float | None:
    """Return the time [s] from which the angular velocity stays as it is; None if it never or always does.

    Parameters
    ----------
    run
        A run, or its Dataset.

    Returns
    -------
    float or None
        The attribute ``maneuver_end`` if the run has it, else the first stored instant of constant rate; None if
        fewer than four samples follow it.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> round(tf.maneuver_end(run), 2)
    1.0
    """
    data = dataset_of("run", run, "time", remedy="simulate(state, ...) gives one")
    if data.sizes["time"] < 4:
        return None
    if "maneuver_end" in data.attrs:
        end = outlasting(float(data.attrs["maneuver_end"]), data["time"].values)
        return end if math.isfinite(end) else None
    if "angular_velocity" not in data:
        return None
    rate = data["angular_velocity"].transpose("time", ...).values.reshape(data.sizes["time"], -1)
    moving = np.abs(rate - rate[-1]).max(axis=1) > 1e-9 * np.abs(rate).max()
    if not moving.any() or moving[-4:].any():
        return None
    return float(data["time"].values[np.flatnonzero(moving)[-1] + 1])


def counted_from(run: xr.Dataset | Run) -> float | None:
    """Instant [s] that measures after the maneuver count from: inf if it outlasts the record, None if there is none."""
    data = dataset_of("run", run, "time", remedy="simulate(state, ...) gives one")
    if "maneuver_end" in data.attrs:
        return outlasting(float(data.attrs["maneuver_end"]), data["time"].values)
    return maneuver_end(data)


def outlasting(end: float, time: Array) -> float:
    """End of a maneuver [s], inf where fewer than four samples follow it."""
    return end if len(time) >= 4 and end <= time[-4] else math.inf


def uniform_record(record: Record, *, samples: int = 4) -> UniformRecord:
    """Check a record and return its samples, times and constant time step.

    Parameters
    ----------
    record
        DataArray with the single dimension ``time`` [s], or (values (sample,), time_step [s]).
    samples
        Fewest samples that the question asked needs.

    Returns
    -------
    UniformRecord
        Copies of nothing: the arrays may share memory with ``record``.

    Raises
    ------
    InputError
        If the record has other dimensions than ``time``, is too short, holds a number that is not finite,
        or is not sampled uniformly.
    """
    if isinstance(record, xr.DataArray):
        checked = _from_data_array(record)
    elif isinstance(record, tuple) and len(record) == 2:
        step = positive("time_step", record[1], remedy="give the sampling interval in seconds")
        values = float_array("record", record[0], (None,))
        checked = UniformRecord(values, np.arange(values.size, dtype=np.float64) * step, step, "", "record")
    else:
        raise InputError(
            "record: expected an xarray DataArray over time or a pair (values, time_step), "
            f"got {type(record).__name__}; try run.data.w.sel(probe='A')"
        )
    if checked.values.size < samples:
        raise InputError(
            f"record: expected at least {samples} samples, got {checked.values.size}; "
            "simulate longer or store more steps"
        )
    return checked


def _from_data_array(record: xr.DataArray) -> UniformRecord:
    name = str(record.name) if record.name is not None else "record"
    if record.dims != ("time",):
        raise InputError(
            f"{name}: expected the single dimension 'time', got {record.dims}; "
            "select one probe or component first, e.g. record.sel(probe='A')"
        )
    if "time" not in record.coords:
        raise InputError(f"{name}: expected a 'time' coordinate [s], got none; pass (values, time_step) instead")
    values = float_array(name, record.values, (None,))
    time = float_array("time", record["time"].values, (None,))
    if time.size < 2:
        raise InputError(f"{name}: expected at least 2 samples, got {time.size}; simulate longer")
    step = float(time[-1] - time[0]) / (time.size - 1)
    uneven = np.abs(np.diff(time) - step)
    if step <= 0.0 or uneven.max() > 1e-6 * step + 8 * np.finfo(float).eps * np.abs(time).max():
        worst = int(uneven.argmax())
        raise InputError(
            f"time: expected a constant step of {step:g} s, got {time[worst + 1] - time[worst]:g} s "
            f"after t = {time[worst]:g} s; resample first, e.g. record.interp(time=...)"
        )
    return UniformRecord(values, time, step, str(record.attrs.get("units", "")), name)
