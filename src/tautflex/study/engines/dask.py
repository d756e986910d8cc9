"""Points on a Dask cluster: a local one, or any that runs (extra ``distributed``)."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from tautflex.errors import InputError, MissingExtraError, TautflexError
from tautflex.study.work import FAILED, Outcome, Task, work

_AHEAD = 3  # chunks per thread of a worker that wait on the scheduler: none is idle, and it has little to keep
_PATIENCE = "10s"  # for a scheduler to answer


def perform(
    task: Task, chunks: Sequence[Sequence[int]], workers: int | None = None, scheduler: str | None = None
) -> Iterator[list[Outcome]]:
    """Perform chunks of points on a cluster.

    Workers may come and go: the chunk of one that dies goes to another, which finds the points that are finished in
    their files. Points over which several workers died are failures.

    Raises
    ------
    MissingExtraError
        If Dask is not installed.
    InputError
        If no scheduler answers.
    """
    try:
        import distributed
    except ImportError:
        text = "engine: expected the package distributed for a Dask cluster, not installed"
        raise MissingExtraError(f"{text}; pip install 'tautflex[distributed]'") from None
    with _client(distributed, workers, scheduler) as client:
        waiting = deque(tuple(chunk) for chunk in chunks)
        pending: dict[Any, tuple[int, ...]] = {}
        done: Any = distributed.as_completed()  # type: ignore[no-untyped-call]
        while waiting or pending:
            while waiting and len(pending) < _AHEAD * max(1, sum(client.nthreads().values())):
                chunk = waiting.popleft()
                future = client.submit(work, task, chunk, pure=False)
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


@contextmanager
def _client(distributed: Any, workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """Client of a running scheduler, or of a cluster of processes with one thread each that ends with it."""
    if scheduler is None:
        with (
            distributed.LocalCluster(
                workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=logging.ERROR
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client
        return
    try:
        client = distributed.Client(scheduler, timeout=_PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        reason = " ".join(str(error).split())[:120]
        text = f"scheduler: expected a Dask scheduler at {scheduler}, got no answer ({reason})"
        raise InputError(
            f"{text}; start one with `dask scheduler`, and workers with `dask worker {scheduler}`"
        ) from None
    with client:
        yield client
