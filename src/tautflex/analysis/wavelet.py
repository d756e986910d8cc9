"""Complex-Morlet scalogram of a record and its ridge: frequency against time [theory, section 7]."""

from __future__ import annotations

import numpy as np
import pywt
import xarray as xr
from numpy.typing import ArrayLike

from tautflex.analysis.record import Record, UniformRecord, uniform_record
from tautflex.analysis.spectrum import spectrum
from tautflex.checks import float_array, positive
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.solvers.variables import SCALOGRAM, described


def scalogram(
    record: Record,
    frequencies: ArrayLike | None = None,
    bandwidth: float = 3.0,
    center: float = 1.0,
) -> xr.Dataset:
    """Return the complex-Morlet scalogram of a record, scaled so that a sinusoid shows its amplitude.

    The mother wavelet is exp(2 pi i C s) exp(-s^2/B) / sqrt(pi B), PyWavelets' ``cmorB-C``. At frequency f it
    averages over the standard deviation sqrt(B/2) C/f in time and f/(2 pi C sqrt(B/2)) in frequency.

    Parameters
    ----------
    record
        DataArray (time,) on a uniform time axis [s], or (values (sample,), time_step [s]).
    frequencies
        Increasing frequencies [Hz] (frequency,), at least three and below half the sampling rate; by
        default 120 values, evenly spaced in logarithm, from two periods per record up to where 99.9 % of
        the energy is reached.
    bandwidth
        B of the wavelet, dimensionless: larger resolves frequency better and time worse.
    center
        C of the wavelet, dimensionless.

    Returns
    -------
    xarray.Dataset
        ``magnitude(frequency, time)`` and ``ridge_magnitude(time)`` in the record's unit; ``ridge(time)``
        [Hz], the largest peak over frequency at each time, NaN where there is none above the cone of
        influence (near the ends: above half the main frequency); ``cone_of_influence(time)`` [Hz]: below it
        the ends of the record matter (e-folding of the wavelet's energy, infinite at the ends).

    Raises
    ------
    InputError
        If the record is not uniform and finite, or a frequency or a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> time = np.arange(0.0, 4.0, 0.005)
    >>> found = tf.scalogram((np.sin(2 * np.pi * 3.0 * time), 0.005))
    >>> print(f"{float(found.ridge.sel(time=2.0, method='nearest')):.2f} Hz")
    3.00 Hz
    """
    data = uniform_record(record, samples=16)
    positive("bandwidth", bandwidth, remedy="1.5 to 6 is usual")
    positive("center", center, remedy="1 is usual")
    grid = _default_frequencies(data) if frequencies is None else _checked_frequencies(frequencies, data)
    magnitude = _magnitude(data, grid, bandwidth, center)
    edge = np.minimum(data.time - data.time[0], data.time[-1] - data.time)
    with np.errstate(divide="ignore"):
        cone = center * np.sqrt(bandwidth) / edge
    ridge, height = _ridge(grid, magnitude, cone)
    arrays = {"magnitude": magnitude, "ridge": ridge, "ridge_magnitude": height, "cone_of_influence": cone}
    return xr.Dataset(
        described(SCALOGRAM, arrays, units=data.units or "1", name=data.name),
        described(SCALOGRAM, {"frequency": grid, "time": data.time}),
        {"wavelet": f"cmor{bandwidth:g}-{center:g}", "bandwidth": float(bandwidth), "center": float(center)},
    )


def _checked_frequencies(frequencies: ArrayLike, data: UniformRecord) -> Array:
    grid = float_array("frequencies", frequencies, (None,))
    nyquist = 0.5 / data.time_step
    if grid.size < 3 or grid[0] <= 0.0 or grid[-1] >= nyquist or np.any(np.diff(grid) <= 0.0):
        raise InputError(
            f"frequencies: expected three or more increasing values inside (0, {nyquist:g}) Hz, "
            f"got {grid.size} from {grid.min(initial=np.inf):g} to {grid.max(initial=-np.inf):g} Hz; "
            "half the sampling rate is the limit"
        )
    return grid


def _default_frequencies(data: UniformRecord) -> Array:
    """Two periods per record at the low end; at the high end half an octave above 99.9 % of the energy."""
    nyquist = 0.5 / data.time_step
    lowest = 2.0 / (data.values.size * data.time_step)
    lines = spectrum((data.values, data.time_step))
    energy = np.cumsum(lines["energy"].values)
    reached = float(lines["frequency"].values[np.searchsorted(energy, 0.999 * energy[-1])])
    highest = min(max(1.5 * reached, 4.0 * lowest), 0.9 * nyquist)
    return np.geomspace(lowest, highest, 120)


def _magnitude(data: UniformRecord, grid: Array, bandwidth: float, center: float) -> Array:
    wavelet = pywt.ContinuousWavelet(f"cmor{bandwidth:.12g}-{center:.12g}")
    # PyWavelets cuts the wavelet at |s| = 8 whatever B is; 5 sqrt(B) keeps the cut below 1e-10 of the peak.
    wavelet.upper_bound = 5.0 * np.sqrt(bandwidth)
    wavelet.lower_bound = -wavelet.upper_bound
    scales = center / (grid * data.time_step)
    coefficients, _ = pywt.cwt(data.values - data.values.mean(), scales, wavelet, method="fft", precision=14)
    # PyWavelets normalises energy (1/sqrt(scale)); with 2/sqrt(scale) more, a sinusoid shows its amplitude.
    return np.asarray(2.0 * np.abs(coefficients) / np.sqrt(scales)[:, None], dtype=np.float64)


def _ridge(grid: Array, magnitude: Array, cone: Array) -> tuple[Array, Array]:
    """Frequency and height of the largest peak over frequency at each time, refined by a parabola.

    Peaks below the cone do not count, but near the ends, where the cone is high, those above half the main
    frequency do: a drift slower than the record can show would otherwise hide the vibration.
    """
    main = grid[np.sum(np.where(grid[:, None] >= cone, magnitude, 0.0) ** 2, axis=1).argmax()]
    inside = magnitude[1:-1]
    peaks = (inside > magnitude[:-2]) & (inside >= magnitude[2:])
    peaks &= grid[1:-1, None] >= np.minimum(cone, 0.5 * main)
    top = np.where(peaks, inside, 0.0).argmax(axis=0) + 1
    columns = np.arange(magnitude.shape[1])
    x = np.log(grid)
    left, right = x[top - 1] - x[top], x[top + 1] - x[top]
    height = magnitude[top, columns]
    down, up = magnitude[top - 1, columns] - height, magnitude[top + 1, columns] - height
    curvature = (up / right - down / left) / (right - left)
    slope = down / left - curvature * left
    found = peaks.any(axis=0)
    shift = -0.5 * slope / np.where(found, curvature, np.nan)  # the curvature of a peak is negative
    return np.exp(x[top] + shift), np.where(found, height, np.nan)
