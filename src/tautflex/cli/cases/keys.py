"""`tautflex keys`: what can stand in a case file."""

from __future__ import annotations

import sys
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import show_keys
from tautflex.cli.options import AsJson, Plugins, print_json, use_plugins


def keys(
    section: Annotated[str | None, Parameter(help="Section of the case file; all if not given.")] = None,
    /,
    *,
    markdown: Annotated[bool, Parameter(name="--markdown", help="Print the page of the documentation.")] = False,
    plugin: Plugins = None,
    as_json: AsJson = False,
) -> int:
    """List the keys of a case file with units, ranges, defaults and meaning.

    Example: tautflex keys maneuver
    """
    use_plugins(plugin)

    from tautflex.case.help import reference

    entries = reference.reference(section)
    if as_json:
        print_json({"sections": [entry.to_json() for entry in entries]})
    elif markdown:
        sys.stdout.write(reference.markdown(entries))
    else:
        show_keys([entry.to_json() for entry in entries])
    return 0
