"""What functions that write the results of a run ask of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tautflex.errors import InputError


@contextmanager
def results_of_a_run() -> Iterator[None]:
    """Make one InputError, also as a decorator, of a dataset whose variables are not those of a run."""
    try:
        yield
    except InputError:
        raise
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, MemoryError) as error:
        said = " ".join(str(error).split())[:200]
        text = f"dataset: expected the results of a run, got variables of other shapes or types ({said})"
        raise InputError(f"{text}; give run.data or a file written by tautflex run") from error
