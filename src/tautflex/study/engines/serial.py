"""Points in processes of this machine; what is finished is kept, whatever happens to the rest."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence

from tautflex.interrupts import deferred, meet
from tautflex.study.engines.processes import Processes, stopped
from tautflex.study.work import Outcome, Task, work


class Pool:
    """Processes that perform chunks of points; with one everything happens in this process.

    Parameters
    ----------
    workers
        Number of processes.
    """

    def __init__(self, workers: int) -> None:
        self._processes = Processes(workers) if workers > 1 else None

    def __enter__(self) -> Pool:
        if self._processes is not None:
            self._processes.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        if self._processes is not None:
            self._processes.__exit__(*error)

    def perform(self, task: Task, chunks: Iterable[Sequence[int]]) -> Generator[list[Outcome], None, None]:
        """Perform chunks of points; yield how they ended as they do.

        Raises
        ------
        WorkerLostError
            If a worker process died.
        """
        if self._processes is None:
            for chunk in chunks:
                for number in chunk:
                    with deferred():  # a signal ends the run between two steps, and the study after it
                        found = work(task, [number])
                        meet()
                    yield found
            return
        for _, found in self._processes.each(_work, ((task, numbers) for numbers in chunks)):
            yield found


def _work(asked: tuple[Task, Sequence[int]]) -> list[Outcome]:
    return work(*asked, stopped)
