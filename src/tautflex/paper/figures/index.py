"""The figures of the paper, each with the runs it needs and the function that draws it."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from tautflex.checks import one_of
from tautflex.errors import InputError
from tautflex.paper.figures import drawings, histories, trends
from tautflex.plot.style import save_figure

Draw = Callable[[Mapping[str, xr.Dataset], Mapping[str, xr.Dataset]], Figure]
FORMATS = ("pdf", "svg", "png")


@dataclass(frozen=True)
class PaperFigure:
    """One figure of the paper.

    Attributes
    ----------
    number
        As printed, e.g. ``"5a"``.
    title
        What it shows, for a heading or a caption.
    needs
        Names of the runs it is drawn from, see the catalogue.
    draw
        Function of (runs by name, modes by model) that returns the figure.
    """

    number: str
    title: str
    needs: tuple[str, ...]
    draw: Draw


def _listed(trend: Mapping[str, Mapping[float, str]]) -> tuple[str, ...]:
    return tuple(name for cases in trend.values() for name in cases.values())


_RATES, _DURATIONS = _listed(trends.RATE_TREND), _listed(trends.DURATION_TREND)

FIGURES: dict[str, PaperFigure] = {
    figure.number: figure
    for figure in (
        PaperFigure("3", "First four mode shapes of M2", (), drawings.draw_mode_shapes),
        PaperFigure(
            "4",
            "Shape of M2 at twelve instants of the stop from π/5 rad/s in 1 s, damping 0.01",
            (drawings.SECTION_3_RUN,),
            drawings.draw_response_shapes,
        ),
        PaperFigure(
            "5a",
            "Displacement of point A, M2, π/5 rad/s, T = 1 s, damping 0.01",
            (histories.FIGURE_5["5a"],),
            histories.draw_5a,
        ),
        PaperFigure(
            "5b",
            "Displacement of point A, M2, π/5 rad/s, T = 1 s, damping 0.001",
            (histories.FIGURE_5["5b"],),
            histories.draw_5b,
        ),
        PaperFigure(
            "5c",
            "Displacement of point A, M2, π/2 rad/s, T = 1 s, damping 0.001",
            (histories.FIGURE_5["5c"],),
            histories.draw_5c,
        ),
        PaperFigure(
            "6",
            "Frequency of point A against time, M2, π/5 rad/s, T = 1 s, damping 0.01",
            (histories.FIGURE_5["5a"],),
            histories.draw_6,
        ),
        PaperFigure(
            "7",
            "Dominant shape: proper orthogonal modes that reach 99 %",
            (drawings.SECTION_3_RUN,),
            drawings.draw_dominant_shape,
        ),
        PaperFigure(
            "8",
            "Displacement of point A, M1 to M3, π/100 rad/s, T = 0.1 s",
            tuple(histories.FIGURE_8),
            histories.draw_8,
        ),
        PaperFigure(
            "9a",
            "Displacement of point A, M3, π/5 rad/s, stops of 0.1, 1 and 2 s",
            tuple(histories.FIGURE_9),
            histories.draw_9a,
        ),
        PaperFigure("9b", "Details of Figure 9a", tuple(histories.FIGURE_9), histories.draw_9b),
        PaperFigure(
            "10",
            "Displacement of point A, M1, T = 0.1 s, three initial angular velocities",
            tuple(histories.FIGURE_10),
            histories.draw_10,
        ),
        PaperFigure(
            "11",
            "Displacement of point A, M1, two stops of equal deceleration",
            tuple(histories.FIGURE_11),
            histories.draw_11,
        ),
        PaperFigure("12a", "Response frequency against initial angular velocity, T = 0.1 s", _RATES, trends.draw_12a),
        PaperFigure("12b", "Response frequency against duration of the stop, π/5 rad/s", _DURATIONS, trends.draw_12b),
        PaperFigure("13a", "Amplitude against initial angular velocity, T = 0.1 s", _RATES, trends.draw_13a),
        PaperFigure("13b", "Amplitude against duration of the stop, π/5 rad/s", _DURATIONS, trends.draw_13b),
    )
}


def save_figures(
    numbers: Iterable[str],
    runs: Mapping[str, xr.Dataset],
    modes: Mapping[str, xr.Dataset],
    directory: str | os.PathLike[str],
    formats: Sequence[str] = FORMATS,
) -> dict[str, list[Path]]:
    """Draw figures of the paper and write ``figure_5a.pdf``, ``.svg`` and ``.png``.

    Parameters
    ----------
    numbers
        Keys of ``FIGURES``.
    runs
        Datasets of runs by name; at least those in ``needs`` of the figures.
    modes
        Datasets of modes by model.
    directory
        Folder to write to, made if missing.
    formats
        As for :func:`tautflex.plot.save_figure`.

    Returns
    -------
    dict
        Files written, in the order of ``formats``, by number.

    Raises
    ------
    InputError
        If a number is unknown, a run is missing or a file cannot be written.
    """
    written = {}
    for number in numbers:
        figure = FIGURES[one_of("figure", number, tuple(FIGURES))]
        missing = [name for name in figure.needs if name not in runs]
        if missing:
            raise InputError(f"runs: Figure {number} expected {missing}, got {sorted(runs)}; run these cases first")
        written[number] = save_figure(figure.draw(runs, modes), Path(directory) / f"figure_{number}", formats)
        gc.collect()  # figures hold cycles and tens of megabytes of pixels
    return written
