"""`tautflex control`: the closed loop of a case, its results and figures."""

from __future__ import annotations

from functools import partial

from tautflex.cli.cards import show_run
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
)
from tautflex.cli.runs.run import ENDED, Resume, Seconds, default_directory, ended, progress_bar
from tautflex.files.transaction import result_folder


@command
def control(
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
    """Run the antenna on its hub under the [controller]; write run.nc, summary.json and figures.

    "settling_time" in the answer is that of attitude (output.attitude_tolerance) and surface (output.surface_tolerance)
    [s] from the end of the maneuver on, "energy_by_source" the work of every actuator [J]. Ctrl-C, SIGTERM and
    SIGHUP end the run early and keep what was computed; --resume goes on, and after a kill too, to the bit. A loop has
    checkpoints at the ends of stretches of 1024 intervals, if --checkpoint seconds went by.

    Example: tautflex control slew.toml -o slew --set controller.damping=60
    """
    loaded = load(case, override)
    directory = output if output is not None else default_directory(case)
    earlier = ended(loaded, case, directory, force=force, resume=resume, checkpoint=checkpoint)
    if earlier is not None:
        return earlier

    from tautflex.case.loop import write_case_loop

    with result_folder(directory), about(case), progress_bar() as progress:
        summary = write_case_loop(
            loaded,
            directory,
            progress,
            figures=partial(run_figures, formats=form or FORMATS),
            title=case.stem,
            seconds=checkpoint,
            resume=resume,
        )
    return Answer(summary, partial(show_run, case, summary), ENDED[summary["status"]])
