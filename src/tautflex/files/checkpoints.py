"""Checkpoints: a run under way, kept in a folder from which it goes on to the bit after a kill.

The record grows in files that are mapped into memory, so that it takes none of the run's own; what steps leave for the
next one is written beside them from time to time, whole or not at all.
"""

from __future__ import annotations

import json
import math
import mmap
import os
import shutil
import time as clock
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import CaseError, NotWrittenError
from tautflex.files import netcdf
from tautflex.numeric import Array
from tautflex.solvers.transient.restart.keeper import let_go
from tautflex.solvers.transient.status import Run
from tautflex.writing import written

FOLDER = ".tautflex-checkpoint"
_STATE = "state.npz"
_LET_GO = 1.0  # seconds after which memory of the record is given back


class RunFolder:
    """Keeper of a run, see `tautflex.solvers.transient.restart.keeper`; what cannot be written is told, not raised.

    Parameters
    ----------
    folder
        Where the files are; what another run left there goes, unless this one is to ``resume`` it.
    owner
        What the run is recognised by: words by name, as JSON.
    seconds
        Wall-clock time between two checkpoints [s].
    resume
        Whether to go on, if there is something to go on from.

    Attributes
    ----------
    kept
        Memory to go on from, or None.
    resumed_from
        Its instant [s]; 0: from the start.
    trouble
        Why no checkpoints are written; empty if they are.
    """

    def __init__(self, folder: Path, owner: str, seconds: float, resume: bool) -> None:
        self._folder, self._owner, self._seconds = folder, owner, seconds
        self.kept: Mapping[str, Array] | None = None
        self.resumed_from, self.trouble = 0.0, ""
        self._maps = list[mmap.mmap]()
        if resume and self.state.exists():
            self._open()
        else:
            self.remove()
        self._last = self._let_go = clock.monotonic()

    @property
    def state(self) -> Path:
        """File that is there as soon as there is something to go on from."""
        return self._folder / _STATE

    def array(self, name: str, shape: tuple[int, ...], kind: str = "f8") -> NDArray[Any]:
        """Array in a file, whose room is taken at once: a full disk is met here or never."""
        size = math.prod(shape) * np.dtype(kind).itemsize
        if not size or self.trouble:
            return np.zeros(shape, dtype=kind)
        try:
            return np.frombuffer(self._mapped(self._folder / f"{name}.bin", size), dtype=kind).reshape(shape)
        except OSError as error:
            if self.kept is not None:
                raise CaseError(f"{self._folder}: cannot go on from this checkpoint ({error}); use --force") from None
            self.trouble = f"no checkpoints could be written ({error.strerror}): a run that is killed is lost"
            return np.zeros(shape, dtype=kind)

    def due(self) -> bool:
        """Whether the time between two checkpoints is over; memory of the record is given back meanwhile."""
        now = clock.monotonic()
        if now - self._let_go >= _LET_GO:
            self._let_go = now
            let_go(*self._maps)
        return not self.trouble and now - self._last >= self._seconds

    def keep(self, time: float, memory: Mapping[str, Array]) -> None:
        """Bring the record to the disk, then the memory."""
        if self.trouble:
            return
        arrays: dict[str, Any] = dict(memory)
        try:
            for each in self._maps:
                each.flush()
            let_go(*self._maps)
            if not self._folder.exists():
                raise FileNotFoundError(2, "the folder was removed")
            with written(self.state) as place, place.open("wb") as file:
                np.savez(file, owner=np.array(self._owner), instant=np.array(time), **arrays)
        except (OSError, NotWrittenError) as error:
            self.trouble = f"the last checkpoint is of an earlier instant, later ones could not be written ({error})"
        self._last = clock.monotonic()

    def remove(self) -> None:
        """Remove all files."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _open(self) -> None:
        try:
            with self.state.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
                kept = {name: arrays[name] for name in arrays.files}
            owner, instant = json.loads(str(kept.pop("owner"))), float(kept.pop("instant"))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            text = f"{self._folder}: expected a checkpoint to go on from, got a damaged one ({error})"
            raise CaseError(f"{text}; start anew with --force") from None
        differ = [name for name, words in json.loads(self._owner).items() if owner.get(name) != words]
        if differ:
            text = f"{self._folder}: expected a checkpoint of this case, got one of another {' and '.join(differ)}"
            raise CaseError(f"{text}; give what it belongs to, or start anew with --force")
        self.kept, self.resumed_from = kept, instant

    def _mapped(self, path: Path, size: int) -> mmap.mmap:
        if self.kept is None:
            path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("w+b" if self.kept is None else "r+b") as file:
            if self.kept is not None:
                if os.fstat(file.fileno()).st_size != size:
                    raise OSError(22, f"{path.name} has another size")
            elif hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.truncate(size)
            self._maps.append(mmap.mmap(file.fileno(), size))
        return self._maps[-1]


class LoopFolder(RunFolder):
    """Keeper of a closed loop, see `tautflex.control.loop.LoopKeeper`: the runs of its plant are files of their own."""

    @property
    def runs(self) -> list[Run]:
        """Runs that the kept loop is made of."""
        return [netcdf.load_run(self._run(number)) for number in range(int((self.kept or {})["runs"]))]

    def keep_loop(self, time: float, runs: Sequence[Run], memory: Mapping[str, Array]) -> None:
        """Write the runs that are not there yet, then the memory."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            for number, run in enumerate(runs):
                if not self._run(number).exists():
                    netcdf.save(run, self._run(number))
        except (OSError, NotWrittenError) as error:
            self.trouble = f"the last checkpoint is of an earlier instant, later ones could not be written ({error})"
        self.keep(time, {**memory, "runs": np.array(len(runs))})

    def _run(self, number: int) -> Path:
        return self._folder / f"run-{number}.nc"


Folder = TypeVar("Folder", bound=RunFolder)


@contextmanager
def run_folder(
    kind: type[Folder], folder: Path, owner: Mapping[str, str], seconds: float, resume: bool
) -> Iterator[Folder]:
    """Keeper of a run, of this kind, in a folder; without a state to go on from nothing of it stays."""
    keeper = kind(folder, json.dumps(dict(owner)), seconds, resume)
    try:
        yield keeper
    finally:
        if not keeper.state.exists():
            keeper.remove()
