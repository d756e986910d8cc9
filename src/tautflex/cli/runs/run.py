"""`tautflex run`: the maneuver of a case, its results and figures."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cards import say, show_run
from tautflex.cli.figures import FORMATS, Formats, run_figures
from tautflex.cli.options import (
    Answer,
    CaseFile,
    Force,
    Overrides,
    ResultFolder,
    about,
    command,
    load,
    require_output_directory,
)
from tautflex.errors import CaseError
from tautflex.files.transaction import result_folder

if TYPE_CHECKING:
    from tautflex.case import Case

Resume = Annotated[
    bool, Parameter(name="--resume", help="Go on from the last checkpoint of a run that was killed or interrupted.")
]
Seconds = Annotated[float, Parameter(name="--checkpoint", help="Wall-clock time between two checkpoints [s].")]
ENDED = {"completed": 0, "not-converged": 1, "interrupted": 130}


@command
def run(
    case: CaseFile,
    /,
    *,
    output: ResultFolder = None,
    force: Force = False,
    resume: Resume = False,
    checkpoint: Seconds = 60.0,
    override: Overrides = None,
    form: Formats = None,
) -> Answer:
    """Simulate the maneuver; write run.nc, summary.json and figures.

    An existing result is not replaced without --force. Ctrl-C, SIGTERM and SIGHUP end the run early and keep what was
    computed; --resume goes on from there, and after a kill from the last checkpoint, to the bit.

    "surface" in the answer tells how the film stands about its best plane: rms [m] and tilt [rad] at the end, the
    largest rms after the maneuver, and the time [s] from then on that the rms takes to stay within
    output.surface_tolerance (2e-5 m). "resumed_from" is the instant [s] from which the run went on, 0 from the start.

    Example: tautflex run m2.toml -o m2 --set damping.alpha=0.01 --set solver.end_time=5
    """
    from tautflex.case.run import write_case_run

    loaded = load(case, override)
    return performed(case, loaded, write_case_run, output, form, force=force, resume=resume, checkpoint=checkpoint)


def performed(
    case: Path,
    loaded: Case,
    write: Callable[..., dict[str, Any]],
    output: Path | None,
    form: Formats,
    *,
    force: bool,
    resume: bool,
    checkpoint: float,
) -> Answer:
    """Have a run written into its folder, anew or going on from what is there, and say what came of it."""
    directory = output if output is not None else default_directory(case)
    if force and resume:
        raise CaseError("--force, --resume: expected one of them, got both; --force starts anew, --resume goes on")
    if not 0.0 < checkpoint < math.inf:
        text = f"--checkpoint: expected seconds > 0, got {checkpoint:g}; ask for example --checkpoint 60"
        raise CaseError(f"{text}, or --checkpoint 1e9 for none but where the run is ended")
    require_output_directory(directory)
    with result_folder(directory):
        earlier = _ended(loaded, case, directory, force=force, resume=resume)
        if earlier is not None:
            return earlier
        with about(case), progress_bar() as progress:
            summary = write(
                loaded,
                directory,
                progress,
                figures=partial(run_figures, formats=form or FORMATS),
                title=case.stem,
                seconds=checkpoint,
                resume=resume,
            )
    from tautflex.files.checkpoints import FOLDER

    goes_on = (directory / FOLDER).exists()
    return Answer(summary, partial(_show, case, summary, loaded, goes_on), ENDED[summary["status"]])


def _ended(loaded: Case, case: Path, directory: Path, *, force: bool, resume: bool) -> Answer | None:
    """Answer of a run that is to go on but had ended by itself, None if there is something to do.

    Raises
    ------
    CaseError
        If the folder holds what may not be replaced or does not go on.
    """
    from tautflex.files.earlier import finished, require_no_results

    if resume:
        summary = finished(loaded.to_toml(), directory)
        if summary is not None:
            return Answer(summary, partial(_show_finished, case, summary, loaded), ENDED[summary["status"]])
    elif not force:
        require_no_results(directory, "add --force to replace it or --resume to go on")
    return None


def _show(case: Path, summary: Mapping[str, Any], loaded: Case, goes_on: bool) -> None:
    show_run(case, summary, loaded.output)
    if summary["status"] == "interrupted" and goes_on:  # a loop that was ended early has no checkpoint yet
        say("The same command with --resume goes on from there.")


def _show_finished(case: Path, summary: Mapping[str, Any], loaded: Case) -> None:
    say(f"This run had ended already ({summary['status']}); nothing is left to do.")
    show_run(case, summary, loaded.output)


def default_directory(case: Path) -> Path:
    """Results of ``m2.toml``, wherever it is, go to ``m2`` in the current folder; without suffix ``-run`` is added."""
    return Path(case.stem if case.suffix else f"{case.name}-run")


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
