"""Riccati equations: gains of linear-quadratic regulators and filters, in continuous and in discrete time.

SciPy solves the equations; what is checked here is that a solution stabilises, and what to say if there is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_continuous_are, solve_discrete_are

from tautflex.control.linear import LinearPlant
from tautflex.control.signals import labelled
from tautflex.errors import InputError
from tautflex.numeric import Array

# Parts below this are round-off.
_NONE = 1e-9


class Weights(NamedTuple):
    """Cost ``x'Q x + 2 x'N u + u'R u``."""

    Q: Array
    R: Array
    N: Array


class Gain(NamedTuple):
    """Gain of a regulator (input, state) or filter (state, output), and the solution of its Riccati equation."""

    gain: Array
    solution: Array


def bryson_weights(plant: LinearPlant, tolerances: Mapping[str, float], efforts: Mapping[str, float]) -> Weights:
    """Cost by Bryson's rule: the squares of outputs, or states, over their tolerances, of inputs over their efforts.

    Parameters
    ----------
    plant
        Linear plant.
    tolerances
        Label of an output or of a state, or name of a channel -> deviation that is as bad as another's.
    efforts
        Label of an input, or name of a channel -> size that is as bad, of every input.

    Raises
    ------
    InputError
        If a name is unknown, an input has no effort, or no linear column.
    """
    n, m = plant.B.shape
    given = labelled("tolerances", tolerances, [*plant.outputs, *plant.states])
    scale = np.array(list(given.values()))[:, None]
    rows = np.concatenate([plant.C, np.eye(n)])[list(given)] / scale
    through = np.concatenate([plant.D, np.zeros((n, m))])[list(given)] / scale
    for k, row in zip(given, np.concatenate([rows, through], axis=1), strict=True):
        if not row.any():
            raise InputError(
                f"tolerances: expected outputs that tell of the motion, got {plant.outputs[k]!r}, whose row of "
                "the linear model is zero; leave it out, or weigh another one"
            )
    sizes = labelled("efforts", efforts, plant.inputs)
    for k, label in enumerate(plant.inputs):
        if k not in sizes:
            raise InputError(f"efforts: expected a number for every command, got none for {label!r}; add it")
    require_columns(plant)
    r = np.diag([1.0 / sizes[k] ** 2 for k in range(m)])
    return Weights(rows.T @ rows, r + through.T @ through, rows.T @ through)


def require_columns(plant: LinearPlant) -> None:
    """Raise InputError if an input has no linear column: a linear law cannot use it."""
    for label in plant.inputs:
        if label not in plant.columns:
            why = plant.remarks.get(label, "no linear column")
            raise InputError(
                f"commands: expected inputs with a linear column for a linear law, got {label!r}: {why}; leave it out "
                "of the law's efforts"
            )


def regulator(plant: LinearPlant, weights: Weights) -> Gain:
    """Gain K of ``u = -K x`` that minimises the integral, or the sum, of a cost.

    Raises
    ------
    InputError
        If no gain stabilises the plant, or the cost does not see what is unstable.
    """
    a, b, (q, r, n) = plant.A, plant.B, weights
    try:
        x = _solution(a, b, q, r, n, plant.interval)
    except (LinAlgError, ValueError):
        raise _no_regulator(plant, q) from None
    moved = r if plant.interval is None else r + b.T @ x @ b
    k = np.asarray(np.linalg.solve(moved, (b.T @ x if plant.interval is None else b.T @ x @ a) + n.T), dtype=np.float64)
    if not stable(a - b @ k, plant.interval):
        raise _no_regulator(plant, q)
    return Gain(k, x)


def kalman_filter(plant: LinearPlant, process: Array, noise: Array) -> Gain:
    """Gain of the steady Kalman filter: of ``dx/dt = A x + L (y - C x)``, or of ``x + L (y - C x)`` at a sample.

    Parameters
    ----------
    plant
        Linear plant.
    process
        Covariance of what moves the state at random, per second or per step, shape (state, state).
    noise
        Covariance of the measurement's noise, shape (output, output).

    Raises
    ------
    InputError
        If the observer would not be stable: the outputs do not tell a motion that does not decay by itself.
    """
    a, c = plant.A, plant.C
    try:
        p = _solution(a.T, c.T, process, noise, np.zeros(c.T.shape), plant.interval)
    except (LinAlgError, ValueError):
        raise _no_observer(plant) from None
    told = noise if plant.interval is None else noise + c @ p @ c.T
    gain = np.asarray(np.linalg.solve(told, c @ p).T, dtype=np.float64)
    if not stable(a - gain @ c if plant.interval is None else a - a @ gain @ c, plant.interval):
        raise _no_observer(plant)
    return Gain(gain, p)


def _solution(a: Array, b: Array, q: Array, r: Array, n: Array, interval: float | None) -> Array:
    """Solution of a Riccati equation whose inputs are scaled to a unit cost: tiny ones ruin the reordering of poles."""
    scale = 1.0 / np.sqrt(np.diag(r))
    parts = a, b * scale, q, r * np.outer(scale, scale)
    solve = solve_continuous_are if interval is None else solve_discrete_are
    return np.asarray(solve(*parts, s=n * scale))


def stable(matrix: Array, interval: float | None) -> bool:
    """Whether a motion ``dx/dt = A x``, or ``x <- A x``, decays."""
    values = np.linalg.eigvals(matrix)
    return bool(np.all(values.real < 0.0) if interval is None else np.all(np.abs(values) < 1.0))


def _no_regulator(plant: LinearPlant, cost: Array) -> InputError:
    """No input moves, or the cost does not see, a motion that does not decay by itself."""
    reach, label = _least(plant, plant.A.T, plant.B.T)
    text = "inputs that move", "add an actuator that does"
    if reach > _NONE:
        _, label = _least(plant, plant.A, cost)
        text = "tolerances that see", "give its sensor or itself a tolerance"
    return InputError(
        f"regulator: expected {text[0]} every motion that does not decay by itself, got an unstable regulator, perhaps "
        f"for {label!r}; {text[1]}, or give the plant some damping"
    )


def _no_observer(plant: LinearPlant) -> InputError:
    """No measurement tells a motion that does not decay by itself."""
    _, label = _least(plant, plant.A, plant.C)
    return InputError(
        "observer: expected measurements that tell every motion that does not decay by itself, got an unstable "
        f"observer, perhaps for {label!r}; add a sensor of it, such as Attitude(), or give the plant some damping"
    )


def _least(plant: LinearPlant, a: Array, rows: Array) -> tuple[float, str]:
    """How much rows see of the motion that they see least among those that do not decay, and its largest state."""
    values, vectors = np.linalg.eig(a)
    lasting = values.real > -_NONE * np.abs(values).max() if plant.interval is None else np.abs(values) > 1.0 - _NONE
    seen = np.abs(rows @ vectors) / (np.linalg.norm(rows) or 1.0)
    worst = int(np.argmin(np.where(lasting, seen.max(axis=0, initial=0.0), np.inf)))
    return float(seen[:, worst].max(initial=0.0)), plant.states[int(np.argmax(np.abs(vectors[:, worst])))]
