"""`tautflex keys`: what can stand in a case file."""

from __future__ import annotations

import sys
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import show_keys
from tautflex.cli.options import Answer, command


@command
def keys(
    section: Annotated[
        str | None,
        Parameter(help="Section of the case file, or study, the keys of a study file; all sections if not given."),
    ] = None,
    /,
    *,
    markdown: Annotated[bool, Parameter(name="--markdown", help="Print the page of the documentation.")] = False,
) -> Answer:
    """List the keys of a case file with units, ranges, defaults and meaning.

    Example: tautflex keys maneuver
    """
    from tautflex.case.help import reference

    if section == "study":
        from tautflex.study.reference import study_reference

        entries = study_reference()
    else:
        entries = reference.reference(section)
    values = [entry.to_json() for entry in entries]
    if markdown:
        return Answer(
            {"sections": values}, lambda: sys.stdout.write(reference.markdown(entries, whole=section is None))
        )
    return Answer({"sections": values}, lambda: show_keys(values))
