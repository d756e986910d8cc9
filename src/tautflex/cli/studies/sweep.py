"""`tautflex sweep`: a case at all combinations of the values of a study."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cards import list_files, say
from tautflex.cli.figures import FORMATS, Formats, study_figures
from tautflex.cli.options import Answer, command, require_output_directory
from tautflex.cli.runs.run import default_directory, progress_bar
from tautflex.errors import CaseError

FAILED, INTERRUPTED = 1, 130
StudyFile = Annotated[Path, Parameter(help="Study file (TOML).")]
StudyFolder = Annotated[
    Path | None, Parameter(name=["-o", "--output"], help="Directory for results; default: named like the study.")
]
Workers = Annotated[int | None, Parameter(help="Processes; default: those of the study, else one per core.")]
Scheduler = Annotated[str | None, Parameter(help="Address of a running Dask scheduler, tcp://HOST:8786.")]
Anew = Annotated[
    bool, Parameter(name="--force", help="Go on in a folder with points of another version, which are not used.")
]


@command
def sweep(
    study: StudyFile,
    /,
    *,
    output: StudyFolder = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    dry_run: Annotated[
        bool, Parameter(name="--dry-run", help="Tell what would be run; run and write nothing.")
    ] = False,
    force: Anew = False,
    form: Formats = None,
) -> Answer | int:
    """Run a case at all combinations of the values of a study's axes; write study.nc, table.csv and figures.

    Finished points are kept in the directory and used again: an interrupted command goes on where it stopped when it
    is repeated. A point that fails is labelled, and the exit code is 1.

    Example: tautflex sweep study.toml -o study --workers 2
    """
    if workers is not None and workers < 1:
        raise CaseError(f"--workers: expected a number >= 1, got {workers}; leave it out for one per core")
    directory = output if output is not None else default_directory(study)
    require_output_directory(directory)

    from tautflex.study.sweep import make_plan

    plan = make_plan(study, directory, workers=workers, scheduler=scheduler, force=force)
    if dry_run:
        points, first = len(plan.points), min(plan.invalid, default=None)
        answer: dict[str, Any] = {
            "points": points,
            "done": plan.resumed,
            "failed": len(plan.invalid),
            "resumed": plan.resumed,
            "seconds": 0.0,
            "engine": plan.study.engine.kind,
            "structures": len(plan.structures()),
            "axes": plan.study.lengths,
            "invalid": None if first is None else f"{plan.points.name(first)}: {plan.invalid[first]}",
            "files": {},
        }
        return Answer(answer, partial(_show_plan, answer))

    from tautflex.study.results import counts
    from tautflex.study.sweep import write_sweep

    try:
        with progress_bar() as progress:
            drawn = partial(study_figures, formats=form or FORMATS)
            data, files = write_sweep(plan, directory, progress, drawn)
    except KeyboardInterrupt:
        return tell(f"interrupted; finished points are kept in {directory}: repeat the command to go on", INTERRUPTED)
    told = {name: data.attrs[name] for name in ("resumed", "seconds")}
    answer = {**counts(data), **told, "files": files}
    return Answer(answer, partial(_show, answer, data), FAILED if answer["failed"] else 0)


def tell(text: str, code: int) -> int:
    """Print one line about a broken end; return the exit code."""
    print(f"tautflex: {text}", file=sys.stderr)  # noqa: T201 - the command line's one line about a broken end
    return code


def _show_plan(answer: dict[str, Any]) -> None:
    axes = " x ".join(f"{count} of {name}" for name, count in answer["axes"].items())
    say(f"{answer['points']} points: {axes}")
    structures = f"{answer['structures']} structure{'s' if answer['structures'] != 1 else ''}"
    say(f"engine {answer['engine']}, {structures}, {answer['resumed']} points are finished already")
    if answer["failed"]:
        say(f"{answer['failed']} are not valid, the first: {answer['invalid']}")


def _show(answer: dict[str, Any], data: Any) -> None:
    say(f"{answer['done']} of {answer['points']} points done, {answer['failed']} failed, {answer['resumed']} resumed")
    failures = [text for text in dict.fromkeys(data["message"].values.ravel().tolist()) if text]
    for text in failures[:3]:
        say(f"failed: {text}")
    list_files(answer["files"])
