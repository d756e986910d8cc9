"""`tautflex authority`: what the actuators of a case can do to its modes."""

from __future__ import annotations

from functools import partial
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import show_authority
from tautflex.cli.options import Answer, CaseFile, Overrides, about, command, load
from tautflex.errors import CaseError


@command
def authority(
    case: CaseFile,
    /,
    *,
    count: Annotated[int, Parameter(name=["-n", "--count"], help="Number of modes.")] = 10,
    override: Overrides = None,
) -> Answer:
    """Tell what each actuator on the structure, at its limit, does to each mode: its stiffness, and the force on it.

    Example: tautflex authority slew.toml -n 6
    """
    if count < 1:
        raise CaseError(f"-n: expected a number of modes >= 1, got {count}; ask for example -n 10")
    loaded = load(case, override)

    from tautflex.case.loop import authority_of_case

    with about(case):
        found = authority_of_case(loaded, count)
    inputs = {
        str(name): {key: found[key].sel(input=name).values for key in ("stiffness", "force", "deflection")}
        | {key: float(found[key].sel(input=name)) for key in ("limit", "stroke")}
        for name in found["input"].values
    }
    answer = {
        "inputs": inputs,
        "frequencies": found["frequency"].values,
        "remarks": [text for text in found.attrs["remarks"].splitlines() if text],
    }
    return Answer(answer, partial(show_authority, case, answer))
