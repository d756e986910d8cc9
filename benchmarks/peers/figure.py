"""Cost of a step against the number of unknowns, one line per program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

MARKERS = "osD^v"


def cost_figure(rows: list[dict[str, Any]], path: Path) -> Path:
    """Draw cost against size on logarithmic axes.

    Parameters
    ----------
    rows
        Rows of the size study.
    path
        File to write.

    Returns
    -------
    Path
        The file.
    """
    figure = Figure(figsize=(6.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    programs = list(dict.fromkeys(row["program"] for row in rows))
    for marker, program in zip(MARKERS, programs, strict=False):
        points = sorted((row["unknowns"], row["milliseconds_per_step"]) for row in rows if row["program"] == program)
        axes.plot(*zip(*points, strict=True), marker=marker, markersize=4, label=program)
    axes.set(xscale="log", yscale="log", xlabel="unknowns", ylabel="processor time per step [ms]")
    axes.grid(which="major", color="#dddddd")
    axes.set_axisbelow(True)
    axes.legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=150)
    return path
