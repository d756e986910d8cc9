"""Tables that the paper does not have: what each term does, and where the film is compressed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tautflex.paper.cases.catalogue import (
    ABLATION_MANEUVERS,
    LINEAR_FACTORS,
    ablation_runs,
    catalogue,
    response_runs,
)
from tautflex.paper.cases.normal_modes import antenna_name, dominant_mode, frequency_of
from tautflex.paper.cases.run_names import MODELS
from tautflex.paper.tables.paper_tables import Data, PaperTable, case_words, of_antennas, response
from tautflex.paper.tables.rows import Row

_PADDED_DURATION = 10.48576  # [s] of the ablation's records: bins as in Tables 6, 8 and 9
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
_ABLATED = [(model, rate, duration) for rate, duration in ABLATION_MANEUVERS for model in MODELS]


def _ablation_rows(variant: str, data: Data, modes: Data) -> Iterator[Row]:
    """Response frequency, its interpolated value and amplitude with and without each term, and what each term does.

    That is the rise of the interpolated frequency over the dominant mode, with the part of it that goes with a term.
    The small-amplitude limit, at 0.2 to 1 % of the angular velocity, is geometric nonlinearity off: the equations are
    the same, and its amplitude is scaled back.
    """
    for case in _ABLATED:
        words, peaks, factor = case_words(*case), {}, LINEAR_FACTORS[case[0]]
        for suffix, name in ablation_runs(*case).items():
            bin_frequency, peaks[suffix], largest = response(data[name], _PADDED_DURATION)
            note = "trivially zero: Q_T is what moves the antenna" if suffix == "no-load" else ""
            if suffix == "linear":
                largest, note = largest / factor, f"at {factor:g} of the angular velocity, scaled back"
            for quantity, value, unit in (
                ("response frequency", bin_frequency, "Hz"),
                ("interpolated frequency", peaks[suffix], "Hz"),
                ("amplitude", largest, "mm"),
            ):
                known = None if np.isnan(value) else value
                yield Row("ablation", f"{words}: {_WITHOUT[suffix]}", quantity, None, known, unit, note)
        found = modes[antenna_name(case[0])]
        natural = frequency_of(found, dominant_mode(found))
        note = f"interpolated frequency less the {natural:.4f} Hz of the dominant mode"
        yield Row("ablation", words, "rise over the dominant mode", None, peaks["full"] - natural, "Hz", note)
        for suffix, quantity in _SHARES.items():
            yield Row("ablation", words, quantity, None, peaks["full"] - peaks[suffix], "Hz")


def _compression_runs(variant: str) -> list[str]:
    if variant != "published":
        return response_runs(variant)
    ablated = {name for case in _ABLATED for suffix, name in ablation_runs(*case).items() if suffix != "full"}
    return [name for name in catalogue("published", quick=True) if name not in ablated]


def _compression_rows(variant: str, data: Data, modes: Data) -> Iterator[Row]:
    """Smallest principal resultant of the film over each run, and when it is compressed."""
    for name in _compression_runs(variant):
        values, time = data[name]["min_principal_resultant"].values, data[name]["time"].values
        compressed = values < 0.0
        note = "" if compressed.any() else "stays taut"
        for quantity, value, unit in (
            ("smallest principal resultant", float(values.min()), "N/m"),
            ("time of first compression", float(time[compressed.argmax()]) if compressed.any() else None, "s"),
            ("time compressed", 100.0 * float(compressed.mean()), "%"),
        ):
            yield Row("compression", _words(name), quantity, None, value, unit, note, variant)


def _words(name: str) -> str:
    """Put a run's name in words."""
    _, model, rate, duration, *rest = name.split("/")
    words = case_words(model, rate, float(duration.removeprefix("T")))
    return ", ".join([words, *(part.replace("damping", "alpha = beta = ") for part in rest)])


ABLATION = PaperTable(
    lambda variant: [name for case in _ABLATED for name in ablation_runs(*case).values()],
    of_antennas(*MODELS),
    _ablation_rows,
)
"""Terms switched off one by one; of the published reading only."""
COMPRESSION = PaperTable(_compression_runs, of_antennas(), _compression_rows)
