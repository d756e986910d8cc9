"""`tautflex modes`: natural frequencies and shapes."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cases import spinning
from tautflex.cli.figures import FORMATS, Formats, mode_figures
from tautflex.cli.options import Answer, CaseFile, Overrides, about, command, load, require_output_directory
from tautflex.cli.spinning_cards import show_modes_and_spin
from tautflex.errors import CaseError
from tautflex.files.transaction import publish, result_folder


@command
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
    form: Formats = None,
) -> Answer:
    """Natural frequencies, labels and symmetry about the prestressed state; on request also of the spinning structure.

    Example: tautflex modes m2.toml -n 10 -o m2-modes --campbell 0:2:9 --axis z --participation m2.json
    """
    if count < 1:
        raise CaseError(f"-n: expected a number of modes >= 1, got {count}; ask for example -n 10")
    loaded = load(case, override)
    request = spinning.read_request(rate, campbell, axis, loaded)
    place = spinning.read_place(point, participation)
    if output is not None:
        require_output_directory(output)

    from tautflex.case.build import build_state
    from tautflex.solvers.modal.natural import solve_modes

    extra: dict[str, Any] = {}
    with about(case):
        state = build_state(loaded)
        found = solve_modes(state, n=count)
        if free := state.system.model.rigid_freedom:
            extra["rigid_motions"] = free
        if loaded.hub is not None:
            extra["on_free_hub"] = solve_modes(state, n=count, hub=loaded.hub.build()).frequencies
        if request.rate is not None:
            extra["spinning"] = spinning.solve_single(loaded, state, request, count)
        table = spinning.solve_table(loaded, state, request, count) if request.rates is not None else None
        if participation is not None:
            extra["participation"] = spinning.write_participation(loaded, found, place, participation)
    if table is not None:
        extra["campbell"] = spinning.table_numbers(table)
    files = {} if participation is None else {participation.name: participation}
    if output is not None:
        draw = partial(mode_figures, found.to_dataset(), campbell=table, formats=form or FORMATS)
        with result_folder(output):
            written = publish(output, lambda place, final: [final / path.name for path in draw(place)])
        files |= {path.name: path for path in written}
    answer: dict[str, Any] = {
        "frequencies": found.frequencies,
        "labels": found.labels,
        "symmetry": found.symmetry,
        "prestress": {"residual": state.residual, "min_principal_resultant": state.min_principal_resultant},
        "files": files,
        **extra,
    }
    return Answer(answer, partial(show_modes_and_spin, case, answer))
