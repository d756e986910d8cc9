"""Ctrl-C and the signals that end a process: noted while a run is under way, and met between two of its steps.

An exception that a signal's handler raises inside compiled code loses the run; where C code calls Python back, as from
weak references and the garbage collector, it is dropped, and LLVM, which gets code from a cache that way, crashes
without it.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

_noted: list[int] = []
_met: list[int] = []
_deferring: list[bool] = []
_CALLED_BACK = "llvmlite", "threadpoolctl", "weakref"
_AFTER_COLLECTION = "jax._src.lib"  # module whose function the garbage collector calls
_SOON = 0.02  # [s]
_ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


@contextmanager
def listening(numbers: Sequence[int] = _ENDING) -> Iterator[None]:
    """End what is done inside by KeyboardInterrupt at any of these signals that is not ignored."""
    before = {}
    if _in_main_thread():
        before = {number: signal.getsignal(number) for number in numbers}
        before = {number: handler for number, handler in before.items() if handler not in (signal.SIG_IGN, None)}
    for number in before:
        signal.signal(number, _note)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _noted.clear()
        _met.clear()


@contextmanager
def deferred() -> Iterator[None]:
    """Let the first signal inside wait for `meet`; a second one does not wait.

    A program that does not listen to signals gets Ctrl-C deferred alone. Signals reach the main thread, other ones have
    nothing to defer.
    """
    if not _in_main_thread():
        yield
        return
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler and not _deferring:
        with listening([signal.SIGINT]), deferred():
            yield
        return
    _deferring.append(True)
    try:
        yield
    finally:
        _deferring.pop()


def meet() -> None:
    """Raise KeyboardInterrupt if a signal waits."""
    if len(_noted) > len(_met) and _in_main_thread():
        _met[:] = _noted
        raise KeyboardInterrupt


def exit_code() -> int:
    """Code of a process that a signal ended, 0 if none did."""
    return 128 + _noted[0] if _noted else 0


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _note(number: int, frame: FrameType | None) -> None:
    waits = _deferring and not _noted
    if not waits and _called_back(frame):
        threading.Timer(_SOON, signal.raise_signal, [number]).start()
        return
    _noted.append(number)
    if not waits:
        _met[:] = _noted
        raise KeyboardInterrupt


def _called_back(frame: FrameType | None) -> bool:
    """Whether C code may be waiting for a frame or one of those that called it."""
    while frame is not None:
        name = str(frame.f_globals.get("__name__"))
        if name.partition(".")[0] in _CALLED_BACK or name == _AFTER_COLLECTION:
            return True
        frame = frame.f_back
    return False
