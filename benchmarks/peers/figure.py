"""Cost of a step against the number of unknowns, one line per program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tautflex.plot.style import DOUBLE_COLUMN, new_axes, save_figure, styled

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
