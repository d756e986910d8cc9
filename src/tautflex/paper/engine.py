"""Perform many runs in parallel; what is finished is kept, whatever happens to the rest.

Own, on the standard library's pool: Ctrl-C within a hundredth of a run, workers that die with their parent and a
message for one that was killed are tested here, and joblib promises none of them.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path

import xarray as xr

from tautflex.errors import InputError, NotConvergedError, TautflexError
from tautflex.files import netcdf
from tautflex.paper.cases.catalogue import RunSpec
from tautflex.paper.finished_runs import stored, sweep_leftovers
from tautflex.paper.work import perform_one, start_worker, work
from tautflex.solvers.transient.status import Status

Progress = Callable[[float, str], None]
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class WorkerLostError(TautflexError, RuntimeError):
    """A worker process ended without a word, for example for lack of memory; finished runs are kept."""


def perform(
    specs: Iterable[RunSpec],
    directory: str | os.PathLike[str],
    workers: int | None = None,
    progress: Progress | None = None,
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
    wanted = list(specs)
    place = Path(directory)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        text = f"directory: expected a place that can be written, got {str(place)!r} ({error.strerror})"
        raise InputError(f"{text}; choose another one") from error
    sweep_leftovers(place)
    total, done = sum(map(_cost, wanted)) or 1.0, 0.0

    def tell(spec: RunSpec) -> None:
        nonlocal done
        done += _cost(spec)
        if progress is not None:
            progress(min(done / total, 1.0), spec.name)

    missing = {}
    for spec in wanted:
        if stored(spec, place) is None:
            missing[spec.case.to_toml()] = spec
        else:
            tell(spec)
    # Longest first, so that no core is left alone with a long run at the end.
    todo = sorted(missing.values(), key=_cost, reverse=True)
    count = min(workers or os.cpu_count() or 1, len(todo))
    here = ((spec, perform_one(spec, place)) for spec in todo)
    performed = _in_processes(todo, place, count) if count > 1 else here
    failed = {}
    for spec, (status, message) in performed:
        if status == Status.INTERRUPTED.value:
            raise KeyboardInterrupt
        if status != Status.COMPLETED.value:
            failed[spec.name] = message
        tell(spec)
    if failed:
        raise NotConvergedError("; ".join(f"{name}: {message}" for name, message in failed.items()))
    files = {spec.name: stored(spec, place) for spec in wanted}
    if lost := [name for name, path in files.items() if path is None]:
        text = f"directory: expected the result of {lost[0]} just written in {place}, found none or a damaged one"
        raise InputError(f"{text}; keep other programs out of this directory and call again")
    return {name: path for name, path in files.items() if path is not None}


def load_results(paths: Mapping[str, str | os.PathLike[str]]) -> dict[str, xr.Dataset]:
    """Read the results that :func:`perform` names.

    Raises
    ------
    InputError
        If a file is missing or unreadable.
    """
    return {name: netcdf.load(path) for name, path in paths.items()}


def _in_processes(specs: list[RunSpec], directory: Path, count: int) -> Iterator[tuple[RunSpec, tuple[str, str]]]:
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    with _one_thread_each():
        pool = ProcessPoolExecutor(count, mp_context=context, initializer=start_worker, initargs=(stop,))
        try:
            pending: dict[Future[tuple[str, str]], RunSpec] = {pool.submit(work, one, directory): one for one in specs}
            while pending:
                finished, _ = wait(pending, return_when=FIRST_COMPLETED)
                for future in finished:
                    yield pending.pop(future), future.result()
        except BrokenProcessPool:
            text = "a worker process died before its run was finished, perhaps for lack of memory"
            raise WorkerLostError(f"{text}; finished runs are kept: call again, with fewer workers") from None
        finally:
            stop.set()  # ends runs under way within a hundredth of their length
            pool.shutdown(cancel_futures=True)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let worker processes start with one linear-algebra thread each: more would fight for the cores."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _cost(spec: RunSpec) -> float:
    """Estimate the relative cost of a run: steps times cells."""
    cells = spec.case.mesh.divisions
    return spec.case.solver.end_time / spec.case.solver.time_step * cells[0] * cells[1]
