"""Figure of how the film of an antenna settles to a plane."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from tautflex import checks
from tautflex.analysis import maneuver_end, surface
from tautflex.plot.style import DOUBLE_COLUMN, GREY, length_unit, new_axes, saving, styled, thinned
from tautflex.solvers.transient.status import Run


@styled
def plot_surface(run: xr.Dataset | Run, tolerance: float | None = None) -> Figure:
    """Draw the root mean square of the film about its best plane over time, on a logarithmic scale.

    Parameters
    ----------
    run
        A run, or its Dataset.
    tolerance
        Level [m] to mark, > 0; by default ``output.surface_tolerance`` of the case that the run was made from.

    Returns
    -------
    matplotlib.figure.Figure
        The maneuver is shaded.

    Raises
    ------
    InputError
        If the run has no such record, or no film, or ``tolerance`` is not positive.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.plot.plot_surface(run, tolerance=1e-5).savefig("surface.png")
    """
    film = surface(run)
    rms, time = film["rms"].values, film["time"].values
    scale, unit = length_unit(rms)
    figure, axes = new_axes(DOUBLE_COLUMN * 0.75, 2.4, "time $t$ [s]", f"rms about the best plane [{unit}]")
    axes.plot(*thinned(time, scale * rms), marker="o" if time.size == 1 else None, clip_on=time.size > 1)
    end = maneuver_end(run)
    if end is not None and time[0] < end < time[-1]:
        axes.axvspan(max(float(time[0]), 0.0), end, color="#eeeeee", zorder=0)
        axes.axvline(end, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), label=f"maneuver ends at {end:.4g} s")
    tolerance = film.attrs.get("surface_tolerance") if tolerance is None else tolerance
    if tolerance is not None:
        level = scale * checks.positive("tolerance", tolerance)
        axes.axhline(level, color=GREY, linewidth=0.8, linestyle=":", label=f"{level:.4g} {unit}")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", ncols=2)
    largest = scale * float(rms.max())
    if largest > 0.0:  # a film that stays a plane has no logarithm
        axes.set_yscale("log")
        low = max(axes.get_ylim()[0], 1e-5 * largest)
        axes.set_ylim(low, largest * (largest / low) ** 0.16)  # keeps the legend's line free of curves
    axes.set_xlim(float(time[0]), float(time[-1]) if len(time) > 1 else float(time[0]) + 1.0)
    return figure


save_surface = saving(plot_surface)
