"""`tautflex control`: the closed loop of a case, its results and figures."""

from __future__ import annotations

from functools import partial

from tautflex.cli.cards import show_run
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
from tautflex.cli.runs.run import default_directory, progress_bar
from tautflex.errors import CaseError


@command
def control(
    case: CaseFile,
    /,
    *,
    output: ResultFolder = None,
    force: Force = False,
    override: Overrides = None,
) -> Answer:
    """Run the antenna on its hub under the [controller]; write run.nc, summary.json and figures.

    "settling_time" in the answer is that of attitude (output.attitude_tolerance) and surface (output.surface_tolerance)
    [s] from the end of the maneuver on, "energy_by_source" the work of every actuator [J]. Ctrl-C ends the run early
    and keeps what was computed.

    Example: tautflex control slew.toml -o slew --set controller.damping=60
    """
    loaded = load(case, override)
    directory = output if output is not None else default_directory(case)
    require_output_directory(directory)
    if (directory / "run.nc").exists() and not force:
        text = f"{directory}: expected a directory without results, got one with run.nc"
        raise CaseError(f"{text}; choose another with -o, or add --force")

    from tautflex.case.loop import write_case_loop
    from tautflex.cli.figures import run_figures

    with about(case), progress_bar() as progress:
        summary = write_case_loop(loaded, directory, progress, figures=run_figures, title=case.stem)
    return Answer(summary, partial(show_run, case, summary), 0 if summary["status"] == "completed" else 1)
