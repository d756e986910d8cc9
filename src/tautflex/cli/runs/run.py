"""`tautflex run`: the maneuver of a case, its results and figures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from tautflex.cli.cards import show_run
from tautflex.cli.options import (
    Answer,
    CaseFile,
    Overrides,
    ResultFolder,
    about,
    command,
    load,
    require_output_directory,
)


@command
def run(
    case: CaseFile,
    /,
    *,
    output: ResultFolder = None,
    override: Overrides = None,
) -> Answer:
    """Simulate the maneuver; write run.nc, summary.json and figures.

    Ctrl-C ends the run early and keeps what was computed. "surface" in the answer tells how the film stands about its
    best plane: rms [m] and tilt [rad] at the end, the largest rms after the maneuver, and the time [s] from then on
    that the rms takes to stay within output.surface_tolerance (2e-5 m).

    Example: tautflex run m2.toml -o m2 --set damping.alpha=0.01 --set solver.end_time=5
    """
    loaded = load(case, override)
    directory = output if output is not None else default_directory(case)
    require_output_directory(directory)

    from tautflex.case.run import write_case_run
    from tautflex.cli.figures import run_figures

    with about(case), progress_bar() as progress:
        summary = write_case_run(loaded, directory, progress, figures=run_figures, title=case.stem)
    return Answer(summary, partial(show_run, case, summary), 0 if summary["status"] == "completed" else 1)


def default_directory(case: Path) -> Path:
    """Results of ``m2.toml`` go to ``m2`` beside it; a case without suffix gets ``-run`` instead."""
    bare = case.with_suffix("")
    return bare if bare != case else case.with_name(f"{case.name}-run")


@contextmanager
def progress_bar() -> Iterator[Callable[[float, str], None] | None]:
    """Progress on stderr if that is a terminal, None otherwise."""
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=1.0)

        def update(fraction: float, message: str) -> None:
            bar.update(task, completed=fraction, description=message)

        yield update
