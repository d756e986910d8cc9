"""Figure of the displacement of probes over time, as in the paper's Figures 5 and 8 to 11."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from tautflex import checks
from tautflex.analysis import maneuver_end
from tautflex.errors import InputError
from tautflex.plot.style import (
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
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import RUN, dataset_of

_REMEDY = "simulate(state, ..., probes={'A': (x, y)}) gives a run"


@styled
def plot_time_history(
    runs: xr.Dataset | Run | Mapping[str, xr.Dataset | Run],
    probes: Sequence[str] | None = None,
    component: str = "w",
    span: tuple[float, float] | None = None,
) -> Figure:
    """Draw the displacement of probes over time and mark the end of the maneuver.

    Parameters
    ----------
    runs
        A run or its Dataset, or a mapping from a legend entry to a run to compare several.
    probes
        Names of the probes; all by default.
    component
        ``"u"``, ``"v"`` or ``"w"``.
    span
        First and last time drawn [s]; the whole record by default.

    Returns
    -------
    matplotlib.figure.Figure
        One line per run and probe; the maneuver is shaded where all runs share it.

    Raises
    ------
    InputError
        If there is no run, probe or component of that name, or ``span`` does not increase.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.plot.plot_time_history(run, span=(0.0, 0.3)).savefig("record.png")
    """
    alone = isinstance(runs, xr.Dataset) or not isinstance(runs, Mapping)
    cases = {
        str(name): dataset_of("runs", run, "time", remedy=_REMEDY)
        for name, run in ({"": runs} if alone else runs).items()  # type: ignore[union-attr]
    }
    if not cases:
        raise InputError("runs: expected at least one run, got none")
    records = {name: probe_records(run, probes, component) for name, run in cases.items()}
    scale, unit = length_unit(np.concatenate([record.values.ravel() for record in records.values()]))
    figure, axes = new_axes(DOUBLE_COLUMN * 0.75, 2.7, "time $t$ [s]", f"displacement ${component}$ [{unit}]")
    many = sum(record.sizes["probe"] for record in records.values()) > 1
    drawn = 0
    for name, record in records.items():
        for probe in record["probe"].values:
            point = f"point {probe}" if name == "" or record.sizes["probe"] > 1 else ""
            label = ", ".join(part for part in (name, point) if part)
            line = LINES[(drawn // 7 if len(cases) > 1 else drawn) % 4]
            curve = thinned(record["time"].values, scale * record.sel(probe=probe).values)
            axes.plot(*curve, line, label=label, marker="o" if curve[0].size == 1 else None)
            drawn += 1
    ends = {maneuver_end(run) for run in cases.values()}
    end = ends.pop() if len(ends) == 1 else None
    first, last = _limits(records, span)
    if end is not None and first < end < last:
        axes.axvspan(max(first, 0.0), end, color="#eeeeee", zorder=0)
        axes.axvline(end, color=GREY, linewidth=0.8, linestyle=(0, (4, 2)), label=f"maneuver ends at {end:.4g} s")
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    axes.set_xlim(first, last if last > first else first + 1.0)
    if many or end is not None:
        explain(axes)
    else:
        axes.set_title(f"point {next(iter(records.values()))['probe'].values[0]}")
    return figure


save_time_history = saving(plot_time_history)


def probe_records(run: xr.Dataset | Run, probes: Sequence[str] | None, component: str) -> xr.DataArray:
    """Return one component (time, probe) at the named probes [m], or raise InputError."""
    checks.one_of("component", component, ("u", "v", "w"))
    run = dataset_of("run", run, component, "time", remedy=_REMEDY, table=RUN)
    if run.sizes["probe"] == 0:
        raise InputError("run: expected a record of probes, got one without; simulate with probes={...}")
    record = run[component].transpose("time", "probe")
    if probes is None:
        return record
    chosen = [probes] if isinstance(probes, str) else checks.several("probes", probes, str, "'A'")
    if not chosen:
        raise InputError("probes: expected at least one name, got none; None takes all")
    for probe in chosen:
        checks.one_of("probes", probe, [str(name) for name in record["probe"].values])
    return record.sel(probe=list(chosen))


def _limits(records: Mapping[str, xr.DataArray], span: tuple[float, float] | None) -> tuple[float, float]:
    if span is None:
        times = [record["time"].values for record in records.values()]
        return float(min(time[0] for time in times)), float(max(time[-1] for time in times))
    first, last = checks.float_array("span", span, (2,)).tolist()
    if not first < last:
        raise InputError(f"span: expected two increasing times [s], got {span!r}")
    return first, last
