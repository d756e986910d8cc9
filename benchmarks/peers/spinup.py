"""Beams on hubs: cost and accuracy of ours and of Exudyn on equal elements and steps, and cost at equal error."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
from pairs import Measured, Report, compare
from programs import Program, ProgramFailedError

# Elements and steps [s] that are compared, and those of the finest solution of each program.
ELEMENTS, STEPS = (4, 8, 16, 32, 64), (0.02, 0.005)
FINEST = (128, 0.00125)
# Larger and further steps [s] that ours may take where an error is to be reached.
OTHER_STEPS = (0.1, 0.05, 0.01)

Build = Callable[[int, float], dict[str, np.ndarray]]


def compare_beams(
    programs: tuple[Program, ...],
    build: Build,
    rounds: int,
    report: Report,
    elements: tuple[int, ...] = ELEMENTS,
    steps: tuple[float, ...] = STEPS,
    finest: tuple[int, float] = FINEST,
) -> dict[str, Any]:
    """Pair ourselves with every peer on equal elements and steps, then where ours has the peer's error.

    Parameters
    ----------
    programs
        Ourselves first.
    build
        Problem of a number of elements and a step [s].
    rounds
        Pairs per peer and case.
    report
        Receives one line per run.
    elements, steps, finest
        Numbers of elements, steps [s], and both of the finest solution.

    Returns
    -------
    dict
        ``rows`` per case and program, ``finest`` per program, and ``equal``: what ours takes where its error is at most
        that of each row of a peer.

    Notes
    -----
    The error is the largest difference of the tip's lag from the same program's finest solution, over the largest lag.
    """
    report(f"  finest: {finest[0]} elements, step {finest[1]:g} s")
    exact = {entry.name: entry for entry in compare(programs[0], programs[1:], build(*finest), 1, report)}
    ours, *peers = (program for program in programs if program.name in exact)
    # Our other beam shows in the finest solutions only.
    peers = [peer for peer in peers if peer.script != ours.script]
    rows = []
    for case in product(elements, steps):
        report(f"  {case[0]} elements, step {case[1]:g} s")
        rows += [_row(case, entry, exact) for entry in compare(ours, tuple(peers), build(*case), rounds, report)]
    choice = [row for row in rows if row["program"] == ours.name]
    for case in product(elements, OTHER_STEPS):
        try:
            choice += [_row(case, entry, exact) for entry in compare(ours, (), build(*case), 1, report)]
        except ProgramFailedError as failure:  # a step that no iteration converges at
            report(f"  {failure}")
    equal = []
    for row in rows:
        for peer in peers:
            if peer.name == row["program"]:
                equal.append(_at_equal_error(ours, peer, row, choice, build, rounds, report))
    return {
        "finest": [_row(finest, entry, exact, against=ours.name) for entry in exact.values()],
        "rows": rows,
        "equal": equal,
    }


def _at_equal_error(
    ours: Program,
    peer: Program,
    row: dict[str, Any],
    choice: list[dict[str, Any]],
    build: Build,
    rounds: int,
    report: Report,
) -> dict[str, Any]:
    """Pairs of a peer's case with the cheapest of ours that is as accurate; without one, the peer's alone."""
    fit = [other for other in choice if other["error"] <= row["error"]]
    theirs = {name: row[name] for name in ("program", "elements", "step", "error", "seconds")}
    if not fit:
        return {"theirs": theirs, "ours": None, "ratio": None, "ratios": []}
    best = min(fit, key=lambda other: float(other["seconds"]))
    report(f"  {row['program']}, {row['elements']} elements, step {row['step']:g} s, at its error {row['error']:.2g}")
    problem, other = build(best["elements"], best["step"]), build(row["elements"], row["step"])
    mine, entry = compare(ours, (peer,), problem, rounds, report, peers_problem=other)
    return {
        "theirs": theirs | {"seconds": float(np.median(entry.seconds))},
        "ours": {name: best[name] for name in ("elements", "step", "error")}
        | {"seconds": float(np.median(mine.seconds))},
        "ratio": entry.ratio,
        "ratios": entry.ratios,
    }


def _row(
    case: tuple[int, float], entry: Measured, exact: dict[str, Measured], against: str | None = None
) -> dict[str, Any]:
    """Numbers of one program in one case; its error is against another program's finest solution if that is named."""
    result = entry.result
    lag, times = result["lag"], result["time"]
    fine = exact[against or entry.name].result
    there = np.interp(times, fine["time"], fine["lag"])
    seconds = float(np.median(entry.seconds))
    row = {
        "elements": case[0],
        "step": case[1],
        "program": entry.name,
        "version": result["details"]["version"],
        "element": result["details"]["element"],
        "seconds": seconds,
        "milliseconds_per_step": 1e3 * seconds / (len(times) - 1),
        "ratio": entry.ratio,
        "ratios": entry.ratios,
        "largest_lag": float(lag.min()),
        "time_of_lag": float(times[lag.argmin()]),
        "extension": float(result["extension"][times > 0.75 * times[-1]].mean()),
        "error": float(np.abs(lag - there).max() / np.abs(fine["lag"]).max()),
    }
    return row | ({"angle": float(result["angle"][-1])} if "angle" in result else {})
