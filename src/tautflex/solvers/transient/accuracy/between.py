"""What inputs do between the ends of the time steps, where no step sees it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.mechanics.loads.signals import Held, value_at
from tautflex.mechanics.loads.time_table import TimeTable
from tautflex.numeric import Array
from tautflex.solvers.transient.accuracy.time_error import rounded_down
from tautflex.solvers.transient.problem import TransientProblem

# Steps that are looked at, and where in each: uneven, so that no vibration keeps step.
_MOST, _SHARES = 300, np.array([0.0, 0.27, 0.5, 0.81, 1.0])
# Off the straight line between a step's ends, of the largest value: five steps to a period.
_ALLOWED, _WANTED = 0.2, 0.02
# Halvings of the step until one is found that would do.
_HALVINGS = 12


def doubts_about_inputs(driven: InputSet, problem: TransientProblem) -> list[str]:
    """Sentences about inputs whose functions of time change faster than steps of a fixed size.

    Each is compared with a straight line in at most `_MOST` steps, those with jumps left out; steps that adapt
    themselves see it by their errors.
    """
    step, begin, count = problem.time_step, problem.begin, problem.count
    if problem.adaptive is not None:
        return []
    starts = problem.shift + step * np.unique(np.linspace(begin, count - 1, min(count - begin, _MOST)).round())
    breaks, slack = np.array(driven.breaks), 1e-9 * step
    jumps = np.any((breaks > starts[:, None] - slack) & (breaks < starts[:, None] + step + slack), axis=1)
    found = []
    for name, item in driven.named:
        function, argument = getattr(item, "function", None), getattr(item, "name", "inputs")
        if not callable(function) or isinstance(function, TimeTable | Held):  # steps meet every row and every change
            continue
        off, largest = _off_line(argument, function, starts[~jumps], step)
        if not off.size or not off.max() > _ALLOWED * largest:
            continue
        worst = float(starts[~jumps][off.argmax()])
        told = f"{off.max() / largest:.0%} of its largest value beside the straight line between the ends of a step"
        found.append(
            f"inputs: {name} changes faster than the time steps: at t = {worst:.4g} s it goes {told} of {step:g} s, "
            f"and steps see the ends alone; {_remedy(argument, function, worst, step, _WANTED * largest)}"
        )
    return found


def _off_line(argument: str, function: Callable[[float], ArrayLike], starts: Array, step: float) -> tuple[Array, float]:
    """How far a function leaves straight lines through steps of a size [s], shape (start,), and its largest value."""
    instants = starts[:, None] + step * _SHARES
    given = [np.ravel(value_at(argument, function, float(time))) for time in instants.ravel()]
    for value in given:
        if value.shape != given[0].shape:
            checks.float_array(argument, value, given[0].shape)
    values = np.array(given).reshape(*instants.shape, -1)
    line = values[:, :1] + _SHARES[:, None] * (values[:, -1:] - values[:, :1])
    return np.abs(values - line).max(axis=(1, 2), initial=0.0), float(np.abs(values).max(initial=0.0))


def _remedy(argument: str, function: Callable[[float], ArrayLike], start: float, step: float, allowed: float) -> str:
    for _ in range(_HALVINGS):
        step /= 2.0
        halves = start + step * np.array([0.0, 1.0])
        off, _ = _off_line(argument, function, halves, step)
        if off.max() <= allowed:
            return f"set time_step = {rounded_down(step):.2g} s or less"
        start = float(halves[off.argmax()])
    return "no step follows it: smooth it, or list its jumps as breaks"
