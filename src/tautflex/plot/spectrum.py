"""Figure of the Fourier spectrum of probes, with the dominant frequency marked."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from tautflex.analysis import dominant_frequency, spectrum
from tautflex.analysis.record import counted_from
from tautflex.checks import float_array, positive
from tautflex.numeric import Array
from tautflex.plot.history import probe_records
from tautflex.plot.style import (
    COLORS,
    DOUBLE_COLUMN,
    GREY,
    LINES,
    explain,
    length_unit,
    new_axes,
    saving,
    styled,
    thinned,
)
from tautflex.solvers.modal.natural import Modes
from tautflex.solvers.transient.status import Run


@styled
def plot_spectrum(
    run: xr.Dataset | Run,
    probes: Sequence[str] | None = None,
    component: str = "w",
    natural_frequencies: ArrayLike | Modes | None = None,
    highest: float | None = None,
    length: float | None = None,
) -> Figure:
    """Draw the amplitude spectrum of probes after the maneuver, zero-padded to a power of two, and mark its peak.

    Where the maneuver outlasts the record the spectrum is that of the whole record, its title says so, and no peak is
    marked.

    Parameters
    ----------
    run
        A run, or its Dataset.
    probes, component
        As for :func:`tautflex.plot.plot_time_history`.
    natural_frequencies
        Frequencies [Hz] (mode,) to mark, counted from 1 along the top, or what `tautflex.solve_modes` gives.
    highest
        Largest frequency drawn [Hz]; by default what holds the peaks and 95 % of the energy.
    length
        Duration of the padded record [s], as for :func:`tautflex.spectrum`.

    Returns
    -------
    matplotlib.figure.Figure
        One line per probe; the legend gives peak and bin width.

    Raises
    ------
    InputError
        If there is no probe or component of that name, or the record is not uniform.
    """
    records = probe_records(run, probes, component)
    counted = counted_from(run)
    goes_on = counted == math.inf
    after = None if goes_on else counted
    each = [records.isel(probe=k) for k in range(records.sizes["probe"])]
    lines = [spectrum(record, length=length, after=after) for record in each]
    peaks = [dominant_frequency(record, length=length, after=after) for record in each]
    scale, unit = length_unit(np.concatenate([line["amplitude"].values for line in lines]))
    figure, axes = new_axes(DOUBLE_COLUMN * 0.75, 2.7, "frequency $f$ [Hz]", f"amplitude of ${component}$ [{unit}]")
    limit, top = _reach(lines) if highest is None else positive("highest", highest), 0.0
    for k, (line, peak) in enumerate(zip(lines, peaks, strict=True)):
        frequency, height = line["frequency"].values, scale * line["amplitude"].values
        color = COLORS[k % len(COLORS)]
        name = f"point {records['probe'].values[k]}"
        if np.isfinite(peak.frequency) and not goes_on:
            name += f": peak {peak.frequency:.3f} Hz, bins of {peak.bin_width:.3f} Hz"
            at = int(np.abs(frequency - peak.frequency).argmin())
            axes.plot(peak.frequency, height[at], "o", color=color, markersize=4, zorder=4)
        seen = slice(0, int(np.searchsorted(frequency, limit)) + 1)
        axes.plot(*thinned(frequency[seen], height[seen]), LINES[k % 4], color=color, label=name)
        top = max(top, float(height.max()))
    axes.set_xlim(0.0, limit)
    axes.set_ylim(-0.02 if top == 0.0 else 0.0, 1.1 * top or 1.0)  # a line of zeros is seen
    if natural_frequencies is not None:
        values = natural_frequencies.frequencies if isinstance(natural_frequencies, Modes) else natural_frequencies
        _mark(axes, float_array("natural_frequencies", values, (None,)), limit)
    title = "during the maneuver" if goes_on else None if after is None else f"motion after t = {after:g} s"
    explain(axes, title, columns=1 if len(lines) < 3 else 2)
    return figure


save_spectrum = saving(plot_spectrum)


def _reach(lines: Sequence[xr.Dataset]) -> float:
    """Frequency [Hz] beyond 95 % of the energy and thrice the peak of every line, at least 20 bins.

    The long tail that a record cut at the end of a maneuver has would leave the peaks no room.
    """
    reach = 0.0
    for line in lines:
        energy = np.cumsum(line["energy"].values)
        reached = line["frequency"].values[np.searchsorted(energy, 0.95 * energy[-1])]
        peak = line["frequency"].values[1 + int(line["energy"].values[1:].argmax())]
        reach = max(reach, 1.2 * float(reached), 3 * float(peak), 20 * float(line.attrs["bin_width"]))
    return min(reach, float(lines[0]["frequency"].values[-1]))


def _mark(axes: Axes, frequencies: Array, limit: float) -> None:
    """Draw natural frequencies as dotted lines, numbered along the top, close ones together."""
    groups: list[list[int]] = []
    for index in np.flatnonzero((frequencies > 0.0) & (frequencies <= limit)).tolist():
        axes.axvline(float(frequencies[index]), color=GREY, linewidth=0.7, linestyle=":", zorder=1)
        if groups and frequencies[index] - frequencies[groups[-1][0]] < 0.06 * limit:
            groups[-1].append(index)
        else:
            groups.append([index])
    top = axes.secondary_xaxis("top")
    names = [str(group[0] + 1) if len(group) == 1 else f"{group[0] + 1}-{group[-1] + 1}" for group in groups]
    top.set_xticks([float(frequencies[group].mean()) for group in groups], names)
    top.tick_params(length=0)
    top.set_xlabel("natural frequency of mode")
