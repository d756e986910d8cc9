"""When a vibration has died away."""

from __future__ import annotations

import numpy as np

from tautflex import checks
from tautflex.analysis.record import Record, uniform_record


def settling_time(record: Record, tolerance: float, *, after: float | None = None) -> float:
    """Return how long a record takes until it stays within a tolerance to its end.

    Parameters
    ----------
    record
        DataArray (time,) on a uniform time axis [s], such as ``surface(run)["rms"]``, or (values (sample,), time_step
        [s]).
    tolerance
        Largest absolute value that counts as settled, in the record's unit, > 0.
    after
        Instant [s] to count from, such as :func:`tautflex.maneuver_end` tells it; None is the beginning.

    Returns
    -------
    float
        Time [s], between samples where the straight line through them comes within the tolerance; 0 if the record
        never leaves it, NaN if it is outside at its last sample.

    Raises
    ------
    InputError
        As :func:`tautflex.spectrum`, or if ``tolerance`` is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> import xarray as xr
    >>> time = np.linspace(0.0, 10.0, 10001)
    >>> decay = xr.DataArray(np.exp(-time), dims="time", coords={"time": time})
    >>> round(tf.settling_time(decay, 0.1), 2)              # ln 10
    2.3
    """
    checks.positive("tolerance", tolerance)
    checked = uniform_record(record)
    checked = checked if after is None else checked.starting_at(after)
    size, time = np.abs(checked.values), checked.time
    outside = np.flatnonzero(size > tolerance)
    if not outside.size:
        return 0.0
    last = int(outside[-1])
    if last + 1 == len(size):
        return float("nan")
    share = (size[last] - tolerance) / (size[last] - size[last + 1])
    began = time[0] if after is None else after
    return float(time[last] + share * (time[last + 1] - time[last]) - began)
