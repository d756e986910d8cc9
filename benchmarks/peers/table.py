"""Results as a Markdown page: every number beside the program, version and machine that gave it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

# What was asked for: times faster per step than each peer, at equal answers.
TARGETS = {"DOLFINx, Newton": 10.0, "DOLFINx, factors kept": 10.0, "Kratos": 50.0}
EQUAL = 1e-5


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Markdown table of texts and numbers.

    Parameters
    ----------
    header
        Column titles.
    rows
        Cells; numbers are written with three digits, None as a dash.

    Returns
    -------
    str
        Lines that end with a newline.
    """
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(_text(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def _text(cell: Any) -> str:
    if cell is None:
        return "-"
    return f"{cell:.3g}" if isinstance(cell, float) else str(cell)


def _range(row: dict[str, Any]) -> str:
    """Median ratio and the range of the pairs."""
    if not row["ratios"]:
        return "1"
    return f"**{row['ratio']:.3g}** ({min(row['ratios']):.3g} to {max(row['ratios']):.3g})"


def page(results: dict[str, Any]) -> str:
    """The page of a run.

    Parameters
    ----------
    results
        What `run.py` wrote as JSON.

    Returns
    -------
    str
        Markdown.
    """
    machine = results["machine"]
    parts = [
        "# Beside other codes\n",
        f"Measured on {machine['processor']}, {machine['cores']} cores, "
        f"{machine['system']}, Python {machine['python']}. Every program runs on one core; times are processor times "
        "of the time stepping alone. Ratios come from pairs of runs right after each other whose order alternates: "
        "peer over ours, median (smallest to largest). Numbers of this page: `benchmarks.json`.\n",
    ]
    if results.get("missing"):
        parts.append("Not compared:\n\n" + "".join(f"- {reason}\n" for reason in results["missing"]))
    for name, part in _PARTS.items():
        if name in results:
            parts.append(part(results[name]))
            parts.append(f"Measured on {results[name]['date']} by `{results[name]['command']}`.\n")
    return "\n".join(parts)


def film_part(film: dict[str, Any]) -> str:
    """Section of the fixed-edge film."""
    text = (
        f"## Fixed-edge film, {film['divisions'][0]} x {film['divisions'][1]} cells\n\n"
        f"Film of the paper (2 m x 1 m, Green-Lagrange strain, initial stress 1e4 Pa), struck: {film['count']} steps "
        f"of {1e3 * film['step']:g} ms by the trapezoidal rule, {film['unknowns']} unknowns, the same triangles, "
        f"consistent mass. The probe moves by {1e3 * film['largest_deflection']:.2g} mm and swings at "
        f"{film['mean_frequency']:.2g} Hz; under its initial stress alone it would at "
        f"{film['first_linear_frequency']:.2g} Hz. Iterations stop at a residual of {film['tolerance']:g} of the "
        "internal forces (Kratos, which does not measure that: at a correction of 1e-4 of the displacement). Error: "
        "largest difference of the probe's record from the converged one, over its largest displacement.\n\n"
    )
    header = ("program", "version", "ms per step", "times ours", "iterations", "factorizations", "error", "from ours")
    text += markdown_table(
        header,
        (
            (
                row["program"],
                row["version"],
                row["milliseconds_per_step"],
                _range(row),
                row["iterations_per_step"],
                row["factorizations_per_step"],
                row["error"],
                row["difference_from_ours"],
            )
            for row in film["rows"]
        ),
    )
    text += "\n" + "".join(f"- {row['program']}: {row['solver']}\n" for row in film["rows"])
    return text + "\n" + "".join(_verdict(row) for row in film["rows"] if row["program"] in TARGETS)


def _verdict(row: dict[str, Any]) -> str:
    target = TARGETS[row["program"]]
    speed = "reached" if row["ratio"] >= target else "missed"
    equal = "equal" if row["error"] <= EQUAL and row["difference_from_ours"] <= EQUAL else "NOT equal"
    return (
        f"- Target {target:g} times against {row['program']}: {speed} ({row['ratio']:.3g}), answers {equal} to 1e-5.\n"
    )


def spinup_part(spin: dict[str, Any]) -> str:
    """Section of the spin-up."""
    published = spin["published"]
    text = (
        "## Spin-up of a cantilever\n\n"
        "Kane's beam (10 m, EA 2.8e7 N, EI 1.4e4 N m2, 1.2 kg/m) spun up to 6 rad/s in 15 s, 20 s in all, "
        "generalized-alpha with spectral radius 0.8. Published: the tip lags by "
        f"{-published['lag']:g} m near {published['time_of_lag']:g} s and stays stretched by "
        f"{1e3 * published['extension']:.4g} mm. Ours is a beam of small rotations in the hub's frame, which converges "
        "to a limit of its own, off by the square of the rotation; our corotational one and Exudyn's, in absolute "
        "coordinates, take any rotation. Error: largest difference of the lag from the same program's finest solution, "
        "over the largest lag.\n\n"
    )
    header = ("elements", "step [s]", "program", "ms per step", "times ours", "lag [m]", "at [s]", "extension [mm]")

    def cells(row: dict[str, Any]) -> tuple[Any, ...]:
        return (
            row["elements"],
            row["step"],
            f"{row['program']} {row['version']}",
            row["milliseconds_per_step"],
            _range(row),
            f"{row['largest_lag']:.4f}",
            f"{row['time_of_lag']:.2f}",
            f"{1e3 * row['extension']:.4f}",
        )

    text += markdown_table((*header, "error"), ((*cells(row), row["error"]) for row in spin["rows"]))
    text += "\nFinest solutions:\n\n"
    return text + markdown_table(
        (*header, "from ours"), ((*cells(row), row["difference_from_ours"]) for row in spin["finest"])
    )


def size_part(size: dict[str, Any]) -> str:
    """Section of cost against size."""
    rows = size["rows"]
    programs = list(dict.fromkeys(row["program"] for row in rows))
    cost = {(row["program"], tuple(row["divisions"])): row["milliseconds_per_step"] for row in rows}
    unknowns = {tuple(row["divisions"]): row["unknowns"] for row in rows}
    text = (
        "## Cost of a step against size\n\nThe same film on finer meshes, milliseconds of processor time per step over "
        "the first few steps; first ordering and allocation are not counted. Up to 40 x 20: "
        "the fastest of three runs.\n\n"
    )
    header = ("mesh", "unknowns", *programs, *(f"{name}: times ours" for name in programs[1:]))
    table = []
    for mesh, count in unknowns.items():
        times = [cost.get((name, mesh)) for name in programs]
        ratios = [time / times[0] if time and times[0] else None for time in times[1:]]
        table.append((f"{mesh[0]} x {mesh[1]}", count, *times, *ratios))
    return text + markdown_table(header, table) + "\n![Cost of a step against size](figures/cost_against_size.png)\n"


_PARTS = {"film": film_part, "spinup": spinup_part, "size": size_part}
