"""`tautflex init`: write a case."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import say
from tautflex.cli.options import Answer, Force, command, require_new_file


@command
def init(
    name: Annotated[Path, Parameter(help="File to write.")],
    /,
    *,
    template: Annotated[
        str,
        Parameter(
            help="m2, the antenna that could be built; m2-paper or m2-nearest-node, readings of the paper; "
            "scalloped, a film cut along arcs with cords in its edges; control, a slew under closed-loop control."
        ),
    ] = "m2",
    force: Force = False,
) -> Answer:
    """Write a commented case: the paper's antenna M2 and its stop maneuver, or a closed loop.

    Example: tautflex init m2.toml
    """
    from tautflex import case

    text = case.template(template)
    require_new_file(name, force=force)
    name.write_text(text, encoding="utf-8")
    following = "control" if template == "control" else "run"
    return Answer({"file": name}, partial(say, f"Wrote {name}. Next: tautflex {following} {name}"))
