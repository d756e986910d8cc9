"""What a person sees: short cards and tables on stdout."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from tautflex.case.sections.dynamic import Output


def say(text: str) -> None:
    """Print one plain line, broken at words on a terminal."""
    console = Console(highlight=False)
    console.print(Text(text), soft_wrap=not console.is_terminal)


def show_check(case: Path, answer: Mapping[str, Any]) -> None:
    """Print the summary of a valid case and its warnings."""
    rows = _rows()
    rows.add_row("nodes", f"{answer['nodes']}")
    rows.add_row("degrees of freedom", f"{answer['dofs']}, of which supports leave {answer['unknowns']} unknown")
    rows.add_row("mass", f"{answer['mass']:.4g} kg")
    _add_inertia(rows, answer)
    _add_prestress(rows, answer["prestress"])
    _card(f"{case.name} is valid", rows)
    for note in answer["notes"]:
        say(f"note: {note}")
    for warning in answer["warnings"]:
        say(f"warning: {warning}")


def show_modes(case: Path, answer: Mapping[str, Any]) -> None:
    """Print natural frequencies with half-wave labels and symmetry."""
    table = Table(title=f"{case.name}: natural frequencies", title_style="bold")
    for name in ("mode", "frequency [Hz]", "half waves (m,n)", "symmetry x,y"):
        table.add_column(name, justify="right")
    columns = zip(answer["frequencies"], answer["labels"], answer["symmetry"], strict=True)
    for number, (frequency, label, symmetry) in enumerate(columns, start=1):
        table.add_row(f"{number}", f"{frequency:.4f}", half_waves(label), symmetry)
    console = Console()
    console.print(table)
    rows = _rows()
    _add_prestress(rows, answer["prestress"])
    if "on_free_hub" in answer:
        rows.add_row("on its free hub", ", ".join(f"{value:.4f}" for value in answer["on_free_hub"]) + " Hz")
    console.print(rows)
    if free := answer.get("rigid_motions"):
        text = f"note: nothing holds the structure against {free} rigid motion(s): the lowest modes are these, at 0 Hz"
        say(f"{text} where the prestress balances")
    list_files(answer["files"])


def show_tuning(case: Path, answer: Mapping[str, Any]) -> None:
    """Print tuned tensions and the frequencies they give."""
    rows = _rows()
    rows.add_row("pretension_x", f"{answer['pretension_x']:.6g} N per cable")
    rows.add_row("pretension_y", f"{answer['pretension_y']:.6g} N per cable")
    rows.add_row("frequencies", ", ".join(f"{value:.4f}" for value in answer["frequencies"]) + " Hz")
    for number, error in zip(answer["modes"], answer["mesh_errors"], strict=True):
        if error is not None:
            rows.add_row(
                f"error of mode {number}", f"{error:+.2%} left by the mesh (quadratic triangles on its corners)"
            )
    _card(f"{case.name}, tuned", rows)
    for warning in answer["warnings"]:
        say(f"warning: {warning}")
    list_files(answer["files"])


def show_keys(entries: Sequence[Mapping[str, Any]]) -> None:
    """Print the keys of sections of a case file, the first sentence about each."""
    console = Console(highlight=False)
    for entry in entries:
        console.print(Text(entry["title"], style="bold"), Text(entry["about"], style="dim"))
        rows = Table.grid(padding=(0, 2))
        for key in entry["keys"]:
            kind = key["type"] + (f" [{key['unit']}]" if key["unit"] else "")
            meaning = key["meaning"].partition(". ")[0].rstrip(".") + "."
            rows.add_row(*map(Text, ("  " + key["name"], kind, key["default"], meaning)))
        console.print(rows, Text())


def show_run(case: Path, summary: Mapping[str, Any], output: Output) -> None:
    """Print the result card of a run, judged by the tolerances of the case, and where its files are."""
    rows = _rows()
    rows.add_row("status", f"{summary['status']}: {summary['message']}")
    steps = max(summary["steps"], 1)
    cost = f"{summary['back_substitutions'] / steps:.1f} back-substitutions a step"
    rows.add_row("steps", f"{summary['steps']} in {summary['seconds']:.1f} s, {cost}")
    rows.add_row("factorizations", f"{summary['factorizations']}")
    lowest = ", ".join(f"{value:.3f}" for value in summary["natural_frequencies"][:4])
    rows.add_row("natural frequencies", f"{lowest} ... Hz")
    for name, reading in summary["probes"].items():
        rows.add_row(f"probe {name}", _reading(reading))
    if summary["surface"]["rms"] is not None:
        rows.add_row("surface", _surface(summary["surface"], output.surface_tolerance))
        rows.add_row("tilt", f"{_pointing(summary['surface']['tilt'])} at the end")
    if summary["time_error"] is not None:
        rows.add_row("time error", f"about {summary['time_error']:.1g} of the largest displacement")
    if "settling_time" in summary:
        limits = {"attitude": f"{output.attitude_tolerance:.3g} rad", "surface": _micrometres(output.surface_tolerance)}
        told = {name: "not settled" if t is None else f"{t:.3g} s" for name, t in summary["settling_time"].items()}
        rows.add_row("settled after", ", ".join(f"{name} {text} (to {limits[name]})" for name, text in told.items()))
        work = summary["energy_by_source"].items()
        rows.add_row("work of", ", ".join(f"{name} {value:.3g} J" for name, value in work) or "no actuator")
    balance = summary["energy_balance"]
    taken = f"{balance['damping']:.3g} J by damping, {balance['method']:.2g} J by the method"
    rows.add_row("energy", f"{balance['kinetic'] + balance['strain']:.3g} J left, {taken}")
    _card(f"{case.name}: {summary['maneuver']}", rows)
    for warning in summary["warnings"]:
        say(f"warning: {warning}")
    list_files(summary["files"])


def show_authority(case: Path, answer: Mapping[str, Any]) -> None:
    """Print what each input at its limit does to each mode."""
    for name, words, scale in (("stiffness", "change of stiffness [%]", 100.0), ("force", "force [N/kg^1/2]", 1.0)):
        table = Table(title=f"{case.name}: {words} by each input at its limit", title_style="bold")
        for text in ("mode", "frequency [Hz]", *answer["inputs"]):
            table.add_column(text, justify="right")
        columns = [scale * one[name] for one in answer["inputs"].values()]
        for number, (frequency, *row) in enumerate(zip(answer["frequencies"], *columns, strict=True), start=1):
            table.add_row(f"{number}", f"{frequency:.4f}", *(f"{value:.3g}" for value in row))
        Console().print(table)
    for remark in answer["remarks"]:
        say(f"note: {remark}")


def show_training(case: Path, answer: Mapping[str, Any]) -> None:
    """Print what a training came to."""
    rows = _rows()
    rows.add_row("cost", f"{answer['cost']:.4g} on episodes kept apart, {answer['start_cost']:.4g} of the law alone")
    rows.add_row("iterations", f"{answer['iterations']}, {answer['skipped']} of them without a slope")
    rows.add_row("policy", answer["digest"])
    _card(f"{case.name}: trained", rows)
    list_files(answer["files"])


def show_evaluation(case: Path, answer: Mapping[str, Any]) -> None:
    """Print how laws did, best first."""
    table = Table(title=f"{case.name}: {answer['scenarios']} episodes", title_style="bold")
    columns = "law", "cost", "95 %", "worst", "gap", "settles [s]", "rms [µm]", "failed"
    for name in columns:
        table.add_column(name, justify="left" if name == "law" else "right")
    for name, one in sorted(answer["laws"].items(), key=lambda item: item[1]["cost"]):
        settles, rms, gap = one["settling_time"], one["surface_rms"], one["gap"]
        table.add_row(
            name,
            f"{one['cost']:.3f}",
            "{:.3f} to {:.3f}".format(*one["interval"]),
            f"{one['worst_cost']:.3f}",
            "-" if gap is None else f"{gap:+.3f}",
            "-" if settles is None else f"{settles:.2f}",
            "-" if rms is None else f"{rms * 1e6:.3g}",
            f"{one['failures']}",
        )
    Console().print(table)
    for failure in answer["failures"]:
        say(f"failed: {failure}")
    list_files(answer["files"])


def _reading(reading: Mapping[str, Any]) -> str:
    if reading["amplitude"] is None:
        return "too few samples"
    text = f"amplitude {reading['amplitude'] * 1e3:.4g} mm"
    if reading["dominant_frequency"] is None:
        return text
    half_bin = reading["bin_width"] / 2
    return f"{text}, then vibrates at {reading['dominant_frequency']:.3f} +- {half_bin:.3f} Hz"


def _micrometres(length: float) -> str:
    return f"{1e6 * length:.3g} µm"


def _surface(measures: Mapping[str, Any], tolerance: float) -> str:
    text = f"rms {_micrometres(measures['rms'])} at the end"
    if measures["rms_max"] is None:
        return f"{text}, before the maneuver's end"
    settled = measures["settling_time"]
    text = f"{text}, up to {_micrometres(measures['rms_max'])} after the maneuver"
    limit = f"to {_micrometres(tolerance)}"
    return f"{text}, {f'not settled {limit}' if settled is None else f'settled {limit} after {settled:.3g} s'}"


def _pointing(tilt: Sequence[float]) -> str:
    # Smaller angles are rounding errors of the nodes' places.
    angles = [round(1e6 * angle, 6) + 0.0 for angle in tilt]
    return " and ".join(f"{angle:.3g} µrad about {axis}" for axis, angle in zip("xy", angles, strict=True))


def half_waves(label: Sequence[int] | None) -> str:
    """Write the numbers of half waves along x and y."""
    return "-" if label is None else f"({label[0]},{label[1]})"


def _rows() -> Table:
    rows = Table.grid(padding=(0, 2))
    rows.add_column(style="dim", no_wrap=True)
    rows.add_column(overflow="fold")
    return rows


def _add_inertia(rows: Table, answer: Mapping[str, Any]) -> None:
    """Centre of mass and inertia about it, without what rounding leaves; products of inertia where there are some."""
    tensor = answer["inertia"]
    most = max(tensor[k][k] for k in range(3))
    reach = math.sqrt(most / answer["mass"]) if answer["mass"] else 0.0
    place = ", ".join(f"{value if abs(value) > 1e-9 * reach else 0.0:.4g}" for value in answer["mass_center"])
    rows.add_row("centre of mass", f"({place}) m")
    pairs = {f"{a}{b}": tensor["xyz".index(a)]["xyz".index(b)] for a, b in ("xx", "yy", "zz", "xy", "xz", "yz")}
    found = [f"{name} {value:.4g}" for name, value in pairs.items() if name[0] == name[1] or abs(value) > 1e-9 * most]
    rows.add_row("inertia about it", f"{', '.join(found)} kg m²")


def _add_prestress(rows: Table, prestress: Mapping[str, Any]) -> None:
    rows.add_row("prestress residual", f"{prestress['residual']:.3g} N")
    if math.isfinite(least := prestress["min_principal_resultant"]):
        rows.add_row("least film tension", f"{least:.4g} N/m")


def _card(title: str, rows: Table) -> None:
    Console().print(Panel(rows, title=title, title_align="left", expand=False))


def list_files(files: Mapping[str, str | Path]) -> None:
    """Print one line per directory, its files behind it, or how many they are."""
    names: dict[Path, list[str]] = {}
    for path in map(Path, files.values()):
        names.setdefault(path.parent, []).append(path.name)
    for directory, found in names.items():
        listed = ", ".join(found) if len(found) <= 8 else f"{len(found)} files"
        say(f"Wrote {listed}." if directory == Path() else f"Wrote to {directory}{os.sep}: {listed}")
