"""Results as a Markdown page: every number beside the program, version and machine that gave it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from film_problem import BLOW, GENTLE
from spinup_problem import EXTENSION, LARGEST_LAG, TIME_OF_LARGEST_LAG

# What was asked for: times faster per step than each peer, at equal answers, by the speed of the blow.
TARGETS = {BLOW[0]: {"DOLFINx, Newton": 19.0, "DOLFINx, factors kept": 7.0, "Kratos": 50.0}}
TARGETS |= {GENTLE[0]: {"DOLFINx, Newton": 25.0}}
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
    parts = [
        "# Beside other codes\n",
        "Every program runs on one core; times are processor times of the time stepping alone. Ratios come from pairs "
        "of runs right after each other whose order alternates: peer over ours, median (smallest to largest). Numbers "
        "of this page: `benchmarks.json`.\n",
    ]
    if results.get("missing"):
        parts.append("Not compared:\n\n" + "".join(f"- {reason}\n" for reason in results["missing"]))
    for name, part in _PARTS.items():
        if name in results:
            parts.append(part(results[name]))
            parts.append(_when(results[name]))
    return "\n".join(parts)


def _when(part: dict[str, Any]) -> str:
    """When, on what and by which command a part was measured."""
    machine = part["machine"]
    return (
        f"Measured on {part['date']} by `{part['command']}` on {machine['processor']}, {machine['cores']} cores, "
        f"{machine['system']}, Python {machine['python']}.\n"
    )


def film_part(film: dict[str, Any]) -> str:
    """Section of the fixed-edge film."""
    quadratic = film["element"] == "triangle6"
    # It does not measure residuals so.
    kratos = " (Kratos: at a correction of 1e-4 of the displacement)" if not quadratic else ""
    blow = ", struck gently" if film["speed"] == GENTLE[0] else ""
    kind, rule = (" of quadratic triangles", "strains at three points, ") if quadratic else ("", "")
    text = (
        f"## Fixed-edge film, {film['divisions'][0]} x {film['divisions'][1]} cells{kind}{blow}\n\n"
        "Film of the paper (2 m x 1 m, Green-Lagrange strain, initial stress 1e4 Pa), struck with "
        f"{film['speed']:g} m/s in its middle: {film['count']} steps of {1e3 * film['step']:g} ms by the "
        f"trapezoidal rule, {film['unknowns']} unknowns, the same triangles, "
        f"{rule}consistent mass. The probe moves by {1e3 * film['largest_deflection']:.2g} mm and swings at "
        f"{film['mean_frequency']:.2g} Hz; under its initial stress alone it would at "
        f"{film['first_linear_frequency']:.2g} Hz. Iterations stop at a residual of {film['tolerance']:g} of the "
        f"internal forces{kratos}. Error: "
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
    asked = {} if quadratic else TARGETS[film["speed"]]
    return (
        text + "\n" + "".join(_verdict(row, asked[row["program"]]) for row in film["rows"] if row["program"] in asked)
    )


def _verdict(row: dict[str, Any], target: float) -> str:
    speed = "reached" if row["ratio"] >= target else "missed"
    equal = "equal" if row["error"] <= EQUAL and row["difference_from_ours"] <= EQUAL else "NOT equal"
    return (
        f"- Target {target:g} times against {row['program']}: {speed} ({row['ratio']:.3g}), answers {equal} to 1e-5.\n"
    )


def spinup_part(spin: dict[str, Any]) -> str:
    """Section of the spin-up."""
    return (
        "## Spin-up of a cantilever\n\n"
        "Kane's beam (10 m, EA 2.8e7 N, EI 1.4e4 N m2, 1.2 kg/m) spun up to 6 rad/s in 15 s, 20 s in all, "
        "generalized-alpha with spectral radius 0.8. Published: the tip lags by "
        f"{-LARGEST_LAG:g} m near {TIME_OF_LARGEST_LAG:g} s and stays stretched by {1e3 * EXTENSION:.4g} mm. Our "
        "corotational beam and Exudyn's, in absolute coordinates, take any rotation; our von Karman one takes small "
        "ones in the hub's frame and converges to a limit of its own, off by the square of the rotation. "
    ) + _beams(spin, "extension [mm]", lambda row: f"{1e3 * row['extension']:.4f}")


def hub_part(hub: dict[str, Any]) -> str:
    """Section of the free hub."""
    return (
        "## The same cantilever on a free hub\n\n"
        "The hub, of half the beam's moment of inertia about the axis, is free to turn about it; a torque of one "
        "versine of 5 s brings both to a mean of 3 rad/s, 15 s in all. Corotational beam and Exudyn's. "
    ) + _beams(hub, "angle at the end [rad]", lambda row: f"{row['angle']:.5f}")


def _beams(part: dict[str, Any], last: str, value: Callable[[dict[str, Any]], str]) -> str:
    """Tables of beams; ``last`` and its text of a row are what is compared beside the lag."""
    header = ["elements", "step [s]", "program", "s in all", "ms per step", "times ours", "lag [m]", "at [s]", last]

    def table(rows: list[dict[str, Any]], error: str) -> str:
        return markdown_table(
            (*header, error),
            (
                (
                    row["elements"],
                    row["step"],
                    f"{row['program']} {row['version']}",
                    row["seconds"],
                    row["milliseconds_per_step"],
                    _range(row),
                    f"{row['largest_lag']:.4f}",
                    f"{row['time_of_lag']:.2f}",
                    value(row),
                    row["error"],
                )
                for row in rows
            ),
        )

    text = (
        "Error: largest difference of the lag from the same program's finest solution, over the largest lag. "
        "Times of runs below a second are the median of three in one process.\n\n"
        + table(part["rows"], "error")
        + "\nFinest solutions:\n\n"
        + table(part["finest"], "from ours")
        + "\nAt equal error: the cheapest of our elements and steps whose error is at most the peer's.\n\n"
    )
    return text + markdown_table(
        ("peer", "elements", "step [s]", "error", "s", "our elements", "step [s]", "error", "s", "times ours"),
        (
            (
                *(row["theirs"][name] for name in ("program", "elements", "step", "error", "seconds")),
                *((row["ours"] or {}).get(name) for name in ("elements", "step", "error", "seconds")),
                _range(row) if row["ours"] else None,
            )
            for row in part["equal"]
        ),
    )


def size_part(size: dict[str, Any]) -> str:
    """Section of cost against size."""
    rows = size["rows"]
    programs = list(dict.fromkeys(row["program"] for row in rows))
    cost = {(row["program"], tuple(row["divisions"])): row["milliseconds_per_step"] for row in rows}
    unknowns = {tuple(row["divisions"]): (row["unknowns"], row["steps"]) for row in rows}
    text = (
        "## Cost of a step against size\n\nThe same film on finer meshes, milliseconds of processor time per step over "
        "the first steps; first ordering and allocation are not counted. Up to 40 x 20: the fastest of three runs.\n\n"
    )
    header = ("mesh", "unknowns", "steps", *programs, *(f"{name}: times ours" for name in programs[1:]))
    table = []
    for mesh, counts in unknowns.items():
        times = [cost.get((name, mesh)) for name in programs]
        ratios = [time / times[0] if time and times[0] else None for time in times[1:]]
        table.append((f"{mesh[0]} x {mesh[1]}", *counts, *times, *ratios))
    return text + markdown_table(header, table) + "\n![Cost of a step against size](figures/cost_against_size.png)\n"


def accuracy_part(accuracy: dict[str, Any]) -> str:
    """Section of error against time."""
    text = (
        "## Error against time\n\n"
        f"The film of the first section over {accuracy['end']:g} s, by any mesh, element, method and step. Error: of "
        "the probe's deflection in the mean square, over that of the record, against our quadratic triangles on "
        f"{_mesh(accuracy['reference'])} cells with steps of {1e3 * accuracy['reference']['step']:g} ms"
        f"{_doubt(accuracy)}. One run each; settings that would take more than {accuracy['beyond']:g} times as long as "
        f"the first of a program within {100 * accuracy['target']:g} % were not tried. "
        f"{_STATIC if accuracy.get('other') else ''}What no other setting of the program betters in both error and "
        "time:\n\n"
    )
    header = ("program", "element", "cells", "method", "step [ms] or tolerance", "s", "error [%]")
    rows = [row for row in accuracy["rows"] if row["best"]]
    text += markdown_table(
        header,
        (
            (row["program"], row["element"], _mesh(row), row["method"], _size(row), row["seconds"], 100 * row["error"])
            for row in sorted(rows, key=lambda row: (row["program"], row["seconds"]))
        ),
    )
    for pair in accuracy["pairs"]:
        text += (
            f"\nWithin {100 * pair['target']:g} %, pairs in alternation: {pair.get('program', 'tautflex')}, "
            f"{pair['ours']}; DOLFINx {pair['theirs']}: {_range(pair)} times ours.\n"
        )
    return text + "\n![Error against time](figures/accuracy_for_time.png)\n"


_STATIC = (
    '"Static in the plane" is `CondensedDifference`: explicit across, without inertia of the film in its plane; '
    "the other rows of ours solve the whole equation of motion, as DOLFINx's do. "
)


def _doubt(accuracy: dict[str, Any]) -> str:
    """How far the finest solutions of ours are apart."""
    finest, other = accuracy["next_finest"], accuracy.get("other")
    text = f" (the next finest, {_mesh(finest)} with {1e3 * finest['step']:g} ms, is {100 * finest['error']:.2g} % off"
    return text + (f", the same mesh by {other['method']} {100 * other['error']:.2g} %)" if other else ")")


def _mesh(row: dict[str, Any]) -> str:
    return f"{row['divisions'][0]} x {row['divisions'][1]}"


def _size(row: dict[str, Any]) -> str:
    return f"{row['adaptive']:g}" if row["adaptive"] else f"{1e3 * row['step']:g}"


_PARTS = {
    "film": film_part,
    "film_gentle": film_part,
    "film_quadratic": film_part,
    "spinup": spinup_part,
    "hub": hub_part,
    "size": size_part,
    "accuracy": accuracy_part,
}
