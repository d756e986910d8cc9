"""One case from prestress to files: run.nc, summary.json, figures."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from tautflex.analysis import amplitude, dominant_frequency, maneuver_end
from tautflex.case.build import (
    build_adaptive,
    build_basis,
    build_coupling,
    build_damping,
    build_maneuver,
    build_method,
    build_model,
)
from tautflex.case.motion import describe_maneuver
from tautflex.errors import InputError
from tautflex.files import netcdf
from tautflex.reduction.polynomial.model import reduce
from tautflex.solvers.modal.natural import solve_modes
from tautflex.solvers.static.prestress import solve_prestress
from tautflex.solvers.transient.simulate import simulate

if TYPE_CHECKING:
    from tautflex.case import Case

Progress = Callable[[float, str], None]
Figures = Callable[[xr.Dataset, xr.Dataset, Path], list[Path]]

MODE_COUNT = 10


def run_case(
    case: Case,
    directory: Path,
    progress: Progress | None = None,
    *,
    figures: Figures | None = None,
    title: str = "tautflex run",
) -> dict[str, Any]:
    """Simulate a case and write its results.

    Nothing is written before the simulation has ended: bad input leaves no trace. A run that did not
    converge or was interrupted is written as far as it got, with its status in the file and in the summary.

    Parameters
    ----------
    case
        Validated case.
    directory
        Where ``run.nc``, ``summary.json`` and figures go; created if missing, an earlier run replaced.
    progress
        Called with the fraction done (0 to 1) and a short message.
    figures
        Function (run dataset, modes dataset, directory) that writes figures and returns their paths.
    title
        Stored in ``run.nc``.

    Returns
    -------
    dict
        ``status``, ``message``, ``maneuver``, ``probes`` (amplitude [m], dominant_frequency [Hz],
        bin_width [Hz], see `read_probe`),
        ``natural_frequencies`` [Hz], ``steps``, ``seconds`` [s], ``back_substitutions``, ``factorizations``,
        ``warnings`` (sentences), ``files``; the content of ``summary.json``.

    Raises
    ------
    InputError
        If the case cannot be built, prestressed or simulated.
    OSError
        If the directory cannot be written.
    """
    tell = progress or _silent
    maneuver = build_maneuver(case)
    tell(0.0, "prestress")
    state = solve_prestress(build_model(case))
    tell(0.0, "modes")
    free = len(state.model.free_dofs)
    modes = solve_modes(state, n=min(MODE_COUNT, free - 1))
    basis = build_basis(case)
    if basis is not None:
        tell(0.0, "reduced model")
    run = simulate(
        state if basis is None else reduce(state, basis),
        maneuver,
        method=build_method(case),
        time_step=case.solver.time_step,
        end_time=case.solver.end_time,
        adaptive=build_adaptive(case),
        damping=build_damping(case),
        coupling=build_coupling(case),
        probes=case.output.probes,
        probe_reading=case.output.probe_reading,
        every=case.output.every,
        fields=reachable_fields(case),
        progress=progress,
        throw=False,
        **_newton_options(case),
    )
    data = run.data.assign_attrs(title=title, case=case.to_toml(), versions=json.dumps(netcdf.versions()))
    directory.mkdir(parents=True, exist_ok=True)
    tell(1.0, "writing")
    files = {"run": directory / "run.nc", "summary": directory / "summary.json"}
    netcdf.save(data, files["run"])
    if figures is not None:
        files |= _named(figures(data, modes.to_dataset(), directory))
    end = maneuver_end(data)
    summary = {
        "status": run.status.value,
        "message": run.status.message,
        "maneuver": describe_maneuver(case.maneuver),
        "probes": {str(name): read_probe(data["w"].sel(probe=name), end) for name in data["probe"].values},
        "natural_frequencies": [float(value) for value in modes.frequencies],
        "steps": int(run.stats.steps),
        "seconds": float(run.stats.seconds),
        "back_substitutions": int(run.stats.back_substitutions),
        "factorizations": int(run.stats.factorizations),
        **({"reduced_model": data.attrs["reduced_model"]} if basis is not None else {}),
        "warnings": [*state.warnings, *data.attrs["warnings"]],
        "files": {name: str(path) for name, path in files.items()},
    }
    files["summary"].write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return summary


def reachable_fields(case: Case) -> str | list[float]:
    """List the instants [s] of stored fields up to the end of the run; "none" and "all" stay."""
    fields = case.output.fields
    if isinstance(fields, str):
        return fields
    return [instant for instant in fields if instant <= case.solver.end_time]


def _newton_options(case: Case) -> dict[str, Any]:
    """Options the case states; `simulate` knows the defaults of the others."""
    options = {"tolerance": case.solver.tolerance, "max_halvings": case.solver.max_halvings}
    return {name: value for name, value in options.items() if value is not None}


def read_probe(record: xr.DataArray, maneuver_end: float | None) -> dict[str, float | None]:
    """Measure one probe's record; None where it is too short, or never moved.

    Parameters
    ----------
    record
        Displacement over time [m].
    maneuver_end
        When the rigid motion ends [s]; None if it does not end within the record.

    Returns
    -------
    dict
        ``amplitude`` [m] of the whole record; ``dominant_frequency`` [Hz], the bin of largest energy of the motion
        after the maneuver (during it the inertial load holds the film off its plane, and that offset would win);
        ``bin_width`` [Hz].
    """
    answer: dict[str, float | None] = dict.fromkeys(("amplitude", "dominant_frequency", "bin_width"))
    try:
        answer["amplitude"] = float(amplitude(record))
        peak = dominant_frequency(record, after=maneuver_end)
        answer["bin_width"] = float(peak.bin_width)
        answer["dominant_frequency"] = _number_or_none(peak.frequency)
    except InputError:
        pass  # a run cut short after a few steps: what is known so far stays
    return answer


def _number_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _named(paths: list[Path]) -> dict[str, Path]:
    """Key files by stem; a second format of the same figure is keyed by its full name."""
    named: dict[str, Path] = {}
    for path in paths:
        named[path.name if path.stem in named else path.stem] = path
    return named


def _silent(fraction: float, message: str) -> None:
    """Report nothing."""
