"""The spin-up of a cantilever: cost and accuracy of ours and of Exudyn on equal elements and steps."""

from __future__ import annotations

from typing import Any

import numpy as np
from pairs import Measured, Report, compare
from programs import Program
from spinup_problem import DURATION, EXTENSION, LARGEST_LAG, TIME_OF_LARGEST_LAG, spinup_problem

# Elements and step [s] of each comparison, and of the finest solution of each program.
CASES = ((4, 0.02), (8, 0.02), (8, 0.005), (16, 0.005))
FINEST = (32, 0.0025)


def compare_spinup(
    programs: tuple[Program, ...],
    rounds: int,
    report: Report,
    cases: tuple[tuple[int, float], ...] = CASES,
    finest: tuple[int, float] = FINEST,
) -> dict[str, Any]:
    """Pair ourselves with every peer on equal elements and steps.

    Parameters
    ----------
    programs
        Ourselves first.
    rounds
        Pairs per peer and case.
    report
        Receives one line per run.
    cases, finest
        Elements and step [s].

    Returns
    -------
    dict
        Rows per case and program; the published numbers; the finest solutions.
    """
    report(f"  finest: {finest[0]} elements, step {finest[1]:g} s")
    exact = {entry.name: entry for entry in compare(programs[0], programs[1:], spinup_problem(*finest), 1, report)}
    present = tuple(program for program in programs if program.name in exact)
    rows = []
    for elements, step in cases:
        report(f"  {elements} elements, step {step:g} s")
        problem = spinup_problem(elements, step)
        for entry in compare(present[0], present[1:], problem, rounds, report):
            rows.append({"elements": elements, "step": step, **_row(entry), "error": _error(entry, exact[entry.name])})
    reference = exact[programs[0].name]
    return {
        "published": {"lag": LARGEST_LAG, "time_of_lag": TIME_OF_LARGEST_LAG, "extension": EXTENSION},
        "finest": [
            {
                "elements": finest[0],
                "step": finest[1],
                **_row(entry),
                "difference_from_ours": _error(entry, reference),
            }
            for entry in exact.values()
        ],
        "rows": rows,
    }


def _row(entry: Measured) -> dict[str, Any]:
    result = entry.result
    lag, times = result["lag"], result["time"]
    return {
        "program": entry.name,
        "version": result["details"]["version"],
        "element": result["details"]["element"],
        "milliseconds_per_step": 1e3 * float(np.median(entry.seconds)) / (len(times) - 1),
        "ratio": entry.ratio,
        "ratios": entry.ratios,
        "largest_lag": float(lag.min()),
        "time_of_lag": float(times[lag.argmin()]),
        "extension": float(result["extension"][times > DURATION].mean()),
    }


def _error(entry: Measured, finest: Measured) -> float:
    """Largest difference of the lag from the finest solution, over the largest lag."""
    fine = finest.result
    there = np.interp(entry.result["time"], fine["time"], fine["lag"])
    return float(np.abs(entry.result["lag"] - there).max() / np.abs(fine["lag"]).max())
