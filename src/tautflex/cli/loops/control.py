"""`tautflex control`: the closed loop of a case, its results and figures."""

from __future__ import annotations

from tautflex.cli.figures import Formats
from tautflex.cli.options import Answer, CaseFile, Force, Overrides, ResultFolder, command, load
from tautflex.cli.runs.run import Resume, Seconds, performed


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

    "settling_time" in the answer is that of surface (output.surface_tolerance) and, where the law turns the hub, of
    attitude (output.attitude_tolerance) [s] from the end of the maneuver on, "energy_by_source" the work of every
    actuator [J]. Ctrl-C, SIGTERM and SIGHUP end the run early and keep what was computed; --resume goes on, and after
    a kill too, to the bit. A loop has checkpoints at the ends of stretches of 1024 intervals, if --checkpoint seconds
    went by.

    Example: tautflex control slew.toml -o slew --set controller.damping=60
    """
    from tautflex.case.loop import write_case_loop

    loaded = load(case, override)
    return performed(case, loaded, write_case_loop, output, form, force=force, resume=resume, checkpoint=checkpoint)
