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
    rows = np.concatenate([plant.C, np.eye(n)])[list(given)]
    through = np.concatenate([plant.D, np.zeros((n, m))])[list(given)]
    scale = np.array(list(given.values()))[:, None] ** 2
    sizes = labelled("efforts", efforts, plant.inputs)
    for k, label in enumerate(plant.inputs):
        if k not in sizes:
            raise InputError(f"efforts: expected a number for every command, got none for {label!r}; add it")
    require_columns(plant)
    r = np.diag([1.0 / sizes[k] ** 2 for k in range(m)])
    return Weights(rows.T @ (rows / scale), r + through.T @ (through / scale), rows.T @ (through / scale))


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
        if plant.interval is None:
            x = solve_continuous_are(a, b, q, r, s=n)
            k = np.linalg.solve(r, b.T @ x + n.T)
        else:
            x = solve_discrete_are(a, b, q, r, s=n)
            k = np.linalg.solve(r + b.T @ x @ b, b.T @ x @ a + n.T)
    except (LinAlgError, ValueError):
        raise _unstable("regulator", plant, "inputs that move and tolerances that see") from None
    if not stable(a - b @ k, plant.interval):
        raise _unstable("regulator", plant, "inputs that move and tolerances that see")
    return Gain(np.asarray(k, dtype=np.float64), np.asarray(x, dtype=np.float64))


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
        if plant.interval is None:
            p = solve_continuous_are(a.T, c.T, process, noise)
            gain = np.linalg.solve(noise, c @ p).T
        else:
            p = solve_discrete_are(a.T, c.T, process, noise)
            gain = np.linalg.solve(noise + c @ p @ c.T, c @ p).T
    except (LinAlgError, ValueError):
        raise _unstable("observer", plant, "measurements that tell") from None
    if not stable(a - gain @ c if plant.interval is None else a - a @ gain @ c, plant.interval):
        raise _unstable("observer", plant, "measurements that tell")
    return Gain(np.asarray(gain, dtype=np.float64), np.asarray(p, dtype=np.float64))


def stable(matrix: Array, interval: float | None) -> bool:
    """Whether a motion ``dx/dt = A x``, or ``x <- A x``, decays."""
    values = np.linalg.eigvals(matrix)
    return bool(np.all(values.real < 0.0) if interval is None else np.all(np.abs(values) < 1.0))


def _unstable(what: str, plant: LinearPlant, need: str) -> InputError:
    """What is missing, and the state that takes most part in the least known of the motions that do not decay."""
    observed = what == "observer"
    values, vectors = np.linalg.eig(plant.A if observed else plant.A.T)
    lasting = values.real > -1e-9 * np.abs(values).max() if plant.interval is None else np.abs(values) > 1.0 - 1e-9
    reach = np.abs((plant.C if observed else plant.B.T) @ vectors).max(axis=0, initial=0.0)
    label = plant.states[int(np.argmax(np.abs(vectors[:, int(np.argmin(np.where(lasting, reach, np.inf)))])))]
    remedy = "add a sensor of it, such as Attitude()" if observed else "add an actuator that moves it, or a tolerance"
    return InputError(
        f"{what}: expected {need} every motion that does not decay by itself, got an unstable {what}, perhaps for "
        f"{label!r}; {remedy}, or give the plant some damping"
    )
