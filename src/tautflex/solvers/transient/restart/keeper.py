"""What keeps a run while it is under way: its record, and from time to time where it stands."""

from __future__ import annotations

import json
import mmap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tautflex.numeric import Array
from tautflex.solvers.transient.status import Statistics

Storage = Callable[[str, tuple[int, ...], str], NDArray[Any]]
"""Array of zeros for (name, shape, letters of its type) that a run fills; as far as it was filled, if one goes on."""


def in_memory(name: str, shape: tuple[int, ...], kind: str = "f8") -> NDArray[Any]:
    """Array that is lost with the process."""
    return np.zeros(shape, dtype=kind)


def let_go(*mapped: NDArray[Any] | mmap.mmap) -> None:
    """Give back the memory that files take which are mapped into it; what is read again comes back by itself."""
    for each in mapped:
        base: Any = each
        while isinstance(base, np.ndarray | memoryview):
            base = base.obj if isinstance(base, memoryview) else base.base
        if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
            base.madvise(mmap.MADV_DONTNEED)


@runtime_checkable
class Keeper(Protocol):
    """Keeps a run outside the memory that dies with its process.

    Attributes
    ----------
    kept
        Memory of the run that shall go on, as `keep` got it; None: it starts.
    """

    kept: Mapping[str, Array] | None

    def array(self, name: str, shape: tuple[int, ...], kind: str = "f8") -> NDArray[Any]:
        """Array for a part of the record, see `Storage`."""

    def due(self) -> bool:
        """Whether it is time to keep the run again; asked between its steps."""

    def keep(self, time: float, memory: Mapping[str, Array]) -> None:
        """Keep the record so far, and where the run stands at an instant [s]."""


def counted(statistics: Statistics, said: Sequence[str]) -> dict[str, Any]:
    """Work done and words said so far, as part of a memory."""
    return {"statistics": np.array(json.dumps([asdict(statistics), list(said)]))}


def recounted(memory: Mapping[str, Any]) -> tuple[Statistics, list[str]]:
    """Work and words from a memory."""
    numbers, said = json.loads(str(memory["statistics"]))
    return Statistics(**numbers), said
