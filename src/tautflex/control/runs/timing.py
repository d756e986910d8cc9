"""Steps between two commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.reduction.marching.simulation import new_run
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.problem import TransientProblem

# Longest step [s] where none is given, and its share of the stable one: forces may stiffen the structure fourfold.
_LONGEST, _STABLE_SHARE = 5e-3, 0.5
# Times as many steps as an implicit method takes that are worth a word.
_MANY = 8


def steps_of(interval: float, time_step: float | None, stable_step: Callable[[], float] | None = None) -> int:
    """Steps of an interval; InputError unless they are whole ones.

    Where no step is given it is at most 5 ms and half of the stable one [s], if there is such.
    """
    if time_step is None:
        longest = _LONGEST if stable_step is None else min(_LONGEST, _STABLE_SHARE * stable_step())
        return int(np.ceil(interval / longest - 1e-9))
    count = interval / checks.positive("time_step", time_step)
    if round(count) < 1 or abs(count - round(count)) > 1e-6:
        whole = interval / max(1, round(count))
        raise InputError(
            f"time_step: expected a whole part of the interval ({interval:g} s), got {time_step:g}; set for example "
            f"time_step = {whole:.6g}"
        )
    return round(count)


def doubts_about_steps(method: Any, interval: float, steps: int) -> list[str]:
    """Sentence about many more steps of an interval than a method takes that is stable at any step."""
    needed = steps_of(interval, None)
    if not isinstance(method, CentralDifference) or steps < _MANY * needed:
        return []
    return [
        f"{steps} steps of {interval / steps:.3g} s are taken in every interval of {interval:g} s, as short as the "
        f"fastest coordinate asks for with central differences; {needed} of a method that is stable at any step may "
        f"do: give Plant method=GeneralizedAlpha() and time_step={interval / needed:.3g}, in a case file solver.method "
        f"= 'generalized-alpha' and solver.time_step = {interval / needed:.3g}"
    ]


def stable_step_of(plant: Any, motion: Any, question: Mapping[str, Any]) -> float:
    """Longest stable step [s] at the start of a run on a hub or along a maneuver; inf of an implicit method."""
    if not isinstance(question["method"], CentralDifference):
        return np.inf
    short = 1e-9  # stable by itself; no step is taken
    run = new_run(plant, TransientProblem.asked(plant, motion, {**question, "time_step": short, "end_time": short}))
    run.start()
    return run.stable_step()
