"""`tautflex design`: the best values of a case's keys."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cards import list_files, say
from tautflex.cli.figures import FORMATS, Formats, design_figures
from tautflex.cli.options import Answer, command, require_output_directory
from tautflex.cli.runs.run import default_directory, progress_bar
from tautflex.cli.studies.sweep import (
    FAILED,
    INTERRUPTED,
    Anew,
    Scheduler,
    StudyFile,
    StudyFolder,
    Workers,
    tell,
)
from tautflex.errors import CaseError


@command
def design(
    study: StudyFile,
    /,
    *,
    output: StudyFolder = None,
    trials: Annotated[int | None, Parameter(help="Number of trials in all; default: that of the study.")] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    force: Anew = False,
    form: Formats = None,
) -> Answer | int:
    """Search the values of keys that make measures small or large within limits, as a study's [design] says.

    Trials are kept in the directory: an interrupted command goes on where it stopped when it is repeated, and more
    --trials go on with an earlier search. Writes design.nc, trials.csv, history.png and best.toml, the best case.

    Example: tautflex design study.toml -o best --trials 50
    """
    for name, value in (("--workers", workers), ("--trials", trials)):
        if value is not None and value < 1:
            raise CaseError(f"{name}: expected a number >= 1, got {value}; leave it out for the default")
    directory = output if output is not None else default_directory(study)
    require_output_directory(directory)

    from tautflex.study.design import write_design

    asked: dict[str, Any] = {"trials": trials, "workers": workers, "scheduler": scheduler, "force": force}
    try:
        with progress_bar() as progress:
            drawn = partial(design_figures, formats=form or FORMATS)
            data, files = write_design(study, directory, progress=progress, figures=drawn, **asked)
    except KeyboardInterrupt:
        return tell(f"interrupted; finished trials are kept in {directory}: repeat the command to go on", INTERRUPTED)
    best = [
        {str(name): data[name].sel(trial=number).values for name in data.data_vars if data[name].dims == ("trial",)}
        | {"trial": number}
        for number in data.attrs["best"]
    ]
    failed = int((data["status"] != "completed").sum())
    answer = {"trials": data.sizes["trial"], "failed": failed, "best": best, "files": files}
    return Answer(answer, partial(_show, answer, data), 0 if best else FAILED)


def _show(answer: dict[str, Any], data: Any) -> None:
    say(f"{answer['trials']} trials, {answer['failed']} failed, {int(data['feasible'].sum())} keep the limits")
    if not answer["best"]:
        say("no trial keeps the limits; widen the ranges or the limits, or try more")
    for one in answer["best"][:5]:
        told = (f"{name} = {value:.6g}" for name, value in one.items() if name != "trial" and value.dtype.kind == "f")
        say(f"best, trial {one['trial']}: {', '.join(told)}")
    list_files(answer["files"])
