"""Mesh and step convergence: of the published reading as a whole, of the consistent variant run by run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from tautflex.paper.cases.catalogue import (
    COARSE_MESHES,
    FITTED_MESHES,
    OTHER_STEPS,
    STEP_CHECK,
    half_step_name,
    mesh_name,
    model_case,
)
from tautflex.paper.cases.normal_modes import antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS, run_name
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import TABLES, Data, PaperTable, case_words, response
from tautflex.paper.tables.rows import Row, mean_difference, mean_log_ratio

_ORDERS = (0.5, 4.0)
"""Observed orders that count as convergence towards a limit; linear triangles have 2 for frequencies."""
_MODES = (1, 4, 10)
_CASES = {
    (row["model"], row["rate_name"], row["duration"]): row
    for number in published.RESPONSE_TABLES
    for row in published.table(number)
    if "repeats" not in row
}


def richardson(coarse: float, medium: float, fine: float) -> tuple[float, float] | None:
    """Return observed order and limit of values on meshes each half as wide as the one before; None if there is none.

    Order p = log2((f1 - f2) / (f2 - f3)), limit f3 + (f3 - f2) / (2^p - 1). They stand only where values approach the
    limit from one side with an order from 0.5 to 4.
    """
    first, second = coarse - medium, medium - fine
    if second == 0.0 or first / second <= 1.0:
        return None
    order = math.log2(first / second)
    if not _ORDERS[0] <= order <= _ORDERS[1]:
        return None
    return order, fine - second / (2.0**order - 1.0)


def _runs(variant: str) -> list[str]:
    names = [run_name(*case, variant=variant) for case in _CASES]
    if variant == "published":
        return [each for name in names for each in (name, *_varied(name))]
    halved = [half_step_name(run_name(*case, variant=variant)) for case in STEP_CHECK]
    return [each for name in names for each in _on_meshes(name)] + halved


def _antennas(variant: str) -> list[str]:
    if variant == "published":
        meshes = [mesh_name(antenna_name("M2"), cells) for cells in FITTED_MESHES]
        return [*map(antenna_name, MODELS), *meshes]
    return [name for model in MODELS for name in _on_meshes(antenna_name(model, variant))]


def _varied(name: str) -> list[str]:
    """Names of a run of the published reading on other meshes and with other solvers."""
    return [*(mesh_name(name, cells) for cells in FITTED_MESHES), *(f"{name}/{words}" for words in OTHER_STEPS)]


def _of_the_reading(data: Data, modes: Data) -> Iterator[Row]:
    """Agreement of the published reading with Tables 2 and 6 to 9, mesh by mesh and solver by solver.

    On each mesh the film's two tensions are fitted to Table 2; nothing else differs.
    """
    own, antenna = model_case("M2"), antenna_name("M2")
    meshes = {cells: mesh_name("", cells) for cells in FITTED_MESHES} | {own.mesh.divisions: ""}
    changes = {f"{cells[0]} x {cells[1]} cells": (suffix, suffix) for cells, suffix in sorted(meshes.items())}
    changes |= {words: (f"/{words}", "") for words in OTHER_STEPS}
    for words, (suffix, mesh) in changes.items():
        runs = {run_name(*case): data[run_name(*case) + suffix] for case in _CASES}
        tables = [row for number in "6789" for row in TABLES[number].build("published", runs, modes)]
        second = list(TABLES["2"].build("published", {}, {antenna: modes[antenna + mesh]}))
        yield Row("convergence", words, "Table 2", None, 100.0 * mean_difference(second), "%")
        for quantity in ("response frequency", "amplitude"):
            score = mean_log_ratio(tables, quantity)
            yield Row("convergence", words, f"Tables 6 to 9, {quantity}", None, score, "1")
        for row in tables:
            if row.case == case_words("M1", "pi_2", 0.1):
                yield Row("convergence", words, f"{row.case}, {row.quantity}", row.paper, row.ours, row.unit)


def _on_meshes(name: str) -> list[str]:
    """Names of a run or an antenna on every mesh, coarsest first."""
    return [*(mesh_name(name, cells) for cells in COARSE_MESHES), name]


def _build(variant: str, data: Data, modes: Data) -> Iterator[Row]:
    """Agreement of the published reading; values of the consistent variant, their change, and their limit."""
    if variant == "published":
        yield from _of_the_reading(data, modes)
        return
    for model in MODELS:
        found = [modes[key] for key in _on_meshes(antenna_name(model, "consistent"))]
        for number in _MODES if model == "M2" else (1,):
            values = [frequency_of(each, number) for each in found]
            yield from _rows(f"{model}, mode {number}", "natural frequency", None, values, "Hz")
        values = [frequency_of(each, dominant_mode(each)) for each in found]
        yield from _rows(f"{model}, mode (1,2)", "natural frequency", None, values, "Hz")
    for case, printed in _CASES.items():
        name, padded = run_name(*case, variant="consistent"), printed["padded_duration"]
        measured = [response(data[key], padded) for key in _on_meshes(name)]
        half = response(data[half_step_name(name)], padded) if case in STEP_CHECK else (None, None, None)
        for k, (quantity, paper, unit) in enumerate(
            (
                ("response frequency", printed["response_frequency"], "Hz"),
                ("interpolated frequency", None, "Hz"),
                ("amplitude", printed["amplitude"], "mm"),
            )
        ):
            yield from _rows(case_words(*case), quantity, paper, [values[k] for values in measured], unit, half[k])


def _rows(
    case: str, quantity: str, paper: float | None, values: Sequence[float], unit: str, half_step: float | None = None
) -> Iterator[Row]:
    """Values per mesh, change of the last refinement and of the halved step, limit."""
    meshes = [*COARSE_MESHES, model_case("M2", "consistent").mesh.divisions]
    table = [(f"{cells[0]} x {cells[1]}", value, unit, "") for cells, value in zip(meshes, values, strict=True)]
    table.append(("change of last refinement", 100.0 * (values[-1] / values[-2] - 1.0), "%", ""))
    if half_step is not None:
        table.append(("change with half the step", 100.0 * (half_step / values[-1] - 1.0), "%", ""))
    if quantity != "response frequency" and (limit := richardson(*values)) is not None:
        table.append(("Richardson limit", limit[1], unit, f"observed order {limit[0]:.2f}"))
    for words, value, of, note in table:
        printed = paper if of == unit else None
        yield Row("convergence", f"{case}: {quantity}", words, printed, value, of, note, "consistent")


CONVERGENCE = PaperTable(_runs, _antennas, _build)
