"""Complex-Morlet scalogram of a record and its ridge: frequency against time [theory, section 7]."""

from __future__ import annotations

import numpy as np
import pywt
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from tautflex.analysis.record import Record, UniformRecord, uniform_record
from tautflex.analysis.spectrum import spectrum
from tautflex.checks import float_array, positive
from tautflex.errors import InputError


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
        [Hz], where the magnitude is largest at each time (interpolated by a parabola in the logarithm of
        frequency); ``cone_of_influence(time)`` [Hz]: below it the ends of the record matter (e-folding of
        the wavelet's energy, infinite at the ends).

    Raises
    ------
    InputError
        If the record is not uniform and finite, or a frequency or a parameter is out of range.
    """
    data = uniform_record(record, samples=16)
    positive("bandwidth", bandwidth, remedy="1.5 to 6 is usual")
    positive("center", center, remedy="1 is usual")
    grid = _default_frequencies(data) if frequencies is None else _checked_frequencies(frequencies, data)
    magnitude = _magnitude(data, grid, bandwidth, center)
    edge = np.minimum(data.time - data.time[0], data.time[-1] - data.time)
    with np.errstate(divide="ignore"):
        cone = center * np.sqrt(bandwidth) / edge
    ridge, height = _ridge(grid, _above(grid, magnitude, cone))
    units = data.units or "1"
    return xr.Dataset(
        {
            "magnitude": (
                ("frequency", "time"),
                magnitude,
                {"units": units, "long_name": f"wavelet amplitude of {data.name}"},
            ),
            "ridge": ("time", ridge, {"units": "Hz", "long_name": "frequency of largest wavelet amplitude"}),
            "ridge_magnitude": (
                "time",
                height,
                {"units": units, "long_name": f"largest wavelet amplitude of {data.name}"},
            ),
            "cone_of_influence": (
                "time",
                cone,
                {"units": "Hz", "long_name": "lowest frequency free of end effects"},
            ),
        },
        {
            "frequency": ("frequency", grid, {"units": "Hz", "long_name": "frequency"}),
            "time": ("time", data.time, {"units": "s", "long_name": "time"}),
        },
        {"wavelet": f"cmor{bandwidth:g}-{center:g}", "bandwidth": float(bandwidth), "center": float(center)},
    )


def _checked_frequencies(frequencies: ArrayLike, data: UniformRecord) -> NDArray[np.float64]:
    grid = float_array("frequencies", frequencies, (None,))
    nyquist = 0.5 / data.time_step
    if grid.size < 3 or grid[0] <= 0.0 or grid[-1] >= nyquist or np.any(np.diff(grid) <= 0.0):
        raise InputError(
            f"frequencies: expected three or more increasing values inside (0, {nyquist:g}) Hz, "
            f"got {grid.size} from {grid.min(initial=np.inf):g} to {grid.max(initial=-np.inf):g} Hz; "
            "half the sampling rate is the limit"
        )
    return grid


def _default_frequencies(data: UniformRecord) -> NDArray[np.float64]:
    """Two periods per record at the low end; at the high end half an octave above 99.9 % of the energy."""
    nyquist = 0.5 / data.time_step
    lowest = 2.0 / (data.values.size * data.time_step)
    lines = spectrum((data.values, data.time_step))
    energy = np.cumsum(lines["energy"].values)
    reached = float(lines["frequency"].values[np.searchsorted(energy, 0.999 * energy[-1])])
    highest = min(max(1.5 * reached, 4.0 * lowest), 0.9 * nyquist)
    return np.geomspace(lowest, highest, 120)


def _magnitude(
    data: UniformRecord, grid: NDArray[np.float64], bandwidth: float, center: float
) -> NDArray[np.float64]:
    wavelet = pywt.ContinuousWavelet(f"cmor{bandwidth:.12g}-{center:.12g}")
    # PyWavelets cuts the wavelet at |s| = 8 whatever B is; 5 sqrt(B) keeps the cut below 1e-10 of the peak.
    wavelet.upper_bound = 5.0 * np.sqrt(bandwidth)
    wavelet.lower_bound = -wavelet.upper_bound
    scales = center / (grid * data.time_step)
    coefficients, _ = pywt.cwt(data.values - data.values.mean(), scales, wavelet, method="fft", precision=14)
    # PyWavelets normalises energy (1/sqrt(scale)); with 2/sqrt(scale) more, a sinusoid shows its amplitude.
    return np.asarray(2.0 * np.abs(coefficients) / np.sqrt(scales)[:, None], dtype=np.float64)


def _above(
    grid: NDArray[np.float64], magnitude: NDArray[np.float64], cone: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Blank what lies below the cone, but near the ends no more than what is below half the main frequency.

    A drift slower than the record can show would otherwise hide the vibration.
    """
    free = grid[:, None] >= cone
    energy = np.sum(np.where(free, magnitude, 0.0) ** 2, axis=1)
    main = float(grid[energy.argmax()])
    return np.where(grid[:, None] >= np.minimum(cone, 0.5 * main), magnitude, 0.0)


def _ridge(
    grid: NDArray[np.float64], magnitude: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequency and height of the largest magnitude at each time; a parabola refines it inside the grid."""
    columns = np.arange(magnitude.shape[1])
    top = magnitude.argmax(axis=0)
    inner = np.clip(top, 1, grid.size - 2)
    x = np.log(grid)
    left, right = x[inner - 1] - x[inner], x[inner + 1] - x[inner]
    middle = magnitude[inner, columns]
    down, up = magnitude[inner - 1, columns] - middle, magnitude[inner + 1, columns] - middle
    curvature = (up / right - down / left) / (right - left)
    slope = down / left - curvature * left
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where((curvature < 0.0) & (inner == top), -0.5 * slope / curvature, 0.0)
    shift = np.clip(shift, left, right)
    return np.where(inner == top, np.exp(x[inner] + shift), grid[top]), magnitude[top, columns]
