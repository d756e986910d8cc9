"""Numbers of a run in words for a page."""

from __future__ import annotations

import ast
import dataclasses
import json
import math
import re
from typing import Any

import xarray as xr

from tautflex.analysis.record import counted_from
from tautflex.case.help import docstrings
from tautflex.case.registry import DAMPINGS, MANEUVERS
from tautflex.case.run import read_probe, read_surface
from tautflex.motion.hub import FreeHub
from tautflex.solvers.modal.natural import Modes

# A number with more digits than anyone reads.
_LONG = re.compile(r"\d+\.\d{5,}(?:e[+-]?\d+)?")


def numbers_of(run: xr.Dataset, modes: Modes | None) -> list[tuple[str, str]]:
    """Name and value of what a run found, a row each."""
    found, attributes, end = list[tuple[str, str]](), run.attrs, counted_from(run)
    found.append(("Status", attributes.get("status_message", "")))
    found.append(("Maneuver", in_words(str(attributes.get("maneuver", "")))))
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
    found += [("Method", str(attributes["method"])), ("Damping", in_words(str(attributes["damping"])))]
    time = run["time"].values
    if time.size:
        found.append(("Record", f"{time.size} instants from {time[0]:g} to {time[-1]:g} s"))
    counts = {"nodes": "node", "triangles": "triangle", "cables": "cable", "beams": "beam"}
    found.append(("Mesh", ", ".join(f"{len(run[key])} {word}" for word, key in _sizes(run, counts))))
    found += _work(attributes.get("statistics"))
    if "reduced_model" in attributes:
        found.append(("Reduced model", " ".join(str(attributes["reduced_model"]).split())))
    return [(name, _LONG.sub(lambda number: f"{float(number[0]):.5g}", words)) for name, words in found if words]


def in_words(text: str) -> str:
    """What a stored run says of its maneuver, hub or damping, as Python writes it, in words with units.

    Text that Python cannot read, as of tables of numbers, keeps its words.
    """
    functions = re.compile(r"<(?:[^<>]|<[^<>]*>)*>")  # as Python writes what it cannot read again
    try:
        call = ast.parse(functions.sub("'a function'", text), mode="eval").body
    except SyntaxError:
        name, _, inside = text.partition("(")
        return f"{_plain(name)}: {inside.partition(', axis=')[0].rstrip(')')}" if inside else text
    return _call_in_words(call) if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) else text


def _call_in_words(call: ast.Call) -> str:
    assert isinstance(call.func, ast.Name)
    name = call.func.id
    given = {each.arg: each.value for each in call.keywords if each.arg is not None}
    if name == "AtRest":
        return "none, the spacecraft stands still"
    if isinstance(steps := given.get("steps"), ast.Tuple):
        return ", then ".join(_call_in_words(step) for step in steps.elts if isinstance(step, ast.Call))
    told = _plain(name)
    classes: list[type] = [FreeHub, *(kinds[kind] for kinds in (MANEUVERS, DAMPINGS) for kind in kinds)]
    target = next((one for one in classes if one.__name__ == name), None)
    texts = {} if target is None else docstrings.field_texts(target)
    usual = {} if target is None else {field.name: field.default for field in dataclasses.fields(target)}
    for key, node in given.items():
        try:
            value = ast.literal_eval(node)
        except ValueError:
            value = ast.unparse(node)
        if value in (None, ()) or (key in usual and key != "axis" and value == usual[key]):
            continue
        unit = re.search(r"\[([^\]]+)\]", texts.get(key, ""))
        told += f", {_plain(key)} {_number(value)}{'' if unit is None or isinstance(value, str) else f' {unit[1]}'}"
        if unit is not None and unit[1] == "rad" and isinstance(value, float | int):
            told += f" ({math.degrees(value):.3g}°)"
    return told


def _plain(name: str) -> str:
    """A name of Python as words, "SpinUp" as "spin up"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name).replace("_", " ").lower()


def _number(value: Any) -> str:
    """Numbers as people write them; a direction along an axis as its letter."""
    if isinstance(value, tuple | list):
        letters = {(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"}
        return letters.get(tuple(value), f"({', '.join(map(_number, value))})")
    return f"{value:.5g}" if isinstance(value, float | int) and not isinstance(value, bool) else str(value)


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
            if settled:
                since = f" from {settled:.4g} s {'after it' if end else 'on'}"
            else:
                since = " from its end on" if end else " throughout"
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
