"""Figure of a membrane's shape at several instants, as in the paper's Figure 4."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from tautflex.checks import float_array, positive, whole
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.plot.panels import draw_deflections
from tautflex.plot.style import saving, styled
from tautflex.plot.surface import wireframe
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import RUN, dataset_of

_MOST = 12


@styled
def plot_shapes(
    run: xr.Dataset | Run,
    times: Sequence[float] | None = None,
    magnification: float | None = None,
    columns: int = 4,
) -> Figure:
    """Draw the deflected structure at several instants, all to one scale.

    Parameters
    ----------
    run
        A run, or its Dataset, with ``displacement(field_time, node, component)`` [m] and the mesh.
    times
        Instants [s]; the nearest stored field is drawn. By default the stored ones, at most twelve.
    magnification
        Factor of the displacements. By default 1000, as in the paper, where that reads well, else a round
        one.
    columns
        Drawings side by side.

    Returns
    -------
    matplotlib.figure.Figure
        Coloured by true transverse displacement; the factor stands under the drawings.

    Raises
    ------
    InputError
        If the run stored no fields, a time lies outside them, or ``magnification`` is not positive.
    """
    remedy = "simulate(state, ..., fields='all') gives one"
    run = dataset_of("run", run, "displacement", "field_time", remedy=remedy, table=RUN)
    whole("columns", columns, 1)
    if run.sizes["field_time"] == 0:
        raise InputError("run: expected stored fields, got none; simulate with fields='all' or a list of times")
    mesh = wireframe(run)
    chosen = _nearest(run["field_time"].values, times)
    fields = run["displacement"].transpose("field_time", "node", "component").values[chosen]
    across = float(np.abs(fields[..., 2]).max())
    factor = drawn_factor(across, mesh.span) if magnification is None else magnification
    factor = positive("magnification", factor, remedy="1000 is the paper's")
    titles = [f"$t$ = {float(run['field_time'][index]):.4g} s" for index in chosen]
    return draw_deflections(mesh, titles, fields, factor, columns)


save_shapes = saving(plot_shapes)


def _nearest(stored: Array, times: Sequence[float] | None) -> list[int]:
    """Positions of the stored instants to draw."""
    if times is None:
        return np.unique(np.linspace(0, stored.size - 1, min(stored.size, _MOST)).round().astype(int)).tolist()
    times = float_array("times", times, (None,)).tolist()
    slack = 0.5 * float(np.diff(stored).max(initial=0.0)) + 1e-9
    for time in times:
        if not stored[0] - slack <= time <= stored[-1] + slack:
            raise InputError(
                f"times: expected instants in [{stored[0]:g}, {stored[-1]:g}] s, got {time!r}; store more fields"
            )
    if len(times) == 0:
        raise InputError("times: expected at least one instant, got none; None draws the stored ones")
    return [int(np.abs(stored - time).argmin()) for time in times]


def drawn_factor(largest: float, span: float) -> float:
    """Return the paper's 1000 if it draws 2 to 40 % of the length, else a round factor for 20 %."""
    if largest == 0.0 or 0.02 <= 1000.0 * largest / span <= 0.4:
        return 1000.0
    wanted = 0.2 * span / largest
    choices = np.array([1.0, 2.0, 5.0, 10.0]) * 10.0 ** np.floor(np.log10(wanted))
    return float(choices[np.abs(np.log(choices / wanted)).argmin()])
