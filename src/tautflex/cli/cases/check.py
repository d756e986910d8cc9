"""`tautflex check`: look at a case."""

from __future__ import annotations

from functools import partial
from typing import Any

from tautflex.cli.cards import show_check
from tautflex.cli.options import Answer, CaseFile, Overrides, about, command, load
from tautflex.errors import InputError


@command
def check(case: CaseFile, /, *, override: Overrides = None) -> Answer:
    """Validate a case, build its model and prestress, summarize and warn.

    Example: tautflex check m2.toml --set mesh.divisions=[20,10]
    """
    try:
        loaded = load(case, override)

        from tautflex.case.advice import advise
        from tautflex.case.build import build_state
        from tautflex.solvers.modal.rigid import mass_center

        with about(case):
            state = build_state(loaded)
            warnings, notes = advise(loaded, state)
    except InputError as error:
        nothing: dict[str, Any] = {
            "ok": False,
            **dict.fromkeys(("nodes", "dofs", "unknowns"), 0),
            "mass": 0.0,
            "mass_center": None,
            "inertia": None,
            "warnings": [],
            "notes": [],
        }
        return Answer(nothing | {"error": str(error)}, list, error=error)
    model = state.model
    center, inertia = mass_center(state.system.inertia)
    answer = {
        "ok": True,
        "nodes": len(model.nodes),
        "dofs": model.dof_count,
        "unknowns": state.system.size,
        "mass": model.mass,
        "mass_center": center.tolist(),
        "inertia": inertia.tolist(),
        "warnings": warnings,
        "notes": notes,
        "prestress": {
            "residual": state.residual,
            "min_principal_stress": state.min_principal_stress,
            "min_principal_resultant": state.min_principal_resultant,
        },
    }
    return Answer(answer, partial(show_check, case, answer))
