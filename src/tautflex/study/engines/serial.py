"""Points in processes of this machine; what is finished is kept, whatever happens to the rest.

Own, on the standard library's pool: Ctrl-C within a hundredth of a run, workers that die with their parent and a
message for one that was killed are tested here, and joblib promises none of them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from typing import Any

from tautflex.errors import TautflexError
from tautflex.interrupts import deferred, meet
from tautflex.study.work import Outcome, Task, work

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_AHEAD = 2  # chunks per process that wait, so that none is idle and the queue stays short


class WorkerLostError(TautflexError, RuntimeError):
    """A worker process ended without a word, for example for lack of memory; finished points are kept."""


class Pool:
    """Processes that perform chunks of points; with one everything happens in this process.

    The processes are spawned: a script that starts them needs the usual ``if __name__ == "__main__":``.

    Parameters
    ----------
    workers
        Number of processes.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Pool:
        if self._workers > 1:
            context = multiprocessing.get_context("spawn")
            self._stop = context.Event()
            options: Any = {"mp_context": context, "initializer": _start_worker, "initargs": (self._stop,)}
            self._pool = ProcessPoolExecutor(self._workers, **options)
        return self

    def __exit__(self, *error: object) -> None:
        if self._pool is not None:
            self._stop.set()  # ends runs under way within a hundredth of their length
            self._pool.shutdown(cancel_futures=True)

    def perform(self, task: Task, chunks: Iterable[Sequence[int]]) -> Generator[list[Outcome], None, None]:
        """Perform chunks of points; yield how they ended as they do.

        Raises
        ------
        WorkerLostError
            If a worker process died.
        """
        if self._pool is None:
            for chunk in chunks:
                for number in chunk:
                    with deferred():  # a signal ends the run between two steps, and the study after it
                        found = work(task, [number])
                        meet()
                    yield found
            return
        waiting, pending = deque(chunks), set[Future[list[Outcome]]]()
        try:
            while waiting or pending:
                with _one_thread_each():  # processes start when they are needed
                    while waiting and len(pending) < _AHEAD * self._workers:
                        pending.add(self._pool.submit(_work, task, waiting.popleft()))
                finished, pending = wait(pending, return_when=FIRST_COMPLETED)
                for future in finished:
                    yield future.result()
        except BrokenProcessPool:
            text = "a worker process died before its run was finished, perhaps for lack of memory"
            raise WorkerLostError(f"{text}; finished runs are kept: call again, with fewer workers") from None


_STOP: list[Event] = []  # set once by `_start_worker`, in worker processes only


def _start_worker(stop: Event) -> None:
    """Prepare a worker process: it ends when told to, and when its parent is gone."""
    _STOP[:] = [stop]
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the parent, which tells us
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _work(task: Task, numbers: Sequence[int]) -> list[Outcome]:
    return work(task, numbers, _STOP[0].is_set)


def _leave_with_parent() -> None:
    """Wait for the parent's end, however it comes, and end at once: nobody would collect our work."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


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
