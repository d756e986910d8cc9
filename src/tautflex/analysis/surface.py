"""The film of an antenna as a reflecting surface over time: its measures, and the gain that it loses [theory.md 7]."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import OF_SURFACE, RUN, SURFACE, dataset_of, described

_LIGHT = 299792458.0  # speed of light [m/s]


def surface(run: xr.Dataset | Run) -> xr.Dataset:
    """Return how the film stands at the stored instants of a run, relative to the floating frame.

    Parameters
    ----------
    run
        A run, or its Dataset.

    Returns
    -------
    xarray.Dataset
        Over ``time`` [s]: ``rms`` [m], the root mean square over the film's area of the displacement across it about
        the plane that fits it best; ``tilt_x`` and ``tilt_y`` [rad], by which that plane is rotated about x and y (in a
        film that does not lie in z = 0, about the axes of :class:`tautflex.mechanics.surface.FilmSurface`); ``piston``
        [m], the mean displacement.

    Raises
    ------
    InputError
        If ``run`` has no such record (those of runs of one film have), or the structure has no film.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> list(tf.surface(run))
    ['rms', 'tilt_x', 'tilt_y', 'piston']
    """
    data = dataset_of("run", run, "time", *OF_SURFACE, remedy="simulate(state, ...) gives one", table=RUN)
    found = {name: data[stored].values for stored, name in OF_SURFACE.items()}
    if np.isnan(found["rms"]).all():
        raise InputError(
            "run: expected one of a structure with film, got one without; cables and beams alone have no surface"
        )
    stated = {name: data.attrs[name] for name in ("surface_tolerance",) if name in data.attrs}
    return xr.Dataset(described(SURFACE, found), coords={"time": data["time"]}, attrs=stated)


def ruze_loss(rms: xr.Dataset | xr.DataArray | Run | ArrayLike, frequency: float) -> xr.DataArray:
    """Return the loss of gain by random errors of a surface, ``10 log10(e) (4 pi rms / wavelength)^2`` [Ruze 1966].

    Parameters
    ----------
    rms
        Root mean square error [m], or what has one: a run, or what `surface` gives.
    frequency
        Of the radio wave [Hz], > 0.

    Returns
    -------
    xarray.DataArray
        Loss [dB], >= 0, over whatever ``rms`` runs over.

    Raises
    ------
    InputError
        If ``frequency`` is not positive, or ``rms`` is negative.

    Examples
    --------
    >>> import tautflex as tf
    >>> round(float(tf.ruze_loss([0.03 / 50], 10e9)[0]), 2)     # rms of a fiftieth of the wavelength
    0.27
    """
    checks.positive("frequency", frequency)
    if isinstance(rms, xr.Dataset | Run):
        rms = rms["rms"] if isinstance(rms, xr.Dataset) and "rms" in rms else surface(rms)["rms"]
    given = rms if isinstance(rms, xr.DataArray) else xr.DataArray(checks.numbers("rms", rms))
    if bool((given < 0.0).any()):
        raise InputError(f"rms: expected lengths >= 0 [m], got {float(given.min()):g}; rms are no displacements")
    loss = 10.0 / np.log(10.0) * (4.0 * np.pi * frequency / _LIGHT * given) ** 2
    units, words = SURFACE["ruze_loss"].units, SURFACE["ruze_loss"].words
    return loss.rename("ruze_loss").assign_attrs(units=units, long_name=words, frequency=frequency)
