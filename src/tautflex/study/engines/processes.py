"""Processes of this machine that calls are given to; whatever happens to one of them, none is left over.

Own, on the standard library's pool: Ctrl-C within a second, workers that die with their parent and a message for one
that was killed are tested here, and joblib promises none of them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Event
from typing import Any, TypeVar

from tautflex.errors import TautflexError
from tautflex.interrupts import deferred, meet

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_AHEAD = 2  # calls per process that wait, so that none is idle and the queue stays short
_LOOK = 0.1  # seconds between two looks for a signal
_GRACE = 1.0  # seconds in which a worker that was told to stop may end what it does
Job = TypeVar("Job")
Result = TypeVar("Result")


class WorkerLostError(TautflexError, RuntimeError):
    """A worker process ended without a word, for example for lack of memory; what was finished is kept."""


class Processes:
    """Spawned processes with one linear-algebra thread each, which end with their parent.

    A script that starts them needs the usual ``if __name__ == "__main__":``.

    Parameters
    ----------
    count
        Number of processes.
    """

    def __init__(self, count: int) -> None:
        self._count = count

    def __enter__(self) -> Processes:
        context = multiprocessing.get_context("spawn")
        with unheard():
            self._stop = context.Event()
            options: Any = {"mp_context": context, "initializer": _start_worker, "initargs": (self._stop,)}
            self._pool = ProcessPoolExecutor(self._count, **options)
        return self

    def __exit__(self, *error: object) -> None:
        """Tell workers to stop; those that cannot, as in a factorization, are ended: files are whole or not there."""
        self._stop.set()
        late = threading.Timer(_GRACE, _end, [list((self._pool._processes or {}).values())])
        if error[0] is not None:
            late.start()
        self._pool.shutdown(cancel_futures=True)
        late.cancel()

    def each(self, call: Callable[[Job], Result], jobs: Iterable[Job]) -> Generator[tuple[Job, Result], None, None]:
        """Call a function with every job; yield jobs and results as they come.

        Raises
        ------
        WorkerLostError
            If a worker process died.
        """
        waiting, pending = deque(jobs), dict[Future[Result], Job]()
        try:
            while waiting or pending:
                with deferred():  # an exception inside would leave locks of the pool held for ever
                    with unheard(), _one_thread_each():  # processes start when they are needed
                        while waiting and len(pending) < _AHEAD * self._count:
                            job = waiting.popleft()
                            pending[self._pool.submit(call, job)] = job
                    done = wait(pending, _LOOK, FIRST_COMPLETED).done
                    meet()
                for future in done:
                    yield pending.pop(future), future.result()
        except BrokenProcessPool:
            text = "a worker process died before its run was finished, perhaps for lack of memory"
            raise WorkerLostError(f"{text}; finished runs are kept: call again, with fewer workers") from None


def _end(workers: Sequence[BaseProcess]) -> None:
    for worker in workers:
        worker.terminate()


_STOP: list[Event] = []  # set once by `_start_worker`, in worker processes only


def stopped() -> bool:
    """Whether this is a worker that was told to stop."""
    return bool(_STOP) and _STOP[0].is_set()


def _start_worker(stop: Event) -> None:
    """Prepare a worker process: it ends when told to, and when its parent is gone."""
    _STOP[:] = [stop]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # where it is not held back: it reaches the parent, which tells us
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    """Wait for the parent's end, however it comes, and end at once: nobody would collect our work."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def unheard() -> Iterator[None]:
    """Hold back what a terminal sends to all processes of a command, from those that are started inside for good.

    Workers import for seconds before they could ignore it, and the process that tracks what they share dies of SIGHUP.
    This process meets what comes meanwhile afterwards.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGHUP])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


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
