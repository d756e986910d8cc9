"""Points on a Dask cluster: a local one, or any that runs (extra ``distributed``)."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any

from tautflex.errors import InputError, MissingExtraError, TautflexError
from tautflex.study.engines.processes import unheard
from tautflex.study.work import FAILED, Outcome, Task, work

_AHEAD = 3  # chunks per thread of a worker that wait on the scheduler: none is idle, and it has little to keep
_PATIENCE = "10s"  # for a scheduler to answer


class Cluster:
    """Workers of a running scheduler, or a cluster of processes with one thread each that ends with it.

    Parameters
    ----------
    workers
        Number of processes of a cluster that is started; None is one per core.
    scheduler
        Address of one that runs.

    Raises
    ------
    MissingExtraError
        If Dask is not installed.
    InputError
        If no scheduler answers.
    """

    def __init__(self, workers: int | None = None, scheduler: str | None = None) -> None:
        try:
            import distributed as dask_distributed
        except ImportError:
            text = "engine: expected the package distributed for a Dask cluster, not installed"
            raise MissingExtraError(f"{text}; pip install 'tautflex[distributed]'") from None
        distributed: Any = dask_distributed  # whose functions have no types
        self._open = ExitStack()
        try:
            if scheduler is None:
                options: Any = {"threads_per_worker": 1, "dashboard_address": None, "silence_logs": logging.ERROR}
                with unheard():
                    cluster = self._open.enter_context(distributed.LocalCluster(workers, **options))
                scheduler = cluster.scheduler_address
            self._client: Any = self._open.enter_context(distributed.Client(scheduler, timeout=_PATIENCE))
        except (OSError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())[:120]
            text = f"scheduler: expected a Dask scheduler at {scheduler}, got no answer ({reason})"
            remedy = f"start one with `dask scheduler`, and workers with `dask worker {scheduler}`"
            raise InputError(f"{text}; {remedy}") from None
        self._as_completed = distributed.as_completed

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *error: object) -> None:
        self._open.close()

    def perform(self, task: Task, chunks: Iterable[Sequence[int]]) -> Iterator[list[Outcome]]:
        """Perform chunks of points; yield how they ended as they do.

        Workers may come and go: the chunk of one that dies goes to another, which finds the points that are finished
        in their files. Points over which several workers died are failures.
        """
        waiting = deque(tuple(chunk) for chunk in chunks)
        pending: dict[Any, tuple[int, ...]] = {}
        done = self._as_completed()
        while waiting or pending:
            while waiting and len(pending) < _AHEAD * max(1, sum(self._client.nthreads().values())):
                chunk = waiting.popleft()
                future = self._client.submit(work, task, chunk, pure=False)
                pending[future] = chunk
                done.add(future)
            future = next(done)
            chunk, error = pending.pop(future), future.exception()
            if error is None:
                yield future.result()
            elif isinstance(error, TautflexError):
                raise error
            elif len(chunk) > 1:  # each point alone, to see which one it was
                waiting.extend((number,) for number in chunk)
            else:
                yield [Outcome(chunk[0], FAILED, f"{type(error).__name__}: {error}", new=True)]
