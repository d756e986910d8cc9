"""Processes that compile beside a command which finds no compiled code: on other cores, what it is going to need.

``data/compiled.jsonl`` lists what the commands call of a case of the template m2, longest first within a command
(`tools/compiled.py` writes it). Whoever compiles a function holds a lock of its name, so that nobody else does the same
meanwhile; locks go with their process, however that ends. Code comes from the files of the cache, and is the same
whoever made it.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import select
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import IO, Any, NamedTuple

from tautflex.errors import InputError

try:
    import fcntl
except ImportError:  # Windows has no locks of this kind: the command compiles alone
    fcntl = None  # type: ignore[assignment]

SWITCH = "TAUTFLEX_COMPILERS"
"""Environment variable: how many processes compile beside a command, 0 for none."""
MOST = 3
"""As many at most where it is not set, one on each other core."""
LIST = Path(__file__).parent / "data" / "compiled.jsonl"


class Function(NamedTuple):
    """A compiled function of the list: which command (0, 1, ...) needs it first, where it is, types of arguments."""

    command: int
    module: str
    name: str
    types: tuple[Any, ...]


class _Crew:
    """Locks that this process shares with others, and those of them that it started."""

    def __init__(self, locks: IO[bytes]) -> None:
        self.locks = locks
        self.held: list[str] = []
        self.others: list[subprocess.Popen[bytes]] = []

    def lock(self, how: int, name: str) -> None:
        place = int.from_bytes(hashlib.sha256(name.encode()).digest()[:7])
        fcntl.lockf(self.locks.fileno(), how, 1, place)

    def take(self, name: str, *, wait: bool) -> bool:
        """Whether this process may compile a function now, or look for what another one made of it."""
        if name in self.held:
            return True
        try:
            self.lock(fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB, name)
        except OSError:  # another one has it
            return False
        self.held.append(name)
        return True

    def drop(self, name: str) -> None:
        if name in self.held:
            self.held.remove(name)
            self.lock(fcntl.LOCK_UN, name)


_crew: _Crew | None = None
_wanted: tuple[int, int] | None = None  # process that may start others, and how many
_saving = threading.Lock()


@contextlib.contextmanager
def helped() -> Iterator[None]:
    """Let others compile beside what is done inside, until it has ended."""
    global _crew, _wanted
    _wanted = os.getpid(), _count()
    try:
        yield
    finally:
        _wanted, crew, _crew = None, _crew, None
        if crew is not None:
            _end(crew)


def saving() -> contextlib.AbstractContextManager[object]:
    """Keep this process from ending by itself while it writes a file of the cache."""
    return _saving


def seek(name: str, module: str, function: str, types: tuple[Any, ...]) -> bool:
    """Tell that a function is missing in the cache; True if another process may have added it meanwhile.

    Until `found` this process has the function for itself.
    """
    global _crew, _wanted
    if _wanted is None and _crew is None:
        return False
    command = next((each.command for each in listed() if each[1:] == (module, function, types)), -1)
    if _wanted is not None and _wanted[0] == os.getpid() and command >= 0:
        (_, count), _wanted = _wanted, None  # once
        _crew = _start(count)
    if _crew is None:
        return False
    if not _crew.held:  # who holds nothing may do something else while another one is at it
        while not _crew.take(name, wait=False):
            if not _one_of(command):
                break
        else:
            return True
    _crew.take(name, wait=True)
    return True


def found(name: str) -> None:
    """Tell that a function is compiled and in the cache, or cannot be."""
    if _crew is not None:
        _crew.drop(name)


def work(number: int, place: str) -> None:
    """Compile what is listed and nobody else is at, until the process that started this one ends or says so."""
    global _crew, LIST
    LIST = Path(place)
    parent = os.getppid()

    def leave_with_it() -> None:
        while not select.select([sys.stdin], [], [], 1.0)[0] and os.getppid() == parent:
            pass
        with _saving:
            os._exit(0)

    threading.Thread(target=leave_with_it, daemon=True).start()
    _crew = _Crew(os.fdopen(number, "r+b"))
    while _one_of(max(each.command for each in listed())):
        pass
    os._exit(0)  # nothing is left to be written or told


@cache
def _rest() -> list[Function]:
    return list(listed())


def _one_of(command: int) -> bool:
    """Compile the first listed function for this command or one before it that nobody is at; False if there is none."""
    while (each := next((each for each in _rest() if each.command <= command), None)) is not None:
        _rest().remove(each)
        with contextlib.suppress(Exception):  # what is needed and cannot be compiled says so to whoever needs it
            if getattr(import_module(each.module), each.name).compile_if_free(each.types):
                return True
    return False


def free(name: str) -> bool:
    """Whether nobody else is at a function; then this process has it for itself until `found`."""
    return _crew is not None and _crew.take(name, wait=False)


@cache
def listed() -> list[Function]:
    """Functions that the commands compile."""
    rows = (json.loads(line) for line in LIST.read_text(encoding="utf-8").splitlines())
    return [Function(command, module, name, tuple(map(_type, types))) for command, module, name, types in rows]


def _type(written: Any) -> Any:
    from numba.core import types

    if isinstance(written, list):
        return types.BaseTuple.from_types(tuple(map(_type, written)))  # type: ignore[no-untyped-call]
    name, _, dimensions = written.partition(":")
    scalar = types.boolean if name == "bool" else getattr(types, name)
    return types.Array(scalar, int(dimensions), "C") if dimensions else scalar


def written(numba_type: Any) -> Any:
    """A type as the list has it; ValueError for one that it has no words for."""
    from numba.core import types

    if isinstance(numba_type, types.BaseTuple):
        text: Any = [written(each) for each in numba_type]  # type: ignore[attr-defined]
    elif isinstance(numba_type, types.Array):
        text = f"{numba_type.dtype.name}:{numba_type.ndim}"
    else:
        text = numba_type.name
    if _type(text) != numba_type:
        raise ValueError(f"{numba_type}: expected a number, none, an array in order of C or a tuple of such")
    return text


def _count() -> int:
    """How many processes compile beside this one."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    given = os.environ.get(SWITCH, "")
    if given and not given.isdecimal():
        raise InputError(f"{SWITCH}: expected a number of processes, got {given!r}; 0 compiles in one alone")
    return int(given) if given else min(cores - 1, MOST)


def _start(count: int) -> _Crew | None:
    if fcntl is None or count < 1 or not sys.executable:
        return None
    from numba import config

    program = f"import sys; sys.path[:] = {sys.path!r}; from tautflex.compilers import work; work({{}}, {str(LIST)!r})"
    environment = os.environ | {SWITCH: "0"}
    if config.CACHE_DIR:  # type: ignore[attr-defined]
        environment["NUMBA_CACHE_DIR"] = config.CACHE_DIR  # type: ignore[attr-defined]
    crew = None
    with contextlib.suppress(OSError):  # without help it takes longer
        crew = _Crew(tempfile.TemporaryFile())  # noqa: SIM115 - as long as the command
        number = crew.locks.fileno()
        for _ in range(count):
            crew.others.append(
                subprocess.Popen(
                    [sys.executable, "-c", program.format(number)],
                    env=environment,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    pass_fds=[number],
                    start_new_session=True,  # Ctrl-C is for the command
                )
            )
    return crew


def _end(crew: _Crew) -> None:
    for each in crew.others:
        with contextlib.suppress(OSError):
            each.stdin.close()  # type: ignore[union-attr]
    try:
        for each in crew.others:
            each.wait(timeout=5.0)
    except subprocess.TimeoutExpired:
        pass
    finally:
        for each in crew.others:
            each.kill()
            each.wait()
        crew.locks.close()
