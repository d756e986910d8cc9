"""Numbers of a run in words for a page."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import xarray as xr

from tautflex.analysis.record import counted_from
from tautflex.case.run import read_probe, read_surface
from tautflex.solvers.modal.natural import Modes

# A number with more digits than anyone reads.
_LONG = re.compile(r"\d+\.\d{5,}(?:e[+-]?\d+)?")


def numbers_of(run: xr.Dataset, modes: Modes | None) -> list[tuple[str, str]]:
    """Name and value of what a run found, a row each."""
    found, attributes, end = list[tuple[str, str]](), run.attrs, counted_from(run)
    found.append(("Status", attributes.get("status_message", "")))
    found.append(("Maneuver", str(attributes.get("maneuver", ""))))
    for name in run["probe"].values if run.sizes.get("probe", 0) else ():
        read = read_probe(run["w"].sel(probe=name), end)
        size, frequency, width = (read[key] for key in ("amplitude", "dominant_frequency", "bin_width"))
        words = [] if size is None else [f"largest |w| {1e3 * size:.4g} mm"]
        if frequency is not None and width is not None:
            words.append(f"then {frequency:.4g} ± {0.5 * width:.2g} Hz")
        found.append((f"Probe {name}", ", ".join(words)))
    found += _surface(run, end, float(attributes.get("surface_tolerance", 2e-5)))
    if modes is not None:
        found.append(("Natural frequencies at rest", ", ".join(f"{f:.4g}" for f in modes.frequencies) + " Hz"))
    error = attributes.get("time_error")
    if error is not None and math.isfinite(error):
        found.append(("Time error", f"about {error:.2g} of the largest displacement"))
    found += _energy(attributes.get("energy_balance"))
    found += [(name, str(attributes[key])) for name, key in (("Method", "method"), ("Damping", "damping"))]
    time = run["time"].values
    if time.size:
        found.append(("Record", f"{time.size} instants from {time[0]:g} to {time[-1]:g} s"))
    counts = {"nodes": "node", "triangles": "triangle", "cables": "cable", "beams": "beam"}
    found.append(("Mesh", ", ".join(f"{len(run[key])} {word}" for word, key in _sizes(run, counts))))
    found += _work(attributes.get("statistics"))
    if "reduced_model" in attributes:
        found.append(("Reduced model", " ".join(str(attributes["reduced_model"]).split())))
    return [(name, _LONG.sub(lambda number: f"{float(number[0]):.5g}", words)) for name, words in found if words]


def _sizes(run: xr.Dataset, counts: dict[str, str]) -> list[tuple[str, str]]:
    keys = {word: "node_position" if key == "node" else key for word, key in counts.items()}
    return [(word, key) for word, key in keys.items() if key in run and len(run[key])]


def _surface(run: xr.Dataset, end: float | None, tolerance: float) -> list[tuple[str, str]]:
    """How far the film stands off its best plane, of a run without a maneuver from its start."""
    film = read_surface(run, end, tolerance)
    if film["rms"] is None:
        return []
    words = [f"{1e3 * film['rms']:.4g} mm at the end"]
    if film["rms_max"] is not None:
        settled, limit = film["settling_time"], f"{1e3 * tolerance:.3g} mm"
        words.append(f"up to {1e3 * film['rms_max']:.4g} mm" + (" after the maneuver" if end else ""))
        if run.attrs.get("status", "completed") == "completed":
            since = (
                f" from {settled:.4g} s {'after it' if end else 'on'}"
                if settled
                else " from its end on"
                if end
                else " throughout"
            )
            words.append(f"not settled to {limit}" if settled is None else f"within {limit}{since}")
    return [("Surface, rms", ", ".join(words))]


def _energy(given: Any) -> list[tuple[str, str]]:
    balance = json.loads(given) if isinstance(given, str) else given
    if not balance:
        return []
    kinetic, strain, lost, rest = (balance[name] for name in ("kinetic", "strain", "damping", "residual"))
    stored = f"at the end {kinetic:.3g} J kinetic in space and {strain:.3g} J of strain"
    return [("Energy", f"{stored}; {lost:.3g} J lost by damping, {rest:.2g} J unaccounted for")]


def _work(given: Any) -> list[tuple[str, str]]:
    numbers = json.loads(given) if isinstance(given, str) else given
    if not numbers:
        return []
    return [("Work", f"{numbers['steps']} steps in {numbers['seconds']:.3g} s")]
