"""`tautflex modes` and `tautflex tune`: natural frequencies, and tensions that give wanted ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cases import spinning
from tautflex.cli.options import (
    AsJson,
    CaseFile,
    Force,
    Overrides,
    about,
    print_json,
    require_new_file,
    require_output_directory,
)
from tautflex.errors import CaseError

if TYPE_CHECKING:
    from tautflex.case import Case


def modes(
    case: CaseFile,
    /,
    *,
    count: Annotated[int, Parameter(name=["-n", "--count"], help="Number of modes.")] = 10,
    output: Annotated[Path | None, Parameter(name=["-o", "--output"], help="Directory for plots.")] = None,
    campbell: Annotated[
        str | None,
        Parameter(name="--campbell", help="Frequencies over the spin rate, start:stop:count [rad/s], e.g. 0:2:9."),
    ] = None,
    rate: Annotated[float | None, Parameter(name="--rate", help="Complex modes spinning at one rate [rad/s].")] = None,
    axis: Annotated[
        str | None, Parameter(name="--axis", help="Spin axis, x, y, z or ax,ay,az; default: that of the maneuver.")
    ] = None,
    participation: Annotated[
        Path | None,
        Parameter(name="--participation", help="File for attitude control: .json, .npz or .csv; an old one goes."),
    ] = None,
    point: Annotated[
        str | None, Parameter(name="--point", help="Reference point of --participation, x,y,z [m]; default 0,0,0.")
    ] = None,
    override: Overrides = None,
    as_json: AsJson = False,
) -> int:
    """Natural frequencies, labels and symmetry about the prestressed state; on request also of the spinning structure.

    Example: tautflex modes m2.toml -n 10 -o m2-modes --campbell 0:2:9 --axis z --participation m2.json
    """
    from tautflex.case import load_case

    if count < 1:
        raise CaseError(f"-n: expected a number of modes >= 1, got {count}; ask for example -n 10")
    loaded = load_case(case, override or ())
    request = spinning.read_request(rate, campbell, axis, loaded)
    place = spinning.read_place(point, participation)
    if output is not None:
        require_output_directory(output)

    from tautflex.case.build import build_model
    from tautflex.solvers.modal.natural import solve_modes
    from tautflex.solvers.static.prestress import solve_prestress

    extra: dict[str, Any] = {}
    with about(case):
        state = solve_prestress(build_model(loaded))
        found = solve_modes(state, n=count)
        if request.rate is not None:
            extra["spinning"] = spinning.solve_single(loaded, state, request, count)
        table = spinning.solve_table(loaded, state, request, count) if request.rates is not None else None
        if participation is not None:
            extra["participation"] = spinning.write_participation(loaded, found, place, participation)
    if table is not None:
        extra["campbell"] = spinning.table_numbers(table)
    files: dict[str, str] = {} if participation is None else {participation.name: str(participation)}
    if output is not None:
        from tautflex.cli.figures import mode_figures

        output.mkdir(parents=True, exist_ok=True)
        written = mode_figures(found.to_dataset(), output)
        if table is not None:
            written += spinning.campbell_figure(table, output)
        files |= {path.name: str(path) for path in written}
    answer: dict[str, Any] = {
        "frequencies": [float(value) for value in found.frequencies],
        "labels": [None if label is None else [int(half_waves) for half_waves in label] for label in found.labels],
        "symmetry": list(found.symmetry),
        "prestress": {
            "residual": state.residual,
            "min_principal_resultant": state.min_principal_resultant,
        },
        "files": files,
        **extra,
    }
    if as_json:
        print_json(answer)
    else:
        from tautflex.cli.cards import show_modes

        spinning.show_spinning(answer)
        show_modes(case, answer)
    return 0


def tune(
    case: CaseFile,
    /,
    *,
    frequency: Annotated[
        list[float],
        Parameter(name="--frequency", help="Wanted natural frequency [Hz]; twice scales x and y apart."),
    ],
    mode: Annotated[
        list[int] | None,
        Parameter(name="--mode", help="Mode that shall have it, from 1; once per frequency."),
    ] = None,
    output: Annotated[Path | None, Parameter(name=["-o", "--output"], help="File for the tuned case.")] = None,
    force: Force = False,
    override: Overrides = None,
    as_json: AsJson = False,
) -> int:
    """Scale the cable tensions until chosen natural frequencies hit their targets.

    Example: tautflex tune m2.toml --frequency 1.0 -o tuned.toml
    """
    from tautflex.case import load_case

    numbers = mode or list(range(1, len(frequency) + 1))
    if not 1 <= len(frequency) <= 2 or len(numbers) != len(frequency):
        text = f"--frequency, --mode: expected one or two pairs, got {len(frequency)} and {len(numbers)}"
        raise CaseError(f"{text}; give one --mode per --frequency")
    loaded = load_case(case, override or ())
    if loaded.cables is None:
        text = f"{case}: membrane.edges: expected 'cables', got {loaded.membrane.edges!r}"
        raise CaseError(f"{text}; tuning scales cable tensions, for a fixed film choose membrane.stress_x and stress_y")
    if output is not None:
        require_new_file(output, force=force)

    from tautflex.case.build import build_model
    from tautflex.solvers.modal.tuning import tune_pretension

    with about(case):
        result = tune_pretension(build_model(loaded), frequencies=frequency, modes=numbers)
    tuned = _scaled(loaded, float(result.scale_x), float(result.scale_y))
    assert tuned.cables is not None
    answer: dict[str, Any] = {
        "pretension_x": tuned.cables.pretension_x,
        "pretension_y": tuned.cables.pretension_y,
        "frequencies": [float(value) for value in result.frequencies],
        "files": {},
    }
    if output is not None:
        output.write_text(f"# {case.name}, tuned by `tautflex tune`\n\n{tuned.to_toml()}", encoding="utf-8")
        answer["files"] = {"case": str(output)}
    if as_json:
        print_json(answer)
    else:
        from tautflex.cli.cards import show_tuning

        show_tuning(case, answer)
    return 0


def _scaled(case: Case, scale_x: float, scale_y: float) -> Case:
    """Scale the tensions of a case, and with them a film stress that the case states by itself."""
    assert case.cables is not None
    changes: dict[str, dict[str, Any]] = {
        "cables": {
            "pretension_x": case.cables.pretension_x * scale_x,
            "pretension_y": case.cables.pretension_y * scale_y,
        }
    }
    if case.membrane.stress_x is not None and case.membrane.stress_y is not None:
        changes["membrane"] = {
            "stress_x": case.membrane.stress_x * scale_x,
            "stress_y": case.membrane.stress_y * scale_y,
        }
    return case.replaced(**changes)
