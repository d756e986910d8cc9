"""What a worker does: one point after another, from its case to its file."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from tautflex.case import build
from tautflex.case.loop import build_loop, close_case
from tautflex.case.plugins import LOADED, load_plugin
from tautflex.case.prepared import Prepared, prepare, structure_key
from tautflex.case.run import labelled, question_of
from tautflex.case.schema import Case
from tautflex.errors import CaseError, InputError, MissingExtraError, NotConvergedError
from tautflex.solvers.transient.simulate import simulate
from tautflex.solvers.transient.status import Run, Status
from tautflex.study.measures import measures_of
from tautflex.study.points import Points
from tautflex.study.store import Store, case_key, code_key

Progress = Callable[[float, str], None]
INVALID, FAILED = "invalid", "failed"
"""Status of a point whose case or structure is refused, and of one that broke for another reason, which is not kept."""


class Outcome(NamedTuple):
    """How a point ended; ``new`` tells whether it was computed just now."""

    number: int
    status: str
    message: str
    new: bool


@dataclass(frozen=True)
class Task:
    """All that a worker has to know beside the numbers of its points; other processes can be sent it.

    Parameters
    ----------
    points
        Their cases.
    store
        Where results are kept.
    names
        Measures, all if empty; None keeps none.
    code
        `code_key` of the process that asks.
    plugins
        Files that register classes.
    """

    points: Points
    store: Store
    names: tuple[str, ...] | None
    code: str
    plugins: tuple[str, ...]

    @classmethod
    def of(cls, points: Points, store: Store, names: tuple[str, ...] | None) -> Task:
        """Task of this process, its code and plugins."""
        store = Store(store.directory.absolute(), store.records)
        return cls(points, store, names, code_key(), tuple(str(Path(path).absolute()) for path in LOADED))


def work(task: Task, numbers: Sequence[int], stopped: Callable[[], bool] = lambda: False) -> list[Outcome]:
    """Perform points, but those that are finished; a worker that is told to stop leaves out the rest.

    Raises
    ------
    CaseError
        If this worker has another version of tautflex, or cannot load a plugin.
    """
    for file in task.plugins:
        if file not in {str(Path(path).absolute()) for path in LOADED}:
            load_plugin(Path(file))
    if code_key() != task.code:
        text = "workers: expected the same version and sources of tautflex and plugins as here, got others on a worker"
        raise CaseError(f"{text}; install the same on all")
    outcomes = []
    for number in numbers:
        if stopped():
            break
        outcome = perform_point(task, number, stopped)
        if outcome.status == Status.INTERRUPTED.value:
            break
        outcomes.append(outcome)
    return outcomes


def perform_point(task: Task, number: int, stopped: Callable[[], bool] = lambda: False) -> Outcome:
    """Perform one point unless it is finished, and keep what it told; only what broke for no known reason is not kept.

    Raises
    ------
    InputError
        If its file cannot be written.
    """
    try:
        case = task.points.case(number)
    except CaseError as error:
        return Outcome(number, INVALID, "; ".join(error.problems), new=False)
    key = case_key(case)
    kept = task.store.read(key)
    if kept is not None:
        return Outcome(number, kept["status"], kept["message"], new=False)

    def tell(fraction: float, message: str) -> None:
        if stopped():
            raise KeyboardInterrupt

    started, run, told = time.perf_counter(), None, {}
    try:
        ready = prepared(case)
        run, message = simulated(case, ready, tell)
        status = run.status.value
        if status == Status.INTERRUPTED.value and not stopped():
            raise KeyboardInterrupt  # Ctrl-C, which ended the run as far as it was
        if status == Status.INTERRUPTED.value:
            return Outcome(number, status, message, new=False)
        told = {} if task.names is None else measures_of(case, ready, run, task.names)
    except InputError as error:
        status, message = INVALID, str(error)
    except NotConvergedError as error:  # before the first step
        status, message = Status.NOT_CONVERGED.value, str(error)
    except MissingExtraError:
        raise
    except Exception as error:  # of one point, whatever it is; no memory, a plugin's mistake
        return Outcome(number, FAILED, f"{type(error).__name__}: {error}", new=True)
    content = {
        "point": task.points.name(number),
        "status": status,
        "message": message,
        "seconds": time.perf_counter() - started,
        "measures": told,
        "warnings": [] if run is None else run.warnings,
    }
    record = None
    if task.store.records and run is not None and status == Status.COMPLETED.value:
        record = run.data.assign_attrs(title=task.points.name(number))
    task.store.write(key, content, record)
    return Outcome(number, status, message, new=True)


def simulated(case: Case, ready: Prepared, tell: Progress) -> tuple[Run, str]:
    """Run of a case, closed loops too, and how it ended in words."""
    if case.controller is None:
        run = labelled(case, simulate(**question_of(case, ready, build.build_maneuver(case), tell), throw=False))
        return run, "" if run.status is Status.COMPLETED else run.status.message
    try:
        return close_case(case, *build_loop(case, ready.state, tell, ready.reduced), tell), ""
    except NotConvergedError as error:
        if not isinstance(error.result, Run):
            raise
        return error.result, str(error)


_LAST = threading.local()


def prepared(case: Case) -> Prepared:
    """Structure of a case; that of the case before is not made again where it is the same."""
    key = structure_key(case)
    if getattr(_LAST, "key", None) != key:
        _LAST.key = _LAST.ready = None  # two of them need not fit into memory
        _LAST.ready, _LAST.key = prepare(case), key
    ready: Prepared = _LAST.ready
    return ready
