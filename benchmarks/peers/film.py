"""The film: cost per step and accuracy of every program on one mesh, and cost per step against size."""

from __future__ import annotations

from typing import Any

import numpy as np
from film_problem import BLOW, film_problem
from pairs import Report, compare, run_once
from programs import Program, ProgramFailedError

STEP = 1e-3
TOLERANCE = 1e-5
# Mesh -> steps of the size study.
SIZES = {(10, 5): 1000, (20, 10): 500, (40, 20): 200, (80, 40): 60, (160, 80): 20, (320, 160): 8}
# Runs of the size study up to this many unknowns; short runs are disturbed easily, and the fastest counts.
REPEATED, REPEATS = 3000, 3
# Steps of the size study that are not counted: the first one orders and allocates.
FIRST = 2


def error(record: np.ndarray, reference: np.ndarray) -> float:
    """Largest difference of two records over the largest displacement, shapes (sample, 3)."""
    return float(np.abs(record - reference).max() / np.abs(reference).max())


def compare_film(
    programs: tuple[Program, ...],
    divisions: tuple[int, int],
    count: int,
    rounds: int,
    report: Report,
    element: str = "triangle3",
    speeds: tuple[float, float] = BLOW,
) -> dict[str, Any]:
    """Pair ourselves with every peer on one mesh.

    Parameters
    ----------
    programs
        Ourselves first.
    divisions
        Cells along x and y.
    count
        Number of steps.
    rounds
        Pairs per peer.
    report
        Receives one line per run.
    element
        ``"triangle3"`` or ``"triangle6"``.
    speeds
        Of the blow [m/s], see `film_problem`.

    Returns
    -------
    dict
        The problem and one row per program: milliseconds of processor time per step, ratios to ours in the same pair,
        iterations and factorizations per step, error against our converged record and difference from ours.
    """
    problem = film_problem(divisions, STEP, count, TOLERANCE, element, speeds)
    report("  converged record, for the errors")
    reference = run_once(programs[0], {**problem, "tolerance": np.array(1e-11)})["displacement"]
    measured = compare(programs[0], programs[1:], problem, rounds, report)
    ours = measured[0].result["displacement"]
    rows = []
    for entry in measured:
        details = entry.result["details"]
        rows.append(
            {
                "program": entry.name,
                "version": details["version"],
                "solver": details["solver"],
                "milliseconds_per_step": 1e3 * float(np.median(entry.seconds)) / count,
                "ratio": entry.ratio,
                "ratios": entry.ratios,
                "iterations_per_step": details["iterations"] / count,
                "factorizations_per_step": details["factorizations"] / count,
                "set_up_seconds": float(entry.result["set_up_seconds"]),
                "error": error(entry.result["displacement"], reference),
                "difference_from_ours": error(entry.result["displacement"], ours),
            }
        )
    return {
        "divisions": list(divisions),
        "element": element,
        "speed": speeds[0],
        "unknowns": 3 * (len(problem["nodes"]) - len(problem["fixed"])),
        "step": STEP,
        "count": count,
        "tolerance": TOLERANCE,
        "largest_deflection": float(np.abs(reference[:, 2]).max()),
        "first_linear_frequency": _linear_frequency(problem),
        "mean_frequency": _mean_frequency(reference[:, 2]),
        "rows": rows,
    }


def _linear_frequency(problem: dict[str, np.ndarray]) -> float:
    """First frequency of the film under its initial stress alone [Hz]: sqrt(sx/a^2 + sy/b^2)/2 sqrt(1/rho)."""
    length, width, _ = np.ptp(problem["nodes"], axis=0)
    stress = problem["stress"]
    return float(0.5 * np.sqrt((stress[0] / length**2 + stress[1] / width**2) / problem["density"]))


def _mean_frequency(deflection: np.ndarray) -> float:
    """Half the zero crossings per second [Hz]."""
    return float(0.5 * np.count_nonzero(np.diff(np.sign(deflection[1:]))) / (STEP * (len(deflection) - 1)))


def size_study(
    programs: tuple[Program, ...], sizes: dict[tuple[int, int], int], timeout: float, report: Report
) -> dict[str, Any]:
    """Cost per step against size.

    Parameters
    ----------
    programs
        What to run.
    sizes
        Mesh -> number of steps.
    timeout
        Allowed seconds of a run; a program that takes longer is left out of the larger meshes.
    report
        Receives one line per run.

    Returns
    -------
    dict
        ``rows``: program, mesh, unknowns and milliseconds of processor time per step, mean of the steps after the first
        two, least of the runs.
    """
    rows: list[dict[str, Any]] = []
    failed: set[str] = set()
    for divisions, count in sizes.items():
        problem = film_problem(divisions, STEP, count, TOLERANCE)
        unknowns = 3 * (len(problem["nodes"]) - len(problem["fixed"]))
        for program in programs:
            if program.name in failed:
                continue
            try:
                runs = range(REPEATS if unknowns <= REPEATED else 1)
                cost = min(_cost(run_once(program, problem, timeout)["clock"]) for _ in runs)
            except ProgramFailedError as failure:
                report(f"  {failure}; left out of larger meshes")
                failed.add(program.name)
                continue
            report(f"  {divisions[0]}x{divisions[1]}, {program.name}: {cost:.3g} ms per step")
            rows.append(
                {
                    "program": program.name,
                    "divisions": list(divisions),
                    "unknowns": unknowns,
                    "steps": count,
                    "milliseconds_per_step": cost,
                }
            )
    return {"rows": rows}


def _cost(clock: np.ndarray) -> float:
    """Milliseconds per step after the first ones."""
    number, seconds = clock[clock[:, 0] >= FIRST][[0, -1]].T
    return 1e3 * float((seconds[1] - seconds[0]) / (number[1] - number[0]))
