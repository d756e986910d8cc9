"""`tautflex animate`: a film of a run."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cards import say
from tautflex.cli.options import Answer, Force, command, new_file, stored_run
from tautflex.writing import write_or_keep


@command
def animate(
    run: Annotated[Path, Parameter(help="Folder of a run, or its run.nc.")],
    /,
    *,
    output: Annotated[Path, Parameter(name=["-o", "--output"], help="File to write: .gif, .html or .mp4.")],
    magnification: Annotated[float | None, Parameter(help="Factor of the displacements; a round one.")] = None,
    frames: Annotated[int, Parameter(help="Frames at most.")] = 100,
    rate: Annotated[float, Parameter(help="Frames per second.")] = 20.0,
    floating: Annotated[bool, Parameter(help="Stay in the floating frame.")] = False,
    force: Force = False,
) -> Answer:
    """Write a film of the antenna as it turns and rings.

    Example: tautflex animate m2 -o stop.gif
    """
    source = stored_run(run)

    from tautflex.files.netcdf import opened
    from tautflex.plot.animation import animate as film

    with new_file(output, force=force), opened(source) as data:
        asked: dict[str, Any] = {"magnification": magnification, "frames": frames, "rate": rate}
        write_or_keep(output, lambda path: film(data, path, turning=not floating, **asked))
    return Answer({"file": output}, partial(say, f"Wrote {output}."))
