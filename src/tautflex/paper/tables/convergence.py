"""Mesh and step convergence of the consistent variant."""

from __future__ import annotations

import math
from typing import Any

from tautflex.paper.cases.catalogue import COARSE_MESHES, STEP_CHECK, half_step_name, mesh_name, model_case
from tautflex.paper.cases.normal_modes import antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS, run_name
from tautflex.paper.tables import published
from tautflex.paper.tables.paper_tables import Data, PaperTable, case_words, response
from tautflex.paper.tables.rows import Row

_ORDERS = (0.5, 4.0)
"""Observed orders that count as convergence towards a limit; linear triangles have 2 for frequencies."""
_MODES = (1, 4, 10)


def convergence_table() -> PaperTable:
    """Return the table of values on three meshes and with half the step, their change, and their limit.

    The limit is Richardson's, for a ratio of 2 between meshes: order p = log2((f1 - f2) / (f2 - f3)), limit
    f3 + (f3 - f2) / (2^p - 1). It stands only where values approach it from one side with an order from 0.5 to 4.
    """
    cases = {
        (row["model"], row["rate_name"], row["duration"]): row | {"padded": published.about(number)["padded_duration"]}
        for number in published.RESPONSE_TABLES
        for row in published.table(number)
        if "repeats" not in row
    }

    def runs(variant: str) -> list[str]:
        names = []
        for case in cases:
            name = run_name(*case, variant="consistent")
            names += [name, *(mesh_name(name, cells) for cells in COARSE_MESHES)]
            names += [half_step_name(name)] * (case in STEP_CHECK)
        return names

    def antennas(variant: str) -> list[str]:
        names = [antenna_name(model, "consistent") for model in MODELS]
        return names + [mesh_name(name, cells) for name in names for cells in COARSE_MESHES]

    def build(variant: str, data: Data, modes: Data) -> list[Row]:
        found = [row for model in MODELS for row in _mode_rows(model, modes)]
        return found + [row for case, printed in cases.items() for row in _response_rows(case, printed, data)]

    return PaperTable("convergence", "Convergence of the consistent variant", runs, antennas, build)


def richardson(coarse: float, medium: float, fine: float) -> tuple[float, float] | None:
    """Return observed order and limit of values on meshes each half as wide as the one before; None if there is none.

    Parameters
    ----------
    coarse, medium, fine
        Values, coarsest mesh first.
    """
    first, second = coarse - medium, medium - fine
    if second == 0.0 or first / second <= 1.0:
        return None
    order = math.log2(first / second)
    if not _ORDERS[0] <= order <= _ORDERS[1]:
        return None
    return order, fine - second / (2.0**order - 1.0)


def _mode_rows(model: str, modes: Data) -> list[Row]:
    name = antenna_name(model, "consistent")
    keys = [*(mesh_name(name, cells) for cells in COARSE_MESHES), name]
    rows = []
    for number in _MODES if model == "M2" else (1,):
        values = [frequency_of(modes[key], number) for key in keys]
        rows += _rows(f"{model}, mode {number}", "natural frequency", None, values, "Hz")
    values = [frequency_of(modes[key], dominant_mode(modes[key])) for key in keys]
    return rows + _rows(f"{model}, mode (1,2)", "natural frequency", None, values, "Hz")


def _response_rows(case: tuple[str, str, float], printed: dict[str, Any], data: Data) -> list[Row]:
    name = run_name(*case, variant="consistent")
    keys = [*(mesh_name(name, cells) for cells in COARSE_MESHES), name]
    found = [response(data[key], printed["padded"]) for key in keys]
    fine = response(data[half_step_name(name)], printed["padded"]) if case in STEP_CHECK else (None, None, None)
    rows = []
    for k, (quantity, paper, unit) in enumerate(
        (
            ("response frequency", printed["response_frequency"], "Hz"),
            ("interpolated frequency", None, "Hz"),
            ("amplitude", printed["amplitude"], "mm"),
        )
    ):
        rows += _rows(case_words(*case), quantity, paper, [values[k] for values in found], unit, fine[k])
    return rows


def _rows(
    case: str, quantity: str, paper: float | None, values: list[float], unit: str, half_step: float | None = None
) -> list[Row]:
    """Values per mesh, change of the last refinement and of the halved step, limit."""
    meshes = [*COARSE_MESHES, model_case("M2", "consistent").mesh.divisions]
    table = [(f"{cells[0]} x {cells[1]}", value, unit, "") for cells, value in zip(meshes, values, strict=True)]
    table.append(("change of last refinement", 100.0 * (values[-1] / values[-2] - 1.0), "%", ""))
    if half_step is not None:
        table.append(("change with half the step", 100.0 * (half_step / values[-1] - 1.0), "%", ""))
    if quantity != "response frequency" and (limit := richardson(*values)) is not None:
        table.append(("Richardson limit", limit[1], unit, f"observed order {limit[0]:.2f}"))
    label = f"{case}: {quantity}"
    return [
        Row("convergence", label, words, paper if of == unit else None, value, of, note, "consistent")
        for words, value, of, note in table
    ]
