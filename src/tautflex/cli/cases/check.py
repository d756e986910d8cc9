"""`tautflex check`: look at a case."""

from __future__ import annotations

from tautflex.cli.cards import show_check
from tautflex.cli.options import AsJson, CaseFile, Overrides, Plugins, about, load, print_json
from tautflex.errors import InputError


def check(case: CaseFile, /, *, override: Overrides = None, plugin: Plugins = None, as_json: AsJson = False) -> int:
    """Validate a case, build its model and prestress, summarize and warn.

    Example: tautflex check m2.toml --set mesh.divisions=[20,10]
    """
    try:
        loaded = load(case, override, plugin)

        from tautflex.case.build import build_model
        from tautflex.solvers.static.prestress import solve_prestress

        with about(case):
            model = build_model(loaded)
            state = solve_prestress(model)
    except InputError as error:
        if as_json:
            print_json(
                {"ok": False, "nodes": 0, "dofs": 0, "mass": 0.0, "warnings": [], "notes": [], "error": str(error)}
            )
        raise

    from tautflex.case.advice import advise, notes

    answer = {
        "ok": True,
        "nodes": len(model.nodes),
        "dofs": model.dof_count,
        "mass": model.mass,
        "warnings": advise(loaded, state),
        "notes": notes(loaded, state),
        "prestress": {
            "residual": state.residual,
            "min_principal_stress": state.min_principal_stress,
            "min_principal_resultant": state.min_principal_resultant,
        },
    }
    if as_json:
        print_json(answer)
    else:
        show_check(case, answer)
    return 0
