"""Amplitude, Fourier spectrum and dominant frequency of a record [theory, section 7]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex.analysis.record import Record, UniformRecord, uniform_record
from tautflex.checks import flag, float_array, non_negative, one_of, positive
from tautflex.errors import InputError
from tautflex.numeric import Array, Complex
from tautflex.solvers.variables import SPECTRUM, described

Padding = Literal["next-power-of-two", "none"]


@dataclass(frozen=True)
class PeakFrequency:
    """The dominant frequency of a record.

    Attributes
    ----------
    frequency
        Centre of the bin of largest energy [Hz]; NaN if the record is constant.
    bin_width
        Distance between bins [Hz]: the frequency is known to plus or minus half of it.
    interpolated
        Vertex of the parabola through the peak of the magnitude and its two neighbours [Hz].
    """

    frequency: float
    bin_width: float
    interpolated: float


def amplitude(record: xr.DataArray | ArrayLike | tuple[ArrayLike, float]) -> float:
    """Return the largest absolute value of a record, in the record's unit [theory, section 7].

    Parameters
    ----------
    record
        DataArray or array (sample,), or a pair (values, time_step [s]).

    Raises
    ------
    InputError
        If the record is empty, has more than one dimension or holds a number that is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> time = np.arange(0.0, 10.0, 0.01)
    >>> tf.amplitude((0.002 * np.cos(2 * np.pi * 1.5 * time), 0.01))
    0.002
    """
    values: Any = record[0] if isinstance(record, tuple) and len(record) == 2 and np.ndim(record[0]) else record
    checked = float_array("record", values, (None,))
    if checked.size == 0:
        raise InputError("record: expected at least 1 sample, got 0; simulate longer")
    return float(np.abs(checked).max())


def spectrum(
    record: Record,
    pad: Padding = "next-power-of-two",
    *,
    length: float | None = None,
    after: float | None = None,
    remove_mean: bool = True,
) -> xr.Dataset:
    """Return the one-sided Fourier spectrum of a record.

    Parameters
    ----------
    record
        DataArray (time,) on a uniform time axis [s], or (values (sample,), time_step [s]).
    pad
        ``"next-power-of-two"`` appends zeros up to the next power of two of the number of samples [theory,
        section 7]: 10 s at 1 ms become 16384 samples, bins 0.0610352 Hz apart. ``"none"`` takes the record
        as is.
    length
        Duration of the padded record [s] instead of ``pad``; bins are ``1/length`` apart. With 10.48576 s
        (2**20 samples of 10 microseconds) a record of 10 s has the bins 0.0953674 Hz of the paper's Tables
        6, 8, 9.
    after
        Use only the samples from this time on [s], padded as the whole record would be, so that bins stay where they
        are. The offset that a decelerating frame gives the antenna outweighs its vibration: response frequencies are
        those of the motion after the maneuver, see :func:`maneuver_end`.
    remove_mean
        Subtract the mean before padding.

    Returns
    -------
    xarray.Dataset
        ``amplitude(frequency)`` in the record's unit: a sinusoid of the full duration shows its amplitude;
        ``energy(frequency)``: spectral density whose sum times the bin width is the integral of the squared
        record over time; coordinate ``frequency`` [Hz]; attribute ``bin_width`` [Hz].

    Raises
    ------
    InputError
        If the record is not uniform and finite, or ``length`` is shorter than the record.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> time = np.arange(0.0, 20.0, 0.01)
    >>> found = tf.spectrum((np.sin(2 * np.pi * 1.5 * time), 0.01))
    >>> list(found.data_vars)
    ['amplitude', 'energy']
    """
    lines = _lines_of(uniform_record(record), pad, length, after, remove_mean)
    arrays = {"amplitude": lines.amplitude, "energy": lines.energy}
    return xr.Dataset(
        described(SPECTRUM, arrays, units=lines.record.units or "1", name=lines.record.name),
        described(SPECTRUM, {"frequency": lines.frequency}),
        {"bin_width": lines.width, "samples": lines.record.values.size, "time_step": lines.record.time_step},
    )


class _Lines(NamedTuple):
    """Lines of a spectrum, their distance [Hz], and the record that they are of, cut."""

    frequency: Array
    amplitude: Array
    energy: Array
    width: float
    record: UniformRecord


def _lines_of(
    data: UniformRecord, pad: Padding, length: float | None, after: float | None, remove_mean: bool = True
) -> _Lines:
    flag("remove_mean", remove_mean)
    one_of("pad", pad, ("next-power-of-two", "none"))
    count = data.values.size
    if length is None:
        padded = float(1 << (count - 1).bit_length()) if pad == "next-power-of-two" else float(count)
    else:
        padded = positive("length", length, remedy="give the padded duration in seconds") / data.time_step
        if padded < count - 1e-6:
            raise InputError(
                f"length: expected at least the record's {count * data.time_step:g} s, got {length:g} s; "
                "cut the record or pad to a longer duration"
            )
    if after is not None:
        data = data.starting_at(after)
    values = data.values - data.values.mean() if remove_mean else data.values
    transform = _transform(values, padded)
    frequency = np.arange(transform.size) / (padded * data.time_step)
    sides = np.full(frequency.size, 2.0)  # every line stands for +f and -f, but zero and Nyquist stand alone
    sides[0] = 1.0
    if abs(frequency[-1] * data.time_step - 0.5) < 1e-12:
        sides[-1] = 1.0
    magnitude = np.abs(transform)
    energy = sides * (magnitude * data.time_step) ** 2
    return _Lines(frequency, sides * magnitude / values.size, energy, 1.0 / (padded * data.time_step), data)


def dominant_frequency(
    record: Record,
    pad: Padding = "next-power-of-two",
    *,
    length: float | None = None,
    after: float | None = None,
    band: float = 0.0,
) -> PeakFrequency:
    """Return the frequency of largest energy of a record, mean removed, zero-padded [theory, section 7].

    Parameters
    ----------
    record, pad, length, after
        As for :func:`spectrum`.
    band
        Width [Hz] of the band of largest energy in which the bin is looked for, >= 0; 0 compares bin by bin. A
        vibration whose frequency drifts as it decays spreads its energy over neighbouring bins, none of which need be
        larger than the one bin of a weaker, steady vibration: bin by bin, such a tie falls either way.

    Returns
    -------
    PeakFrequency
        Bin of largest energy, bin width and interpolated value [Hz]; NaN for a record that is constant.

    Raises
    ------
    InputError
        As for :func:`spectrum`.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> time = np.arange(0.0, 20.0, 0.01)
    >>> peak = tf.dominant_frequency((np.sin(2 * np.pi * 1.5 * time), 0.01))
    >>> abs(peak.frequency - 1.5) < peak.bin_width
    True
    """
    non_negative("band", band)
    data = uniform_record(record)
    frequency, height, energy, width, _ = _lines_of(data, pad, length, after)
    peak = _strongest(energy[1:], round(0.5 * band / width)) + 1
    scale = float(np.abs(data.values).max())
    if height[peak] <= 8 * np.finfo(float).eps * scale:
        return PeakFrequency(float("nan"), width, float("nan"))
    return PeakFrequency(float(frequency[peak]), width, float(frequency[peak]) + width * _vertex(height, peak))


def _strongest(energy: Array, reach: int) -> int:
    """Largest bin among those within ``reach`` of the one around which they hold most energy."""
    centre = int(np.convolve(energy, np.ones(2 * reach + 1))[reach : reach + energy.size].argmax())
    first = max(0, centre - reach)
    return first + int(energy[first : centre + reach + 1].argmax())


def _transform(values: Array, padded: float) -> Complex:
    """Fourier transform at the multiples of 1/padded cycles per sample up to one half.

    A padded duration that is not a whole number of samples is the same sum at other frequencies (chirp z).
    """
    whole = round(padded)
    if abs(padded - whole) < 1e-6:
        return np.asarray(np.fft.rfft(values, whole), dtype=complex)
    from scipy.signal import CZT  # loads half of scipy: only when asked for

    lines = int(np.floor(padded / 2)) + 1
    return np.asarray(CZT(values.size, lines, w=np.exp(-2j * np.pi / padded))(values), dtype=complex)


def _vertex(height: Array, peak: int) -> float:
    """Offset, in bins, of the vertex of the parabola through a peak and its neighbours; 0 if it is none."""
    if peak + 1 >= height.size:
        return 0.0
    left, top, right = height[peak - 1 : peak + 2]
    curvature = left - 2 * top + right
    if max(left, right) > top or curvature == 0.0:
        return 0.0
    return float(0.5 * (left - right) / curvature)
