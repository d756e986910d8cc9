"""Cost of a step against the number of unknowns, and error against time, one line per program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tautflex.plot.style import COLORS, DOUBLE_COLUMN, GREY, new_axes, save_figure, styled

MARKERS = "osD^v"


@styled
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
    figure, axes = new_axes(DOUBLE_COLUMN * 0.75, 3.2, "unknowns", "processor time per step [ms]")
    programs = list(dict.fromkeys(row["program"] for row in rows))
    for place, (marker, program) in enumerate(zip(MARKERS, programs, strict=False)):
        points = sorted((row["unknowns"], row["milliseconds_per_step"]) for row in rows if row["program"] == program)
        axes.plot(*zip(*points, strict=True), marker=marker, markersize=4, label=program, zorder=3 - 0.1 * place)
    axes.set(xscale="log", yscale="log")
    axes.legend(loc="upper left")
    return save_figure(figure, path.with_suffix(""), ("png",))[0]


@styled
def accuracy_figure(rows: list[dict[str, Any]], target: float, path: Path) -> Path:
    """Draw error against time on logarithmic axes; a line joins what no other setting of a program betters.

    Parameters
    ----------
    rows
        Rows of `accuracy_for_time.py`.
    target
        Error that is marked.
    path
        File to write.

    Returns
    -------
    Path
        The file.
    """
    figure, axes = new_axes(DOUBLE_COLUMN * 0.75, 3.2, "processor time [s]", "error over 2 s [%]")
    axes.axhline(100.0 * target, color=GREY, linewidth=0.8, linestyle=":")
    for color, program in zip(COLORS, dict.fromkeys(row["program"] for row in rows), strict=False):
        for element, face in (("triangle3", "none"), ("triangle6", color)):
            own = [row for row in rows if (row["program"], row["element"]) == (program, element)]
            points = [(row["seconds"], 100.0 * row["error"]) for row in own]
            label = f"{program}, {element}"
            marks = {"linestyle": "", "marker": "o", "markersize": 3.5, "label": label, "markerfacecolor": face}
            axes.plot(*np.transpose(points or [(np.nan, np.nan)]), color=color, **marks)
        best = sorted(
            (row["seconds"], 100.0 * row["error"]) for row in rows if row["program"] == program and row["best"]
        )
        axes.plot(*np.transpose(best), color=color)
    axes.set(xscale="log", yscale="log")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)  # points are everywhere
    return save_figure(figure, path.with_suffix(""), ("png",))[0]
