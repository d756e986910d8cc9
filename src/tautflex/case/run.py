"""One case: simulated, and written to files as run.nc, summary.json and figures."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import xarray as xr

from tautflex import checks
from tautflex.analysis import Record, amplitude, dominant_frequency, settling_time, surface
from tautflex.analysis.record import counted_from
from tautflex.case import build
from tautflex.case.options import by_keys
from tautflex.case.prepared import Prepared, lowest_modes, own_code, prepare
from tautflex.case.schema import Case
from tautflex.errors import CaseError, InputError
from tautflex.files import netcdf
from tautflex.files.checkpoints import FOLDER, RunFolder, run_folder
from tautflex.files.earlier import read_summary, remove_left_files
from tautflex.files.transaction import publish, result_file
from tautflex.interrupts import deferred
from tautflex.motion.kinematics import Maneuver
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.simulate import simulate
from tautflex.solvers.transient.status import Run, Status

Progress = Callable[[float, str], None]
Figures: TypeAlias = "Callable[[xr.Dataset, xr.Dataset, Path], list[Path]]"

CHECKPOINT = 60.0
"""Wall-clock time between two checkpoints [s]."""


def run_case(
    case: Case,
    progress: Progress | None = None,
    *,
    throw: bool = True,
    checkpoint: str | os.PathLike[str] | None = None,
    seconds: float = CHECKPOINT,
) -> Run:
    """Simulate a case: what `tautflex run` does, without files and with the same numbers.

    Parameters
    ----------
    case
        Validated case; a section [reduction] makes a reduced model of it.
    progress
        Called with the fraction done (0 to 1) and a short message; KeyboardInterrupt raised in it ends the run.
    throw
        Raise when the run fails; False returns the labelled partial run.
    checkpoint
        Folder that keeps the run while it is under way: one of the same case that was killed or interrupted goes on
        there, to the bit. It goes when the run has ended by itself.
    seconds
        Wall-clock time between two checkpoints [s].

    Returns
    -------
    Run

    Raises
    ------
    InputError
        If the case cannot be built, prestressed or simulated, or the checkpoint is that of another one.
    NotConvergedError
        If a step fails and ``throw`` is set; ``.result`` holds the partial run.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.run_case(tf.load_case("m2.toml", ["solver.end_time=0.1", "solver.time_step=0.01"]))
    >>> run.status.value
    'completed'
    """
    checks.instance("case", case, Case, "a case", remedy="load_case('m2.toml') gives one")
    require_open_loop(case)
    checks.positive("seconds", seconds)
    folder = None if checkpoint is None else checks.path("checkpoint", checkpoint)
    tell = checks.teller(progress)
    maneuver, state = prestressed(case, tell)
    question = _question(case, state, maneuver, tell)
    if folder is None:
        with by_keys():
            return labelled(case, simulate(**question, throw=throw))
    with (
        result_file(folder, "checkpoint"),
        run_folder(RunFolder, folder, owner_of(case), seconds, resume=True) as keeper,
    ):
        run = _kept_run(case, question, keeper, throw=throw)
        if run.status is Status.INTERRUPTED:
            return run
    # Its record, which is mapped into memory, outlives the files.
    keeper.remove()
    return run


def write_case_run(
    case: Case,
    directory: Path,
    progress: Progress | None = None,
    *,
    figures: Figures | None = None,
    title: str = "tautflex run",
    seconds: float = CHECKPOINT,
    resume: bool = False,
) -> dict[str, Any]:
    """Simulate a case and write ``run.nc``, ``summary.json`` and figures into a directory, an earlier run replaced.

    Bad input leaves no trace. A run that did not converge or was interrupted is written as far as it got, with its
    status in the file and in the summary. ``figures`` takes the datasets of run and modes and the directory, and
    returns what it wrote; ``title`` is stored in ``run.nc``. Checkpoints, ``seconds`` apart, are kept in the directory;
    ``resume`` goes on from the last one.

    Returns
    -------
    dict
        The content of ``summary.json``, SI units; the dominant frequency of a probe is that after the maneuver.
    """
    require_open_loop(case)
    tell = checks.teller(progress)
    maneuver, state = prestressed(case, tell)
    question = _question(case, state, maneuver, tell)
    with deferred(), run_folder(RunFolder, directory / FOLDER, owner_of(case), seconds, resume) as keeper:
        run = _kept_run(case, question, keeper, throw=False)
        more = {"resumed_from": keeper.resumed_from}
        found = write_results(case, state, run, directory, tell, figures, title, more)
        if run.status is not Status.INTERRUPTED:
            keeper.remove()
        return found


def _kept_run(case: Case, question: Mapping[str, Any], keeper: RunFolder, *, throw: bool) -> Run:
    """Run of a case that a folder keeps, with what there was to say about checkpoints."""
    with by_keys():
        return with_trouble(labelled(case, simulate(**question, throw=throw, keeper=keeper)), keeper)


def with_trouble(run: Run, keeper: RunFolder) -> Run:
    """Run with a warning of what its keeper could not keep."""
    if not keeper.trouble:
        return run
    return replace(run, data=run.data.assign_attrs(warnings=[*run.warnings, keeper.trouble]))


def owner_of(case: Case) -> dict[str, str]:
    """What the checkpoint of a case is recognised by."""
    return {"case": case.to_toml(), "code of tautflex": own_code()}


def write_results(
    case: Case,
    state: PrestressedState,
    run: Run,
    directory: Path,
    tell: Progress,
    figures: Figures | None,
    title: str,
    more: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Write a run of a case as `write_case_run` says; ``more`` joins the summary, or replaces what it says."""
    tell(1.0, "modes")
    modes = lowest_modes(state)
    run = replace(run, data=run.data.assign_attrs(title=title))
    tell(1.0, "writing")

    def write(place: Path, final: Path) -> dict[str, Any]:
        files = {"run": place / "run.nc", "summary": place / "summary.json"}
        with netcdf.opened(netcdf.save(run, files["run"])) as data:  # a long record is read variable by variable
            summary = summary_of(case, state, replace(run, data=data), modes.frequencies)
            if figures is not None:
                files |= _named(figures(data, modes.to_dataset(), place))
        stand = {name: str(final / path.relative_to(place)) for name, path in files.items()}
        whole = summary | dict(more or {}) | {"files": stand}
        files["summary"].write_text(json.dumps(whole, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        return whole

    earlier = read_summary(directory)
    found = publish(directory, write)
    remove_left_files(directory, earlier, found)
    return found


def summary_of(case: Case, state: PrestressedState, run: Run, frequencies: Iterable[float]) -> dict[str, Any]:
    """What ``summary.json`` says of a run, but its files; natural ``frequencies`` [Hz] are those of the state."""
    data, end = run.data, counted_from(run)
    return {
        "status": run.status.value,
        "message": run.status.message,
        "maneuver": case.maneuver.describe(),
        "probes": {str(name): read_probe(data["w"].sel(probe=name), end) for name in data["probe"].values},
        "surface": read_surface(data, end, case.output.surface_tolerance),
        "natural_frequencies": [float(value) for value in frequencies],
        "steps": int(run.stats.steps),
        "seconds": float(run.stats.seconds),
        "back_substitutions": int(run.stats.back_substitutions),
        "factorizations": int(run.stats.factorizations),
        **({"reduced_model": data.attrs["reduced_model"]} if case.reduction is not None else {}),
        "time_error": run.error if math.isfinite(run.error) else None,
        "energy_balance": dict(run.energy_balance),
        "warnings": [*state.warnings, *data.attrs["warnings"]],
    }


def require_open_loop(case: Case) -> None:
    """Raise CaseError for a case of a closed loop."""
    for name in ("hub", "controller"):
        if getattr(case, name) is not None:
            text = f"{name}: expected no [{name}] for a run of a prescribed motion, got one"
            raise CaseError(f"{text}; close the loop by `tautflex control`, or remove the section")


def prestressed(case: Case, progress: Progress) -> tuple[Maneuver, PrestressedState]:
    """Maneuver and prestressed state of a case."""
    maneuver = build.build_maneuver(case)  # a table that is not there is known before the work begins
    progress(0.0, "prestress")
    return maneuver, build.build_state(case)


def _question(case: Case, state: PrestressedState, maneuver: Maneuver, progress: Progress) -> dict[str, Any]:
    return question_of(case, prepare(case, state, progress), maneuver, progress)


def question_of(case: Case, ready: Prepared, maneuver: Maneuver, progress: Progress) -> dict[str, Any]:
    """The one place where a case becomes the arguments of `simulate`."""
    solver, fields = case.solver, case.output.fields
    stated: dict[str, Any] = {"tolerance": solver.tolerance, "max_halvings": solver.max_halvings}
    return dict(
        state=ready.plant,
        maneuver=maneuver,
        method=solver.build(),
        time_step=solver.time_step,
        end_time=solver.end_time,
        adaptive=solver.adaptive(),
        time_error=solver.time_error,
        damping=build.build_damping(case, ready.state),
        coupling=case.coupling.build(),
        inputs=ready.inputs,
        probes=case.output.probes,
        probe_reading=case.output.probe_reading,
        initial_imperfection=solver.initial_imperfection,
        every=case.output.every,
        fields=fields if isinstance(fields, str) else [t for t in fields if t <= solver.end_time],
        frames=case.output.frames,
        progress=progress,
        **{name: value for name, value in stated.items() if value is not None},
    )


def labelled(case: Case, run: Run) -> Run:
    """The run with what it was made from."""
    attributes = {"case": case.to_toml(), "versions": json.dumps(netcdf.versions())}
    tolerance = case.output.surface_tolerance
    return replace(run, data=run.data.assign_attrs(attributes, surface_tolerance=tolerance))


def read_probe(record: Record, start: float | None) -> dict[str, float | None]:
    """Measure one probe's displacement [m]; None where the record is too short, or never moved.

    The dominant frequency is that of the motion from ``start`` [s] on, after the maneuver (`counted_from`): during it
    the inertial load holds the film off its plane, and that offset would win.
    """
    answer: dict[str, float | None] = dict.fromkeys(("amplitude", "dominant_frequency", "bin_width"))
    try:
        answer["amplitude"] = float(amplitude(record))
        peak = dominant_frequency(record, after=start)
        answer["bin_width"] = float(peak.bin_width)
        answer["dominant_frequency"] = float(peak.frequency) if math.isfinite(peak.frequency) else None
    except InputError:
        pass  # a run cut short after a few steps: what is known so far stays
    return answer


def read_surface(data: xr.Dataset, start: float | None, tolerance: float) -> dict[str, Any]:
    """Measures of the film at the end [m, rad], its largest rms after the maneuver, and its time to settle [s].

    None without a film, for a record that ends before the maneuver does, for a film that does not settle to the
    tolerance [m].
    """
    answer: dict[str, Any] = {"rms": None, "rms_max": None, "tilt": [None, None], "settling_time": None}
    try:
        film = surface(data)
    except InputError:
        return answer
    last = film.isel(time=-1)
    answer |= {"rms": float(last["rms"]), "tilt": [float(last["tilt_x"]), float(last["tilt_y"])]}
    after = film["rms"][film["time"].values >= (start or 0.0)]
    answer["rms_max"] = float(after.max()) if after.size else None
    answer["settling_time"] = read_settling(film["rms"], tolerance, start)
    return answer


def read_settling(record: xr.DataArray, tolerance: float, start: float | None) -> float | None:
    """Time to settle after the maneuver [s]; None where the record does not, or is too short."""
    with suppress(InputError):
        settled = settling_time(record, tolerance, after=start)
        return settled if math.isfinite(settled) else None
    return None


def _named(paths: list[Path]) -> dict[str, Path]:
    """Key files by stem; a second format of the same figure is keyed by its full name."""
    named: dict[str, Path] = {}
    for path in paths:
        named[path.name if path.stem in named else path.stem] = path
    return named
