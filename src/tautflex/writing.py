"""Files that are whole or not there: written aside, and moved into place when they are complete, alone or together.

Files that belong together move one after the other. What is left to move stands in a folder whose name says that it is
complete; should the process die between two of them, `finish` moves the others.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from tautflex.errors import NotWrittenError

_UNFINISHED, _COMPLETE = ".tautflex-part-", ".tautflex-commit-"
Result = TypeVar("Result")


@contextmanager
def written(target: Path) -> Iterator[Path]:
    """Place to write a file to, which takes the target's name at the end.

    Raises
    ------
    NotWrittenError
        If that cannot be written; what stood there is whole.
    """
    temporary = None
    try:
        target = _followed(target)
        temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex}.part")
        target.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        _settle(temporary)
        if target.exists():
            shutil.copymode(target, temporary)
        temporary.replace(target)
        _settle(target.parent)
    except OSError as error:
        text = f"path: expected a file that can be written, got {str(target)!r} ({_reason(error)})"
        raise NotWrittenError(f"{text}; choose another folder") from error
    finally:
        if temporary is not None:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)


@contextmanager
def written_together(directory: Path) -> Iterator[Path]:
    """Folder to write files to, which all move into ``directory`` at the end, or none does.

    Raises
    ------
    NotWrittenError
        If they cannot be written; what stood there is whole.
    """
    name = f"{os.getpid()}-{uuid.uuid4().hex[:12]}"
    place, complete = directory / f"{_UNFINISHED}{name}", directory / f"{_COMPLETE}{name}"
    made = [folder for folder in (directory, *directory.parents) if not folder.exists()]
    try:
        place.mkdir(parents=True)
        yield place
        for path in _files(place):
            _settle(path)
            target = directory / path.relative_to(place)
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.is_dir():
                raise IsADirectoryError(21, f"{target.name} is a directory")
        _settle(place)
        place.rename(complete)
        _settle(directory)
        _move(complete)
    except OSError as error:
        text = f"directory: expected a folder that can be written, got {str(directory)!r} ({_reason(error)})"
        raise NotWrittenError(f"{text}; what stood there is whole") from error
    finally:
        shutil.rmtree(place, ignore_errors=True)
        for folder in made:
            with suppress(OSError):  # not empty: the results are there
                folder.rmdir()


def finish(directory: Path) -> None:
    """Move what a process that died had completed, and remove what it had not."""
    for path in directory.glob(f"{_COMPLETE}*"):
        if not _alive(path.name.removeprefix(_COMPLETE)):
            _move(path)
    for path in directory.glob(f"{_UNFINISHED}*"):
        if not _alive(path.name.removeprefix(_UNFINISHED)):
            shutil.rmtree(path, ignore_errors=True)


def kept_elsewhere(error: NotWrittenError, name: str, write: Callable[[Path], object]) -> NotWrittenError:
    """Write to a new temporary folder what could not be written where it was to go; the error that tells of both."""
    folder = None
    try:
        folder = Path(tempfile.mkdtemp(prefix=f"tautflex-{name}-"))
        write(folder)
    except (OSError, NotWrittenError) as other:
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
        return NotWrittenError(f"{error}; nor could this result be kept elsewhere ({_reason(other)})")
    return NotWrittenError(f"{error}; this result is kept in {folder}")


def write_text(target: Path, text: str) -> Path:
    """Write a file of text, whole or not at all."""
    with written(target) as place:
        place.write_text(text, encoding="utf-8")
    return target


def write_or_keep(target: Path, write: Callable[[Path], Result]) -> Result:
    """Write a file by a function of its path that is whole or nothing; where that fails, elsewhere, and raise."""
    try:
        return write(target)
    except NotWrittenError as error:
        raise kept_elsewhere(error, target.stem, lambda folder: write(folder / target.name)) from None


def _followed(target: Path) -> Path:
    """The file that a link names."""
    if target.is_symlink() and not target.exists():
        raise FileNotFoundError(2, f"a link to {os.readlink(target)}, which does not exist")
    return target.resolve() if target.is_symlink() else target


def _move(complete: Path) -> None:
    for path in _files(complete):
        target = complete.parent / path.relative_to(complete)
        target.parent.mkdir(parents=True, exist_ok=True)
        path.replace(target)
        _settle(target.parent)
    shutil.rmtree(complete, ignore_errors=True)


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if not path.is_dir())


def _settle(path: Path) -> None:
    """Bring a file, or the names in a folder, to the disk."""
    if path.is_dir() and os.name != "posix":
        return
    descriptor = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _alive(name: str) -> bool:
    """Whether the process is there whose number a name begins with."""
    if os.name != "posix":
        return True
    try:
        os.kill(int(name.partition("-")[0]), 0)
    except (ValueError, ProcessLookupError):
        return False
    except OSError:
        return True
    return True


def _reason(error: Exception) -> str:
    return (isinstance(error, OSError) and error.strerror) or str(error)
