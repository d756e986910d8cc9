"""`tautflex report`: a run as a page for the browser."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cards import say
from tautflex.cli.options import Answer, Force, about, command, new_file, stored_run
from tautflex.writing import write_or_keep


@command
def report(
    run: Annotated[Path, Parameter(help="Folder of a run, or its run.nc.")],
    other: Annotated[Path | None, Parameter(help="A second one, shown beside the first.")] = None,
    /,
    *,
    output: Annotated[
        Path | None,
        Parameter(name=["-o", "--output"], help="HTML file; default: report.html in the folder of the run."),
    ] = None,
    size: Annotated[float, Parameter(help="Largest size of the page [MB]; what is longer or finer is thinned.")] = 6.0,
    force: Force = False,
) -> Answer:
    """Write a run as one HTML file: the antenna in 3-D as it turns and rings, modes, curves, numbers, the case.

    The file needs no network and opens in any browser.

    Example: tautflex report m2 -o m2.html
    """
    results = [stored_run(path) for path in (run, other) if path is not None]
    target = results[0].parent / "report.html" if output is None else output

    from tautflex.files.netcdf import opened
    from tautflex.pages.report import report as write

    with new_file(target, force=force), ExitStack() as files:
        data = [files.enter_context(opened(path)) for path in results]
        given: dict[str, Any] = {"other": data[-1] if other else None, "size": size, "names": _names(results)}
        files.enter_context(about(run))
        write_or_keep(target, lambda path: write(data[0], path, folder=results[0].parent.parent, **given))
    megabytes = target.stat().st_size / 1e6
    return Answer(
        {"file": target, "megabytes": megabytes},
        partial(say, f"Wrote {target} ({megabytes:.2g} MB); open it in a browser."),
    )


def _names(results: list[Path]) -> tuple[str, str]:
    """What the runs are called: their folders, files where these are the same."""
    folders = [path.resolve().parent.name if path.name == "run.nc" else path.stem for path in results]
    names = folders if len(set(folders)) == len(folders) else [str(path) for path in results]
    return names[0], names[-1]
