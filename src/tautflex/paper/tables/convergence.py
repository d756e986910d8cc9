"""Mesh and step convergence of the consistent variant."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from tautflex.paper.cases.catalogue import COARSE_MESHES, STEP_CHECK, half_step_name, mesh_name, model_case
from tautflex.paper.cases.normal_modes import antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS, run_name
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import Data, PaperTable, case_words, response
from tautflex.paper.tables.rows import Row

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
    names = []
    for case in _CASES:
        name = run_name(*case, variant="consistent")
        names += [*_on_meshes(name), *[half_step_name(name)] * (case in STEP_CHECK)]
    return names


def _antennas(variant: str) -> list[str]:
    return [name for model in MODELS for name in _on_meshes(antenna_name(model, "consistent"))]


def _on_meshes(name: str) -> list[str]:
    """Names of a run or an antenna on every mesh, coarsest first."""
    return [*(mesh_name(name, cells) for cells in COARSE_MESHES), name]


def _build(variant: str, data: Data, modes: Data) -> Iterator[Row]:
    """Values on three meshes and with half the step, their change, and their limit."""
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
