"""Folders and files of results: one command at a time writes to one, all of its files or none."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TypeVar

from tautflex.errors import CaseError, NotWrittenError
from tautflex.writing import finish, kept_elsewhere, written_together

if sys.platform != "win32":  # there commands are not kept apart; every file is whole all the same
    import fcntl

Result = TypeVar("Result")
_LOCK = ".tautflex.lock"


@contextmanager
def result_folder(directory: Path) -> Iterator[None]:
    """Keep a folder, made if missing, to this process; what one that died had left to move is moved first.

    A folder that stays empty goes again.

    Raises
    ------
    CaseError
        If another process has it, or it cannot be made.
    """
    with _held(directory, directory / _LOCK, "folder"):
        try:
            finish(directory)
        except OSError as error:
            raise _unwritable(directory, error) from None
        yield


@contextmanager
def result_file(path: Path, kind: str = "file") -> Iterator[None]:
    """Keep a file, or a folder of this kind that comes and goes, to this process; its own folder is made if missing.

    Raises
    ------
    CaseError
        If another process has it, or its folder cannot be made.
    """
    with _held(path, path.with_name(f".{path.name}.lock"), kind):
        yield


@contextmanager
def _held(place: Path, mark: Path, kind: str) -> Iterator[None]:
    """Hold the lock on a place; folders that were made for it and stay empty go again."""
    made = [folder for folder in (mark.parent, *mark.parent.parents) if not folder.exists()]
    try:
        try:
            lock = _locked(place, mark, kind)
        except OSError as error:
            raise _unwritable(place, error) from None
        try:
            yield
        finally:
            if lock is not None:
                with suppress(OSError):
                    mark.unlink()
                lock.close()
    finally:
        for folder in made:
            with suppress(OSError):  # not empty
                folder.rmdir()


def publish(directory: Path, write: Callable[[Path, Path], Result]) -> Result:
    """Write files into a folder, all or none.

    Parameters
    ----------
    directory
        The folder, made if missing.
    write
        Called with the folder to write to and the one in which its files will stand.

    Raises
    ------
    NotWrittenError
        If that fails. What stood there is whole; the message tells in which new folder the files are instead.
    """
    try:
        with written_together(directory) as place:
            return write(place, directory)
    except NotWrittenError as error:
        raise kept_elsewhere(error, directory.name, lambda folder: write(folder, folder)) from None


def _unwritable(place: Path, error: OSError) -> CaseError:
    return CaseError(f"{place}: cannot write there ({error.strerror}); choose another with -o")


def _locked(place: Path, mark: Path, kind: str) -> IO[bytes] | None:
    """Lock on a place, which its process holds until it ends, however it does; None where there are no locks."""
    while True:
        mark.parent.mkdir(parents=True, exist_ok=True)
        if sys.platform == "win32":
            return None
        try:
            file = mark.open("a+b", buffering=0)  # what a full disk does not take must not be tried again at the end
        except OSError:
            if not mark.parent.exists():
                continue  # it went with a process that left it empty
            return None  # no room even for a name: the results will say so
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not mark.exists() or os.fstat(file.fileno()).st_ino != mark.stat().st_ino:
                file.close()  # of a process that was just about to leave
                continue
            file.truncate(0)
            file.write(b"%d" % os.getpid())
        except BlockingIOError:
            file.seek(0)
            holder = file.read().decode(errors="replace") or "?"
            file.close()
            text = f"{place}: expected a {kind} that no other command writes to, got that of process {holder}"
            raise CaseError(f"{text}; wait for it, or choose another with -o") from None
        except OSError:
            pass  # a file system without locks, or without room for a number
        return file
