"""Measures of a point: the numbers of a run's JSON by dotted names, each with its unit."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from tautflex.analysis.record import outlasting
from tautflex.case.loop import loop_summary
from tautflex.case.messages import show
from tautflex.case.prepared import Prepared
from tautflex.case.run import read_probe, summary_of
from tautflex.case.schema import Case
from tautflex.errors import CaseError
from tautflex.solvers.transient.status import Run

UNITS = {
    "probes.*.amplitude": "m",
    "probes.*.dominant_frequency": "Hz",
    "probes.*.bin_width": "Hz",
    "surface.rms": "m",
    "surface.rms_max": "m",
    "surface.tilt.?": "rad",
    "surface.settling_time": "s",
    "natural_frequencies.*": "Hz",
    "steps": "1",
    "back_substitutions": "1",
    "factorizations": "1",
    "time_error": "1",
    "energy_balance.*": "J",
    "prestress.residual": "N",
    "prestress.min_principal_resultant": "N m-1",
    "min_principal_resultant": "N m-1",
    "settling_time.attitude": "s",
    "settling_time.surface": "s",
    "energy_by_source.*": "J",
    "commands.*": "",
}
"""Every measure there is, ``*`` and ``?`` for names and numbers, and its unit; commands have that of their actuator."""
# Of every open-loop run, whatever its probes and inputs are called.
_BALANCE = ("initial", "kinetic", "strain", "damping", "method", "loads", "maneuver", "residual")
# Not the same when a point is run again.
_NOT_KEPT = ("seconds",)


def unit_of(name: str) -> str:
    """Unit of a measure."""
    return next((unit for pattern, unit in UNITS.items() if fnmatchcase(name, pattern)), "")


def words(name: str, unit: str) -> dict[str, str]:
    """Attributes of a variable of a study; "" is no unit."""
    return {"long_name": name} | ({"units": unit} if unit else {})


def check_names(names: Sequence[str], case: Case, where: str = "measures.names") -> None:
    """Raise CaseError for a name that no point of a study can have, with the nearest one."""
    for name in names:
        known = known_names(case)
        if name in known or any(fnmatchcase(name, one) for one in known):
            continue
        near = difflib.get_close_matches(name, known, n=1)
        remedy = f"did you mean {near[0]!r}?" if near else "see docs/studies.md for all of them"
        raise CaseError(f"{where}: expected measures of the run's JSON, got {show(name)}; {remedy}")


def known_names(case: Case) -> list[str]:
    """Names of the measures of a case; ``*`` stands for a number or for names that only a run tells."""
    closed = case.controller is not None
    found = []
    for pattern in UNITS:
        if pattern.startswith("probes."):
            found += [pattern.replace("*", name) for name in case.output.probes]
        elif pattern == "energy_balance.*":
            found += [pattern.replace("*", name) for name in _BALANCE]
        elif pattern in ("energy_by_source.*", "commands.*"):
            found += [pattern.replace("*", name) for name in case.actuators] if closed else []
        elif closed or not pattern.startswith("settling_time."):
            found += [pattern.replace("?", number) for number in "01"] if "?" in pattern else [pattern]
    return found


def measures_of(case: Case, ready: Prepared, run: Run, names: Sequence[str]) -> dict[str, float | None]:
    """Numbers of a run, those with the given names or all; None where the run does not tell one."""
    frequencies: Iterable[float] = ()
    if not names or any(name.startswith("natural_frequencies") for name in names):
        frequencies = ready.frequencies
    told = summary_of(case, ready.state, run, frequencies)
    told["prestress"] = {
        "residual": ready.state.residual,
        "min_principal_resultant": ready.state.min_principal_resultant,
    }
    lowest = run.data["min_principal_resultant"].values
    told["min_principal_resultant"] = float(np.nanmin(lowest)) if np.isfinite(lowest).any() else None
    if case.controller is not None:
        told |= loop_summary(case, run)
        commands = run.data["command"].transpose("input", ...)
        names_of_inputs = commands["input"].values
        told["commands"] = {
            str(name): float(np.abs(own).max()) for name, own in zip(names_of_inputs, commands.values, strict=True)
        }
    flat = flattened(told)
    return {name: flat.get(name) for name in names} if names else flat


def probe_measures(data: Any, number: int, names: Sequence[str]) -> dict[str, float | None]:
    """Those of one run of a batch: of its probes."""
    end, time = float(data["maneuver_end"].values[number]), data["time"].values
    step = float(time[-1] - time[0]) / max(1, len(time) - 1)
    after = None if end == 0.0 else outlasting(end, time)
    rows = data["w"].transpose("run", "probe", "time").values[number]
    told = {str(name): read_probe((row, step), after) for name, row in zip(data["probe"].values, rows, strict=True)}
    flat = flattened({"probes": told})
    return {name: flat.get(name) for name in names} if names else flat


def flattened(told: Mapping[str, Any]) -> dict[str, float | None]:
    """Numbers of nested tables and lists by dotted names; texts and lists of texts are left out."""
    found: dict[str, float | None] = {}
    for name, value in told.items():
        if isinstance(value, list | tuple):
            value = {str(number): one for number, one in enumerate(value)}
        if isinstance(value, Mapping):
            found |= {f"{name}.{inner}": one for inner, one in flattened(value).items()}
        elif name not in _NOT_KEPT and (value is None or (isinstance(value, int | float))):
            found[name] = float(value) if value is not None and math.isfinite(value) else None
    return found
