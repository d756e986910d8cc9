"""Perform many runs in parallel, as points of a study; what is finished is kept, whatever happens to the rest."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path

import xarray as xr

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.files import netcdf
from tautflex.paper.cases.catalogue import RunSpec
from tautflex.solvers.transient.status import Status
from tautflex.study.engines.serial import Pool
from tautflex.study.points import Listing
from tautflex.study.store import Store, case_key
from tautflex.study.work import Task

Progress = Callable[[float, str], None]


def perform(
    specs: Iterable[RunSpec],
    directory: str | os.PathLike[str],
    workers: int | None = None,
    progress: Progress | None = None,
    finished: Callable[[Path], object] | None = None,
) -> dict[str, Path]:
    """Perform runs, each in one of several processes, and keep their results.

    A run that `directory` holds already is not performed again; results of other cases, versions or equations, and
    damaged files, do not count. The processes are spawned: a script that calls this needs the usual
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    specs
        Runs, see :func:`tautflex.paper.cases.catalogue.catalogue`; equal cases are performed once.
    directory
        Where results are kept; made if missing.
    workers
        Number of processes; by default one per core, at most one per run. With 1 everything happens in this process.
    progress
        Called with the fraction of all work done, by number of steps and size of mesh, and the name of a finished run.
    finished
        Called with the file of every finished run, while others still run.

    Returns
    -------
    dict
        File of each run by name, in the order of ``specs``.

    Raises
    ------
    InputError
        If ``workers`` is below 1 or the directory cannot be written.
    NotConvergedError
        If runs did not converge; all others are finished first.
    WorkerLostError
        If a worker process died.
    KeyboardInterrupt
        On Ctrl-C; finished runs stay.
    """
    if workers is not None and workers < 1:
        raise InputError(f"workers: expected a number >= 1, got {workers}; leave it out for one per core")
    wanted, report = list(specs), checks.teller(progress)
    place = Path(directory)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        text = f"directory: expected a place that can be written, got {str(place)!r} ({error.strerror})"
        raise InputError(f"{text}; choose another one") from error
    store = Store(place, records=True)
    store.sweep_leftovers()
    total, done = sum(map(_cost, wanted)) or 1.0, 0.0
    missing, keys = dict[str, RunSpec](), {spec.name: case_key(spec.case) for spec in wanted}

    def tell(spec: RunSpec) -> None:
        nonlocal done
        done += _cost(spec)
        report(min(done / total, 1.0), spec.name)
        if finished is not None and netcdf.is_whole(file := store.record(keys[spec.name])):
            finished(file)

    for spec in wanted:
        if netcdf.is_whole(store.record(keys[spec.name])):
            tell(spec)
        else:
            missing[keys[spec.name]] = spec
    # Longest first, so that no core is left alone with a long run at the end.
    todo = sorted(missing.values(), key=_cost, reverse=True)
    points = Listing([spec.name for spec in todo], [spec.case.to_toml() for spec in todo])
    failed = {}
    with Pool(min(workers or os.cpu_count() or 1, len(todo))) as pool:
        chunks = [[number] for number in range(len(todo))]
        with closing(pool.perform(Task.of(points, store, None), chunks)) as performed:
            for outcomes in performed:
                for one in outcomes:
                    if one.status != Status.COMPLETED.value:
                        failed[todo[one.number].name] = one.message
                    tell(todo[one.number])
    if failed:
        raise NotConvergedError("; ".join(f"{name}: {message}" for name, message in failed.items()))
    files = {name: store.record(key) for name, key in keys.items()}
    if lost := [name for name, path in files.items() if not netcdf.is_whole(path)]:
        text = f"directory: expected the result of {lost[0]} just written in {place}, found none or a damaged one"
        raise InputError(f"{text}; keep other programs out of this directory and call again")
    return files


def results(
    specs: Iterable[RunSpec],
    directory: str | os.PathLike[str],
    workers: int | None = None,
    progress: Progress | None = None,
) -> dict[str, xr.Dataset]:
    """Perform runs as :func:`perform` does, and read their results, each while others still run.

    Returns
    -------
    dict
        Result of each run by name, in the order of ``specs``; equal cases share one.

    Raises
    ------
    InputError, NotConvergedError, WorkerLostError, KeyboardInterrupt
        As `perform`.
    """
    read = dict[Path, xr.Dataset]()

    def finished(file: Path) -> None:
        read[file] = netcdf.load(file)

    return {name: read[file] for name, file in perform(specs, directory, workers, progress, finished).items()}


def _cost(spec: RunSpec) -> float:
    """Estimate the relative cost of a run: steps times cells."""
    cells = spec.case.mesh.divisions
    return spec.case.solver.end_time / spec.case.solver.time_step * cells[0] * cells[1]
