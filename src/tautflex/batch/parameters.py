"""Parameters of a batch: names, checks and the number of runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.batch.equations.rate_history import RateHistory
from tautflex.errors import InputError
from tautflex.numeric import Array

# Factors of the state; kinds of element and numbers of damping and maneuver are added.
_FACTORS = ("tension_x", "tension_y")
_BY_KIND = ("youngs_modulus", "density")


def check_names(
    names: Mapping[str, Any], kinds: tuple[str, ...], history: RateHistory, damping: Mapping[str, Any]
) -> None:
    """Raise InputError on a name that nothing answers to."""
    factors = *_FACTORS, *(f"{name}.{kind}" for name in _BY_KIND for kind in kinds)
    known = *factors, *damping, *history.numbers
    for name in names:
        if name not in known:
            raise InputError(f"parameters: expected names among {', '.join(known)}, got {name!r}")


def checked_numbers(
    given: Mapping[str, ArrayLike], kinds: tuple[str, ...], history: RateHistory, damping: Mapping[str, Any]
) -> tuple[dict[str, Array], dict[str, int | None], int]:
    """Parameters as arrays, which axis of each counts the runs (0, or None), and the number of runs.

    ``damping`` has the default numbers of the damping. Its range, and that of the maneuver's, is not looked at here.
    InputError if a name is unknown, a factor is out of range, or lengths disagree.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"parameters: expected a mapping such as {{'tension_x': [0.9, 1.0]}}, got {given!r}")
    check_names(given, kinds, history, damping)
    own = {**damping, **history.numbers}
    arrays, axes, runs = {}, {}, 1
    for name, value in given.items():
        array = checks.numbers(f"parameters: {name!r}", value)
        alone = np.ndim(own.get(name, 0.0))
        if array.ndim not in (alone, alone + 1) or not np.all(np.isfinite(array)):
            raise InputError(
                f"parameters: expected {name!r} as finite numbers, one or one per run, got shape {array.shape}"
            )
        if name not in own and np.any(array <= 0.0):
            kind = "> 0 (a factor of the state that was given)"
            raise InputError(f"parameters: expected {name!r} {kind}, got {float(array.min())!r}")
        arrays[name], axes[name] = array, (0 if array.ndim > alone else None)
        if axes[name] == 0:
            if runs not in (1, len(array)) or not len(array):
                raise InputError(f"parameters: expected {name!r} for {runs} runs, got {len(array)} values")
            runs = len(array)
    return arrays, axes, runs


def each_row(
    prefix: str, arrays: Mapping[str, Array], axes: Mapping[str, int | None], runs: int
) -> Iterator[dict[str, Any]]:
    """Parameters of a section run by run, without its prefix: once if all runs share them, never if there are none."""
    own = {name: axes[name] == 0 for name in arrays if name.startswith(prefix)}
    for run in range(runs if any(own.values()) else min(1, len(own))):
        yield {
            name.removeprefix(prefix): (arrays[name][run] if differs else arrays[name]).tolist()
            for name, differs in own.items()
        }
