"""One run, from its case to its stored result: what a worker process does."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from multiprocessing.synchronize import Event
from pathlib import Path

from tautflex.case.run import run_case
from tautflex.errors import NotConvergedError
from tautflex.paper.cases.catalogue import RunSpec
from tautflex.paper.finished_runs import keep
from tautflex.solvers.transient.status import Status

Progress = Callable[[float, str], None]
_STOP: list[Event] = []  # set once by `start_worker`, in worker processes only


def start_worker(stop: Event) -> None:
    """Prepare a worker process: it ends when told to, and when its parent is gone."""
    _STOP[:] = [stop]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which tells us
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def work(spec: RunSpec, directory: Path) -> tuple[str, str]:
    """Perform and store a run in a worker process; return its status and, in words, its message."""
    return perform_one(spec, directory, _stop_if_told if _STOP else None)


def perform_one(spec: RunSpec, directory: Path, progress: Progress | None = None) -> tuple[str, str]:
    """Perform a run and store it if it completed; return value and message of its status."""
    try:
        run = run_case(spec.case, progress, throw=False)
    except NotConvergedError as error:  # before the first step
        return Status.NOT_CONVERGED.value, str(error)
    if run.status is Status.COMPLETED:
        keep(spec, run.data.assign_attrs(title=spec.name), directory)
    return run.status.value, run.status.message


def _stop_if_told(fraction: float, message: str) -> None:
    if _STOP[0].is_set():
        raise KeyboardInterrupt


def _leave_with_parent() -> None:
    """Wait for the parent's end, however it comes, and end at once: nobody would collect our work."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
