"""Tables that the paper does not have: what each term does, and where the film is compressed."""

from __future__ import annotations

import numpy as np
import xarray as xr

from tautflex.paper.cases.catalogue import (
    ABLATION_MANEUVERS,
    LINEAR_FACTORS,
    ablation_runs,
    catalogue,
    response_runs,
)
from tautflex.paper.cases.normal_modes import antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS, RATES
from tautflex.paper.tables.paper_tables import Data, PaperTable, case_words, response
from tautflex.paper.tables.rows import Row

PADDED_DURATION = 10.48576
"""Padded duration [s] of the ablation's records: bins as in Tables 6, 8 and 9."""
_WITHOUT = {
    "full": "everything",
    "no-gyroscopic": "without G",
    "no-euler": "without Euler K_T",
    "no-centrifugal": "without centrifugal K_T",
    "no-rotation": "without G and K_T",
    "no-load": "without Q_T",
    "linear": "small-amplitude limit",
}
_SHARES = {
    "no-gyroscopic": "rise from G",
    "no-euler": "rise from Euler K_T",
    "no-centrifugal": "rise from centrifugal K_T",
    "no-rotation": "rise from G and K_T",
    "linear": "rise from geometric nonlinearity",
}


def ablation_table() -> PaperTable:
    """Return the table of the terms that are switched off one by one; the published reading only.

    Rows give the response frequency (its bin, and the interpolated peak that shows changes below a bin) and the
    amplitude with and without each term, and the rise of the interpolated frequency over the dominant mode with the
    part of it that goes with a term. The small-amplitude limit, at 0.2 to 1 % of the angular velocity, is geometric
    nonlinearity off: the equations are the same, and its amplitude is scaled back.
    """
    cases = [(model, rate, duration) for rate, duration in ABLATION_MANEUVERS for model in MODELS]

    def runs(variant: str) -> list[str]:
        return [name for case in cases for name in ablation_runs(*case).values()]

    def antennas(variant: str) -> list[str]:
        return [antenna_name(model) for model in MODELS]

    def build(variant: str, data: Data, modes: Data) -> list[Row]:
        return [row for case in cases for row in _ablation_rows(case, data, modes)]

    return PaperTable("ablation", "What each term does to the response of point A", runs, antennas, build)


def compression_table() -> PaperTable:
    """Return the table of the film's smallest principal resultant over each run, and of when it is compressed."""

    def runs(variant: str) -> list[str]:
        if variant == "consistent":
            return response_runs(variant)
        return [name for name in catalogue("published") if not _is_ablation(name)]

    def build(variant: str, data: Data, modes: Data) -> list[Row]:
        return [row for name in runs(variant) for row in _compression_rows(name, variant, data[name])]

    return PaperTable("compression", "Compression of the film", runs, lambda variant: [], build)


def _ablation_rows(case: tuple[str, str, float], data: Data, modes: Data) -> list[Row]:
    words, rows, peaks = case_words(*case), [], {}
    for suffix, name in ablation_runs(*case).items():
        bin_frequency, peaks[suffix], largest = response(data[name], PADDED_DURATION)
        note = ""
        if suffix == "linear":
            largest, note = (
                largest / LINEAR_FACTORS[case[0]],
                f"at {LINEAR_FACTORS[case[0]]:g} of the angular velocity, scaled back",
            )
        if suffix == "no-load":
            note = "trivially zero: Q_T is what moves the antenna"
        for quantity, value, unit in (
            ("response frequency", bin_frequency, "Hz"),
            ("interpolated frequency", peaks[suffix], "Hz"),
            ("amplitude", largest, "mm"),
        ):
            known = None if np.isnan(value) else value
            rows.append(Row("ablation", f"{words}: {_WITHOUT[suffix]}", quantity, None, known, unit, note))
    found = modes[antenna_name(case[0])]
    natural = frequency_of(found, dominant_mode(found))
    total = peaks["full"] - natural
    note = f"interpolated frequency less the {natural:.4f} Hz of the dominant mode"
    rows.append(Row("ablation", words, "rise over the dominant mode", None, total, "Hz", note))
    for suffix, quantity in _SHARES.items():
        rows.append(Row("ablation", words, quantity, None, peaks["full"] - peaks[suffix], "Hz"))
    return rows


def _compression_rows(name: str, variant: str, run: xr.Dataset) -> list[Row]:
    values, time = run["min_principal_resultant"].values, run["time"].values
    compressed = values < 0.0
    first = float(time[compressed.argmax()]) if compressed.any() else None
    case = _words(name)
    measures = (
        ("smallest principal resultant", float(values.min()), "N/m"),
        ("time of first compression", first, "s"),
        ("time compressed", 100.0 * float(compressed.mean()), "%"),
    )
    note = "" if compressed.any() else "stays taut"
    return [Row("compression", case, quantity, None, value, unit, note, variant) for quantity, value, unit in measures]


def _is_ablation(name: str) -> bool:
    return name in {
        run
        for rate, duration in ABLATION_MANEUVERS
        for model in MODELS
        for suffix, run in ablation_runs(model, rate, duration).items()
        if suffix != "full"
    }


def _words(name: str) -> str:
    """Put a run's name in words."""
    _, model, rate, duration, *rest = name.split("/")
    assert rate in RATES
    words = case_words(model, rate, float(duration.removeprefix("T")))
    return ", ".join([words, *(part.replace("damping", "alpha = beta = ") for part in rest)])
