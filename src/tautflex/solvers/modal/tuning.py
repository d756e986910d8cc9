"""Cable tensions that put chosen natural frequencies on target [theory.md 5]."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.numeric import Array
from tautflex.solvers.modal.natural import solve_modes
from tautflex.solvers.static.prestress import PrestressedState, solve_prestress
from tautflex.structure.model import Model
from tautflex.text import brief


@dataclass(frozen=True)
class TuneResult:
    """Tuned tensions.

    Parameters
    ----------
    scale_x, scale_y
        Factors on the prestress along x and y.
    frequencies
        First natural frequencies of the tuned structure [Hz].
    state
        The tuned prestressed state.
    """

    scale_x: float
    scale_y: float
    frequencies: Array
    state: PrestressedState
    __repr__ = brief


def tune_pretension(
    model: Model,
    frequencies: Sequence[float],
    modes: Sequence[int] | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 30,
) -> TuneResult:
    """Scale the prestress until chosen natural frequencies hit their targets.

    Parameters
    ----------
    model
        Structure with a first guess of its tensions.
    frequencies
        One target scales x and y together; two targets scale them separately [Hz], > 0.
    modes
        Mode number (from 1) of each target; default 1, then 2.
    tolerance
        Allowed relative error of the frequencies.
    max_iterations
        Allowed Newton steps.

    Returns
    -------
    TuneResult

    Raises
    ------
    InputError
        If the targets are not one or two positive frequencies, or modes do not match them.
    NotConvergedError
        If no tensions reach the targets.

    Notes
    -----
    Squared frequencies are nearly linear in the tensions, so Newton's method in the logarithms of frequency squared
    and scale, with a difference Jacobian, needs a few steps.
    """
    checks.instance("model", model, Model, "a Model", remedy="build_model(case) and Model.from_mesh(...) give one")
    targets = checks.float_array("frequencies", frequencies, (None,))
    if targets.size not in (1, 2):
        raise InputError(f"frequencies: expected one or two targets, got {targets.size}")
    for target in targets.tolist():
        checks.positive("frequencies", target)
    checks.positive("tolerance", tolerance)
    checks.whole("max_iterations", max_iterations, 1)
    given = range(1, targets.size + 1) if modes is None else checks.several("modes", modes, int, "1")
    numbers = [checks.whole("modes", number, 1) for number in given]
    if len(numbers) != targets.size or len(set(numbers)) != len(numbers):
        raise InputError(f"modes: expected {targets.size} different mode number(s) from 1, got {numbers}")
    count = max(10, *numbers)

    def evaluate(logs: Array) -> tuple[Array, TuneResult]:
        scale = np.exp(np.broadcast_to(logs, 2))
        state = solve_prestress(model.with_pretension_scaled(*scale))
        found = solve_modes(state, min(count, state.system.size - 1)).frequencies
        if max(numbers) > len(found):
            raise InputError(f"modes: expected mode numbers up to {len(found)}, got {max(numbers)}; refine the mesh")
        error = 2.0 * np.log(found[np.array(numbers) - 1] / targets)
        return error, TuneResult(float(scale[0]), float(scale[1]), found[:10], state)

    logs = np.zeros(targets.size)
    error, result = evaluate(logs)
    for _ in range(max_iterations):
        if float(np.abs(error).max()) <= 2.0 * tolerance:
            return result
        slopes = np.column_stack(
            [(evaluate(logs + 1e-4 * column)[0] - error) / 1e-4 for column in np.eye(targets.size)]
        )
        change = np.linalg.lstsq(slopes, -error, rcond=None)[0]
        logs, error, result = _damped(evaluate, logs, np.clip(change, -2.0, 2.0), error)
    raise NotConvergedError(
        f"tune: frequencies {result.frequencies[np.array(numbers) - 1].round(6).tolist()} Hz after {max_iterations} "
        f"steps, target {targets.tolist()} Hz; frame modes do not follow the tension: choose film modes or one target"
    )


def _damped(
    evaluate: Callable[[Array], tuple[Array, TuneResult]], logs: Array, change: Array, error: Array
) -> tuple[Array, Array, TuneResult]:
    """Halve the step until the error falls (modes may change places on the way)."""
    for _ in range(6):
        new_error, result = evaluate(logs + change)
        if float(np.abs(new_error).max()) < float(np.abs(error).max()):
            break
        change = 0.5 * change
    return logs + change, new_error, result
