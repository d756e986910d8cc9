"""`tautflex init`: write a case."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from shlex import quote
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import say
from tautflex.cli.options import Answer, Force, command, require_new_file
from tautflex.writing import write_text

_FOLLOWING = {"control": "control", "slew": "control", "task-slew": "train", "study": "sweep"} | dict.fromkeys(
    ("task-stop", "task-hold"), "evaluate"
)


@command
def init(
    name: Annotated[Path, Parameter(help="File to write.")],
    /,
    *,
    template: Annotated[
        str,
        Parameter(
            help="m2, the antenna that could be built; m2-paper or m2-nearest-node, readings of the paper; "
            "scalloped, a film cut along arcs with cords in its edges; sail, a triangular solar sail; control, a slew "
            "under closed-loop control; slew, a quiet one under an optimal law; task-slew, task-stop or task-hold, the "
            "learning task of that name, for train and evaluate; study, values of keys for sweep and design."
        ),
    ] = "m2",
    force: Force = False,
) -> Answer:
    """Write a commented case: the paper's antenna M2 and its stop maneuver, a closed loop, a solar sail.

    Example: tautflex init m2.toml
    """
    from tautflex import case

    wanted = {name: case.template(template)}
    others = {name.parent / file: text for file, text in case.template_files(template).items()}
    if template == case.STUDY:  # whose case may be there already
        others = {place: text for place, text in others.items() if force or not place.exists()}
    wanted |= others
    for place in wanted:
        require_new_file(place, force=force)
    for place, text in wanted.items():
        write_text(place, text)
    written = " and ".join(str(place) for place in wanted)
    following = _FOLLOWING.get(template, "run")
    return Answer({"file": name}, partial(say, f"Wrote {written}. Next: tautflex {following} {quote(str(name))}"))
