"""`tautflex explore`: a case as a page to play with."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import say
from tautflex.cli.options import Answer, CaseFile, Force, Overrides, about, command, load, new_file
from tautflex.writing import write_or_keep


@command
def explore(
    case: CaseFile,
    /,
    *,
    output: Annotated[Path, Parameter(name=["-o", "--output"], help="HTML file.")] = Path("explorer.html"),
    override: Overrides = None,
    force: Force = False,
) -> Answer:
    """Write the reduced antenna of a case as one HTML file that steps it: sliders, and a film to push.

    The file needs no network and opens in any browser. What the case leaves open is chosen, and the page says how: a
    hub, drives for the tension of its cables, attitude control, a slew.

    Example: tautflex explore m2.toml -o explorer.html
    """
    with new_file(output, force=force):
        loaded = load(case, override)

        from tautflex.pages.explorer import explore as write

        with about(case):
            write_or_keep(output, lambda path: write(loaded, path, title=f"Explorer: {case.stem}"))
    megabytes = output.stat().st_size / 1e6
    return Answer(
        {"file": output, "megabytes": megabytes},
        partial(say, f"Wrote {output} ({megabytes:.2g} MB); open it in a browser."),
    )
