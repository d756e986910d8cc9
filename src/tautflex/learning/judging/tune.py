"""Numbers of laws, searched on the reduced model with a budget that is the same for all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import minimize

from tautflex import checks, compiling
from tautflex.case.schema import Case
from tautflex.control.law import ControlLaw, law_of
from tautflex.errors import InputError, NotConvergedError
from tautflex.learning.arena import Arena
from tautflex.learning.judging.scenarios import Scenario, play, start_on
from tautflex.numeric import Array
from tautflex.text import card

_EPISODES = 3  # that a set of numbers is tried on
_FIRST = 0.5  # size of the first steps, in powers of e
_FIXED = ("limit", "floor", "measurement_noise")  # fields that are not tuned


@dataclass(frozen=True)
class Tuned:
    """What `tune_law` found.

    Parameters
    ----------
    law
        The law with its best numbers.
    cost
        Its mean cost on the episodes of the search, and that of the law that was given.
    before
        That of the law that was given.
    trials
        Sets of numbers that were tried.
    seconds
        Time of the plants that this took [s].
    """

    law: ControlLaw
    cost: float
    before: float
    trials: int
    seconds: float

    def __repr__(self) -> str:
        lines = {
            "law": repr(self.law),
            "cost": f"{self.cost:.4g}, before {self.before:.4g}",
            "budget": f"{self.trials} trials, {self.seconds:g} s of plants",
        }
        return card(self, lines)


def tune_law(
    law: ControlLaw | Callable[..., Any],
    case: Case | Arena,
    seconds: float = 3000.0,
    seed: int = 0,
    plant: str = "reduced",
    progress: Callable[[float, str], None] | None = None,
) -> Tuned:
    """Search for the numbers of a law that cost least, by the simplex method of Nelder and Mead in their logarithms.

    Parameters
    ----------
    law
        First guess. What is tuned are its positive numbers, those of laws inside it included, but no limits.
    case
        Case with a [task].
    seconds
        Budget: time of plants [s], > 0; a set of numbers takes three episodes.
    seed
        Of these episodes, which are the same for all laws.
    plant
        ``"reduced"`` or ``"full"``.
    progress
        Called with the fraction done and a short message.

    Returns
    -------
    Tuned
        A law without numbers comes back as it is.

    Raises
    ------
    InputError
        If an argument is wrong, or the law as it is does not fit the loop.

    Examples
    --------
    >>> import tautflex as tf
    >>> case = tf.load_case("task.toml", ["task.duration=0.2"])  # tautflex init task.toml --template task-slew
    >>> tuned = tf.tune_law(tf.PD(stiffness=30.0, damping=22.0), case, seconds=5.0)
    >>> type(tuned.law).__name__
    'PD'
    """
    chosen, tell = law_of("law", law), checks.teller(progress)
    arena = case if isinstance(case, Arena) else Arena(case)
    random = np.random.default_rng(checks.whole("seed", seed, 0))
    nominal = arena.task.nominal()
    errors = {"tension_error": 0.0, "effectiveness": 1.0, "noise": 1.0}
    episodes = [Scenario(nominal | arena.draw(random) | errors, 0.0, 1000 + number) for number in range(_EPISODES)]
    each = _EPISODES * arena.task.duration
    most = max(1, int(checks.positive("seconds", seconds) / each))
    first = np.log(list(numbers_of(chosen)))
    best: tuple[float, ControlLaw] = (np.inf, chosen)
    costs = list[float]()

    def cost(logarithms: Array) -> float:
        nonlocal best
        tried = with_numbers(chosen, iter(np.exp(logarithms).tolist()))
        try:
            start_on(tried, arena)
            found = float(np.mean([play(arena, tried, one, plant)["cost"] for one in episodes]))
        except (InputError, NotConvergedError):
            if not costs:  # as it was given
                raise
            found = arena.task.worst_cost
        costs.append(found)
        if found < best[0]:
            best = found, tried
        tell(len(costs) / most, f"cost {best[0]:.4g}")
        return found

    compiling.say(progress, f"tuning {type(chosen).__name__}, at most {most} trials of {_EPISODES} episodes ...")
    if len(first):
        simplex = np.concatenate([first[None], first + _FIRST * np.eye(len(first))])
        options: Any = {"initial_simplex": simplex, "maxfev": most, "xatol": 1e-3, "fatol": 1e-4}
        minimize(cost, first, method="Nelder-Mead", options=options)
    else:
        cost(first)
    return Tuned(best[1], best[0], costs[0], len(costs), each * len(costs))


def numbers_of(part: Any) -> Iterator[float]:
    """Positive numbers in a law, in order, those of parts of it included."""
    if isinstance(part, float):
        if part > 0.0 and np.isfinite(part):
            yield part
    elif isinstance(part, Mapping):
        for name in sorted(part):
            yield from numbers_of(part[name])
    elif isinstance(part, tuple | list):
        for one in part:
            yield from numbers_of(one)
    elif is_dataclass(part):
        for field in fields(part):
            if field.name not in _FIXED:
                yield from numbers_of(getattr(part, field.name))


def with_numbers(part: Any, numbers: Iterator[float]) -> Any:
    """The same with other numbers."""
    if isinstance(part, float):
        return next(numbers) if part > 0.0 and np.isfinite(part) else part
    if isinstance(part, Mapping):
        return {name: with_numbers(part[name], numbers) for name in sorted(part)}
    if isinstance(part, tuple | list):
        return tuple(with_numbers(one, numbers) for one in part)
    if is_dataclass(part) and not isinstance(part, type):
        own = {field.name: getattr(part, field.name) for field in fields(part) if field.name not in _FIXED}
        return replace(part, **{name: with_numbers(value, numbers) for name, value in own.items()})
    return part
