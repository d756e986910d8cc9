"""Exception tree of tautflex; the library raises nothing else on bad input and never asserts on it."""

from __future__ import annotations

from typing import Any, Self


class TautflexError(Exception):
    """Base class of every error that tautflex raises on purpose."""


class InputError(TautflexError, ValueError):
    """An argument, a case file or a mesh is unusable; the message says what was expected and what to try.

    Parameters
    ----------
    problems
        What is wrong, one line each; several are independent of each other.
    """

    def __init__(self, *problems: str) -> None:
        super().__init__("\n".join(problems))
        self.problems = problems

    def behind(self, place: str) -> Self:
        """The same error with a place in front of every line."""
        return type(self)(*(f"{place}{problem}" for problem in self.problems))


class CaseError(InputError):
    """A case file or one of its keys is wrong."""


class MeshError(InputError):
    """A mesh is degenerate, disconnected or points at nodes that do not exist."""


class PrestressError(InputError):
    """A prestressed state is singular, compressed, slack or unstable."""


class UnsupportedError(InputError):
    """A structure can move as a rigid body where the question asked needs it to be held."""


class NotWrittenError(InputError):
    """A file or folder could not be written, for want of space, permission or a folder; what stood there is whole."""


class MissingExtraError(TautflexError, ImportError):
    """An optional dependency is not installed; the message names the extra that brings it."""


class NotConvergedError(TautflexError, RuntimeError):
    """An iteration failed for good.

    Parameters
    ----------
    message
        What failed, where, and what to try.
    result
        The readable partial result reached before the failure, or None.
    history
        Residual norms [N] of the failed iteration, newest last.
    """

    def __init__(self, message: str, result: Any = None, history: tuple[float, ...] = ()) -> None:
        super().__init__(message)
        self.result = result
        self.history = history


class UnstableWarning(UserWarning):
    """An equilibrium was found, but small motion leaves it."""
