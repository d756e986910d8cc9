"""The figures of the paper, each with the runs it needs and the function that draws it."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from tautflex.checks import one_of
from tautflex.errors import InputError
from tautflex.paper.cases.run_names import DURATIONS, MODELS, RATE_SYMBOLS, SECTION_3, maneuver_words, run_name
from tautflex.paper.figures import drawings
from tautflex.paper.figures.histories import Draw, damped_history, draw_ridge, history
from tautflex.paper.figures.trends import trend
from tautflex.plot.style import save_figure
from tautflex.study.engines.processes import Processes

FORMATS = ("pdf", "svg", "png")
_Job = tuple[Figure, Path, Sequence[str]]


class PaperFigure(NamedTuple):
    """One figure of the paper: what it shows, names of the runs it is drawn from, and the function that draws it."""

    title: str
    needs: tuple[str, ...]
    draw: Draw


_SECTION_3 = (drawings.SECTION_3_RUN,)
_STOPS = {run_name("M3", "pi_5", duration): f"$T$ = {duration:g} s" for duration in DURATIONS}
_OF_STOPS = rf"M3, $\omega_0$ = {RATE_SYMBOLS['pi_5']} rad/s"
_FIGURE_10 = {run_name("M1", rate, 0.1): rf"$\omega_0$ = {RATE_SYMBOLS[rate]}" for rate in ("pi_2", "pi_5", "pi_100")}
_FIGURE_11 = {run_name("M1", *stop): maneuver_words(*stop) for stop in (("pi_5", 1.0), ("pi_50", 0.1))}
FIGURES = {
    "3": PaperFigure("First four mode shapes of M2", (), drawings.draw_mode_shapes),
    "4": PaperFigure(
        "Shape of M2 at twelve instants of the stop from π/5 rad/s in 1 s, damping 0.01",
        _SECTION_3,
        drawings.draw_response_shapes,
    ),
    "5a": PaperFigure(
        "Displacement of point A, M2, π/5 rad/s, T = 1 s, damping 0.01", *damped_history("a", "pi_5", SECTION_3)
    ),
    "5b": PaperFigure("Displacement of point A, M2, π/5 rad/s, T = 1 s, damping 0.001", *damped_history("b", "pi_5")),
    "5c": PaperFigure("Displacement of point A, M2, π/2 rad/s, T = 1 s, damping 0.001", *damped_history("c", "pi_2")),
    "6": PaperFigure("Frequency of point A against time, M2, π/5 rad/s, T = 1 s, damping 0.01", _SECTION_3, draw_ridge),
    "7": PaperFigure(
        "Dominant shape: proper orthogonal modes that reach 99 %", _SECTION_3, drawings.draw_dominant_shape
    ),
    "8": PaperFigure(
        "Displacement of point A, M1 to M3, π/100 rad/s, T = 0.1 s",
        *history({run_name(model, "pi_100", 0.1): model for model in MODELS}, maneuver_words("pi_100", 0.1)),
    ),
    "9a": PaperFigure(
        "Displacement of point A, M3, π/5 rad/s, stops of 0.1, 1 and 2 s", *history(_STOPS, f"(a)  {_OF_STOPS}")
    ),
    "9b": PaperFigure("Details of Figure 9a", *history(_STOPS, f"(b)  details, {_OF_STOPS}", details=True)),
    "10": PaperFigure(
        "Displacement of point A, M1, T = 0.1 s, three initial angular velocities",
        *history(_FIGURE_10, r"M1, $T$ = 0.1 s, $\omega_0$ [rad/s]"),
    ),
    "11": PaperFigure(
        "Displacement of point A, M1, two stops of equal deceleration", *history(_FIGURE_11, "M1, equal deceleration")
    ),
    "12a": PaperFigure("Response frequency against initial angular velocity, T = 0.1 s", *trend("frequency", "rate")),
    "12b": PaperFigure("Response frequency against duration of the stop, π/5 rad/s", *trend("frequency", "duration")),
    "13a": PaperFigure("Amplitude against initial angular velocity, T = 0.1 s", *trend("amplitude", "rate")),
    "13b": PaperFigure("Amplitude against duration of the stop, π/5 rad/s", *trend("amplitude", "duration")),
}
"""The figures by number as printed, in the paper's order."""


def save_figures(
    numbers: Iterable[str],
    runs: Mapping[str, xr.Dataset],
    modes: Mapping[str, xr.Dataset],
    directory: str | os.PathLike[str],
    formats: Sequence[str] = FORMATS,
    workers: int | None = 1,
) -> dict[str, list[Path]]:
    """Draw figures of the paper and write ``figure_5a.pdf``, ``.svg`` and ``.png``; return the files by number.

    Runs are given by name, at least those that the figures need, and modes by model; a missing folder is made. With
    several workers (None: one per core) they write files of different figures at the same time.

    Raises
    ------
    InputError
        If a number is unknown, a run is missing or a file cannot be written.
    """
    wanted, jobs = list(numbers), dict[str, _Job]()
    for number in wanted:
        figure = FIGURES[one_of("figure", number, tuple(FIGURES))]
        missing = [name for name in figure.needs if name not in runs]
        if missing:
            raise InputError(f"runs: Figure {number} expected {missing}, got {sorted(runs)}; run these cases first")
        jobs[number] = (figure.draw(runs, modes), Path(directory) / f"figure_{number}", formats)
    files, count = dict[str, list[Path]](), min(workers or os.cpu_count() or 1, len(wanted))
    if count > 1:
        with Processes(count) as processes:
            each = processes.each(_save, jobs.items())
            files = {number: written for _, (number, written) in each}
    else:
        files = dict(map(_save, jobs.items()))
    gc.collect()  # figures hold cycles and tens of megabytes of pixels
    return {number: files[number] for number in wanted}


def _save(job: tuple[str, _Job]) -> tuple[str, list[Path]]:
    number, (figure, stem, formats) = job
    return number, save_figure(figure, stem, formats)
