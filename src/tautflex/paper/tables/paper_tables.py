"""The paper's tables, ours beside the printed numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from tautflex.analysis import amplitude, dominant_frequency, dominant_shape, mac_table, maneuver_end, pod
from tautflex.paper.cases.catalogue import model_case, response_runs
from tautflex.paper.cases.normal_modes import antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS, SECTION_3, run_name
from tautflex.paper.tables import published
from tautflex.paper.tables.notes import note_for
from tautflex.paper.tables.rows import Row

Data = Mapping[str, xr.Dataset]
Names = Callable[[str], list[str]]
POINT = "A"
"""The paper's measuring point."""


@dataclass(frozen=True)
class PaperTable:
    """One table: what it needs and how it is made.

    Attributes
    ----------
    number
        As printed, or the name of an extra table.
    title
        Heading.
    runs, antennas
        Functions of the variant that name the runs and the antennas whose modes it needs.
    build
        Function (variant, runs by name, modes by antenna) that returns the rows.
    """

    number: str
    title: str
    runs: Names
    antennas: Names
    build: Callable[[str, Data, Data], list[Row]]


def response(run: xr.Dataset, padded_duration: float) -> tuple[float, float, float]:
    """Return response frequency [Hz], its interpolated value [Hz], and amplitude [mm] of point A.

    The frequency is the bin of largest energy of the motion after the maneuver, padded as the paper's records are; the
    amplitude is the largest displacement of the whole record [theory, section 7].
    """
    record = run["w"].sel(probe=POINT)
    peak = dominant_frequency(record, length=padded_duration, after=maneuver_end(run))
    return peak.frequency, peak.interpolated, 1e3 * amplitude(record)


def case_words(model: str, rate: str, duration: float) -> str:
    """Return a case in words, e.g. ``M1, pi/100 rad/s, T = 0.1 s``."""
    return f"{model}, {rate.replace('_', '/')} rad/s, T = {duration:g} s"


def _parameters(variant: str, runs: Data, modes: Data) -> list[Row]:
    case = model_case("M2", variant).model_dump()
    rows = []
    for row in published.table(1):
        section, _, key = row["key"].partition(".")
        note = "" if section else "a cable's strain is uniaxial: no such parameter"
        ours = float(case[section][key]) if section else None
        if section and ours != row["value"]:
            note = "finer cables: the area per length of edge is that of 11 + 6 cables"
        quantity = f"{row['component']}: {row['parameter']}"
        rows.append(Row("1", "M2", quantity, row["value"], ours, row["unit"], note, variant))
    return rows


def _frequencies(variant: str, runs: Data, modes: Data) -> list[Row]:
    found = modes[antenna_name("M2", variant)]
    rows = []
    for row in published.table(2):
        number = row["mode"]
        label = f"half waves ({int(found['label_m'][number - 1])},{int(found['label_n'][number - 1])})"
        ours = frequency_of(found, number)
        rows.append(Row("2", f"mode {number}", "natural frequency", row["frequency"], ours, "Hz", label, variant))
    return rows


def _similarity(variant: str, runs: Data, modes: Data) -> list[Row]:
    found = modes[antenna_name("M2", variant)]
    decomposition = pod(runs[_section_3_run(variant)], energy=0.99)
    ranked = mac_table(dominant_shape(decomposition, energy=0.99), found, count=len(published.table(3)))
    rows = []
    for k, row in enumerate(published.table(3)):
        number = int(ranked["mode"][k])
        label = f"half waves ({int(found['label_m'][number - 1])},{int(found['label_n'][number - 1])})"
        case = f"rank {k + 1}"
        rows.append(Row("3", case, "number of the normal mode", row["mode"], number, "1", label, variant))
        rows.append(Row("3", case, "MAC", row["mac"], 100.0 * float(ranked["mac"][k]), "%", label, variant))
    total, words = 100.0 * float(ranked["cumulative"][-1]), "cumulative MAC"
    first, count = 100.0 * float(decomposition["participation"][0]), decomposition.sizes["mode"]
    note = f"of the {count} proper orthogonal modes that reach 99 % the first has {first:.1f} %"
    rows.append(Row("3", "five modes", words, published.about(3)["cumulative_mac"], total, "%", note, variant))
    return rows


def _models(variant: str, runs: Data, modes: Data) -> list[Row]:
    rows = []
    for row in published.table(4):
        model, found = row["model"], modes[antenna_name(row["model"], variant)]
        number = dominant_mode(found)
        quantity = "natural frequency of the dominant mode"
        note = "; ".join(filter(None, (f"our mode {number}, (1,2)", note_for(variant, "4", model, quantity))))
        ours = frequency_of(found, 1)
        rows.append(Row("4", model, "fundamental frequency", row["fundamental_frequency"], ours, "Hz", "", variant))
        rows.append(
            Row("4", model, quantity, row["dominant_frequency"], frequency_of(found, number), "Hz", note, variant)
        )
    return rows


def _responses(number: int) -> Callable[[str, Data, Data], list[Row]]:
    def build(variant: str, runs: Data, modes: Data) -> list[Row]:
        rows = []
        for row in published.table(number):
            rows += _response_rows(number, row, variant, runs, modes)
        return rows

    return build


def _response_rows(number: int, row: dict[str, Any], variant: str, runs: Data, modes: Data) -> list[Row]:
    maneuver = row["model"], row["rate_name"], row["duration"]
    case, table = case_words(*maneuver), str(number)
    frequency, _, largest = response(runs[run_name(*maneuver, variant)], published.about(number)["padded_duration"])
    rows = []
    if "fundamental_frequency" in row:
        ours = frequency_of(modes[antenna_name(row["model"], variant)], 1)
        rows.append(Row(table, case, "fundamental frequency", row["fundamental_frequency"], ours, "Hz", "", variant))
    repeats = str(row.get("repeats", ""))
    for quantity, value, unit in (("response frequency", frequency, "Hz"), ("amplitude", largest, "mm")):
        note = f"printed in Table {repeats} before" if repeats else note_for(variant, table, case, quantity)
        rows.append(Row(table, case, quantity, row[quantity.replace(" ", "_")], value, unit, note, variant, repeats))
    return rows


def _section_3_run(variant: str) -> str:
    return run_name("M2", "pi_5", 1.0, variant, SECTION_3)


def _none(variant: str) -> list[str]:
    return []


def _m2(variant: str) -> list[str]:
    return [antenna_name("M2", variant)]


def _all_models(variant: str) -> list[str]:
    return [antenna_name(model, variant) for model in MODELS]


def _runs_of(number: int) -> Names:
    return lambda variant: response_runs(variant, (number,))


TABLES: dict[str, PaperTable] = {
    table.number: table
    for table in (
        PaperTable("1", published.about(1)["title"], _none, _none, _parameters),
        PaperTable("2", published.about(2)["title"], _none, _m2, _frequencies),
        PaperTable("3", published.about(3)["title"], lambda variant: [_section_3_run(variant)], _m2, _similarity),
        PaperTable("4", published.about(4)["title"], _none, _all_models, _models),
        PaperTable("6", published.about(6)["title"], _runs_of(6), _all_models, _responses(6)),
        *(PaperTable(str(k), published.about(k)["title"], _runs_of(k), _none, _responses(k)) for k in (7, 8, 9)),
    )
}
"""The tables of the paper that hold results (2, 3, 4, 6 to 9) and the parameters behind them (1)."""
