"""The paper's tables, ours beside the printed numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

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
_BAND = 0.4  # [Hz]; widths from 0.3 to 0.8 read the same frequencies in the 32 records that were tried


class PaperTable(NamedTuple):
    """One table: functions of the variant that name the runs and the antennas whose modes it needs, and its rows.

    ``build`` is a function of (variant, runs by name, modes by antenna).
    """

    runs: Names
    antennas: Names
    build: Callable[[str, Data, Data], Iterator[Row]]


def response(run: xr.Dataset, padded_duration: float) -> tuple[float, float, float]:
    """Return response frequency [Hz], its interpolated value [Hz], and amplitude [mm] of point A.

    The frequency is the largest bin, in the band of largest energy, of the motion after the maneuver, padded as the
    paper's records are; the amplitude is the largest displacement of the whole record [theory, section 7].
    """
    record = run["w"].sel(probe=POINT)
    peak = dominant_frequency(record, length=padded_duration, after=maneuver_end(run), band=_BAND)
    return peak.frequency, peak.interpolated, 1e3 * amplitude(record)


def case_words(model: str, rate: str, duration: float) -> str:
    """Return a case in words, e.g. ``M1, pi/100 rad/s, T = 0.1 s``."""
    return f"{model}, {rate.replace('_', '/')} rad/s, T = {duration:g} s"


def of_antennas(*models: str) -> Names:
    """Return the function of the variant that names the antennas of some models."""
    return lambda variant: [antenna_name(model, variant) for model in models]


def _parameters(variant: str, runs: Data, modes: Data) -> Iterator[Row]:
    case = model_case("M2", variant).model_dump()
    for row in published.table(1):
        section, _, key = row["key"].partition(".")
        note = "" if section else "a cable's strain is uniaxial: no such parameter"
        ours = float(case[section][key]) if section else None
        if section and ours != row["value"]:
            note = "finer cables: the area per length of edge is that of 11 + 6 cables"
        yield Row("1", "M2", f"{row['component']}: {row['parameter']}", row["value"], ours, row["unit"], note, variant)


def _frequencies(variant: str, runs: Data, modes: Data) -> Iterator[Row]:
    found = modes[antenna_name("M2", variant)]
    for row in published.table(2):
        number, printed = row["mode"], row["frequency"]
        ours, label = frequency_of(found, number), _half_waves(found, number)
        yield Row("2", f"mode {number}", "natural frequency", printed, ours, "Hz", label, variant)


def _similarity(variant: str, runs: Data, modes: Data) -> Iterator[Row]:
    found = modes[antenna_name("M2", variant)]
    decomposition = pod(runs[_section_3_run(variant)], energy=0.99)
    ranked = mac_table(dominant_shape(decomposition, energy=0.99), found, count=len(published.table(3)))
    for k, row in enumerate(published.table(3)):
        number, mac, case = int(ranked["mode"][k]), 100.0 * float(ranked["mac"][k]), f"rank {k + 1}"
        label = _half_waves(found, number)
        yield Row("3", case, "number of the normal mode", row["mode"], number, "1", label, variant)
        yield Row("3", case, "MAC", row["mac"], mac, "%", label, variant)
    printed, total = published.about(3)["cumulative_mac"], 100.0 * float(ranked["cumulative"][-1])
    first, count = 100.0 * float(decomposition["participation"][0]), decomposition.sizes["mode"]
    note = f"of the {count} proper orthogonal modes that reach 99 % the first has {first:.1f} %"
    yield Row("3", "five modes", "cumulative MAC", printed, total, "%", note, variant)


def _models(variant: str, runs: Data, modes: Data) -> Iterator[Row]:
    quantity = "natural frequency of the dominant mode"
    for row in published.table(4):
        model, found = row["model"], modes[antenna_name(row["model"], variant)]
        number, ours = dominant_mode(found), frequency_of(found, 1)
        yield Row("4", model, "fundamental frequency", row["fundamental_frequency"], ours, "Hz", "", variant)
        note = "; ".join(filter(None, (f"our mode {number}, (1,2)", note_for(variant, "4", model, quantity))))
        ours = frequency_of(found, number)
        yield Row("4", model, quantity, row["dominant_frequency"], ours, "Hz", note, variant)


def _responses(table: str, variant: str, runs: Data, modes: Data) -> Iterator[Row]:
    for row in published.table(int(table)):
        maneuver = row["model"], row["rate_name"], row["duration"]
        case, repeats = case_words(*maneuver), str(row.get("repeats", ""))
        frequency, _, largest = response(runs[run_name(*maneuver, variant)], row["padded_duration"])
        if "fundamental_frequency" in row:
            printed, ours = row["fundamental_frequency"], frequency_of(modes[antenna_name(row["model"], variant)], 1)
            yield Row(table, case, "fundamental frequency", printed, ours, "Hz", "", variant)
        for quantity, ours, unit in (("response frequency", frequency, "Hz"), ("amplitude", largest, "mm")):
            note = f"printed in Table {repeats} before" if repeats else note_for(variant, table, case, quantity)
            yield Row(table, case, quantity, row[quantity.replace(" ", "_")], ours, unit, note, variant, repeats)


def _half_waves(modes: xr.Dataset, number: int) -> str:
    return f"half waves ({int(modes['label_m'][number - 1])},{int(modes['label_n'][number - 1])})"


def _section_3_run(variant: str) -> str:
    return run_name("M2", "pi_5", 1.0, variant, SECTION_3)


def _responses_of(number: int, *models: str) -> PaperTable:
    return PaperTable(
        lambda variant: response_runs(variant, (number,)), of_antennas(*models), partial(_responses, str(number))
    )


TABLES: dict[str, PaperTable] = {
    "1": PaperTable(lambda variant: [], of_antennas(), _parameters),
    "2": PaperTable(lambda variant: [], of_antennas("M2"), _frequencies),
    "3": PaperTable(lambda variant: [_section_3_run(variant)], of_antennas("M2"), _similarity),
    "4": PaperTable(lambda variant: [], of_antennas(*MODELS), _models),
    "6": _responses_of(6, *MODELS),
    **{str(number): _responses_of(number) for number in (7, 8, 9)},
}
"""The tables of the paper that hold results (2, 3, 4, 6 to 9) and the parameters behind them (1)."""
