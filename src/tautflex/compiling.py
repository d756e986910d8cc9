"""Compiled code: where it is kept if neither the package nor the user's folder can be written, and who is told."""

from __future__ import annotations

import os
import stat
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

announcing = False
"""Whether compiling that takes a while, and another place for its code, are told on stderr; commands want that."""
announced = False
"""Whether it has been told that compilation takes a while."""
patience = 3.0
"""Time that this process spends compiling before it says so [s]."""


def tell(text: str) -> None:
    """Say something on stderr, if that is wanted."""
    if announcing and sys.stderr is not None:
        print(f"tautflex: {text}", file=sys.stderr, flush=True)  # noqa: T201 - a line for whoever waits


def say(progress: Callable[[float, str], Any] | None, text: str) -> None:
    """Tell whoever follows that something begins, or the standard error of a command that no terminal follows."""
    if progress is None:
        tell(text)
    else:
        progress(0.0, text)


@cache
def watch() -> None:
    """Tell once that functions are compiled, when that takes a while."""
    from numba.core import event

    class Clock(event.Listener):
        def __init__(self) -> None:
            self.depth, self.began, self.spent = 0, 0.0, 0.0
            self.alarm: threading.Timer | None = None

        def on_start(self, event: Any) -> None:
            self.depth += 1  # a function may ask for others that are not compiled either
            if self.depth == 1 and announcing and not announced:
                self.began = time.perf_counter()
                self.alarm = threading.Timer(max(patience - self.spent, 0.0), _announce)
                self.alarm.daemon = True
                self.alarm.start()

        def on_end(self, event: Any) -> None:
            self.depth -= 1
            if self.depth == 0 and self.alarm is not None:
                self.alarm.cancel()
                self.alarm = None
                self.spent += time.perf_counter() - self.began

    event.register("numba:compile", Clock())  # type: ignore[no-untyped-call]


def _announce() -> None:
    global announced
    if not announced:
        announced = True
        tell("compiling what is used here for the first time; later runs find it compiled ...")


def user_place(name: str) -> str | None:
    """Folder for compiled code among this user's caches (`XDG_CACHE_HOME`, ~/.cache); None if none can be written."""
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        place = Path(home) / "tautflex" / name
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=place).close()
    except (OSError, RuntimeError):  # no home
        return None
    return str(place)


@cache
def temporary_place() -> str:
    """Folder of this user's own for compiled code, among the temporary ones; "" if there is none."""
    user = os.getuid() if hasattr(os, "getuid") else "own"
    place = Path(tempfile.gettempdir()) / f"tautflex-compiled-{user}"
    try:
        place.mkdir(mode=0o700, exist_ok=True)
        found = place.lstat()
        # Code is run from there: nobody else may have made it, or write to it.
        if not stat.S_ISDIR(found.st_mode) or found.st_mode & 0o022 or (user != "own" and found.st_uid != user):
            place = Path(tempfile.mkdtemp(prefix="tautflex-compiled-"))
        tempfile.TemporaryFile(dir=place).close()
    except OSError:
        tell("compiled code cannot be kept anywhere: every process compiles anew; set NUMBA_CACHE_DIR")
        return ""
    tell(f"compiled code is kept in {place}; neither the package's folder nor a user's can be written")
    return str(place)
