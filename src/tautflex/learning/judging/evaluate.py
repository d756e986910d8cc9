"""Judging laws on the full model: paired scenarios, intervals, and the gap to the model that training saw."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex import checks, compiling
from tautflex._version import __version__
from tautflex.case.schema import Case
from tautflex.control.law import ControlLaw, law_of
from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.environments.bodies import KINDS
from tautflex.learning.judging.scenarios import METRICS, Scenario, play, scenarios_of, start_on, tensioned
from tautflex.study.engines.processes import Processes
from tautflex.writing import write_text

Progress = Callable[[float, str], None]
Job = tuple[str, int, str]
"""Name of a law, number of a scenario, kind of plant."""
_DRAWS = 2000  # of the bootstrap
_LEVEL = 95.0  # of its interval [%]


def evaluate(
    laws: Mapping[str, ControlLaw | Callable[..., Any]],
    case: Case,
    *,
    scenarios: Sequence[Scenario] | None = None,
    plants: Sequence[str] = ("full", "reduced"),
    directory: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Judge laws on the scenarios of a task.

    All laws meet the same scenarios with the same noise. Full plants take half the step of the case.

    Parameters
    ----------
    laws
        Name -> law, or policy.
    case
        Case with a [task].
    scenarios
        Episodes; None is `scenarios_of` the task: four values of its first parameter, three errors of the tension, two
        seeds of the noise.
    plants
        ``"full"``, and ``"reduced"`` for the gap to it.
    directory
        Where each finished episode is kept; what is there is not computed again. None keeps nothing.
    workers
        Processes; None is one per core, 1 stays in this one.
    progress
        Called with the fraction done and a short message.

    Returns
    -------
    xarray.Dataset
        Over ``law``, ``scenario`` and ``plant``: cost, settling times [s], residual rms [m] and pointing [rad], effort,
        work [J] and others. Failed episodes cost the worst value, and have NaN elsewhere.
        Attribute ``failures`` lists them.

    Raises
    ------
    InputError
        If an argument is wrong, or a law does not fit the loop.

    Examples
    --------
    >>> import tautflex as tf
    >>> case = tf.load_case("task.toml", ["task.duration=0.2"])  # tautflex init task.toml --template task-slew
    >>> laws = {"none": lambda time, measurement: [0.0, 0.0, 0.0]}
    >>> judged = tf.evaluate(laws, case, scenarios=[tf.Scenario({"angle": 0.3})], plants=["reduced"], workers=1)
    >>> dict(judged.cost.sizes)
    {'law': 1, 'scenario': 1, 'plant': 1}
    """
    checks.instance("laws", laws, Mapping, "a mapping such as {'pd': PD(30.0, 22.0)}")
    if not laws:
        raise InputError("laws: expected at least one, got none; give for example {'pd': PD(30.0, 22.0)}")
    checks.instance("case", case, Case, "a case", remedy="load_case('slew.toml') gives one")
    tell = checks.teller(progress)
    for kind in checks.several("plants", plants, str, "'full'"):
        checks.one_of("plants", kind, KINDS)
    asked = {name: law_of(f"laws.{name}", law) for name, law in laws.items()}
    arena = Arena(case)
    chosen = scenarios_of(arena.task) if scenarios is None else list(scenarios)
    checks.several("scenarios", chosen, Scenario, "Scenario({'angle': 0.5})")
    for name, law in asked.items():
        try:
            start_on(law, arena)
        except InputError as error:
            raise InputError(f"laws.{name}: {error}") from None
    jobs = [(name, number, kind) for number in range(len(chosen)) for kind in plants for name in asked]
    folder = None if directory is None else checks.path("directory", directory)
    found = dict[Job, dict[str, float]]()
    marks = {job: _mark(case, asked[job[0]], chosen[job[1]], job[2]) for job in jobs} if folder is not None else {}
    for job in jobs if folder is not None else ():
        kept = _kept(folder, marks[job])
        if kept is not None:
            found[job] = kept
    todo = [job for job in jobs if job not in found]
    if todo:
        compiling.say(
            progress, f"judging on {len(todo)} episodes; the first ones wait for plants and what they compile ..."
        )
    for job, result in _played(case, asked, chosen, todo, workers):
        found[job] = result
        if folder is not None:
            words = {"law": job[0], "scenario": chosen[job[1]].words, "plant": job[2]}
            write_text(folder / f"{marks[job]}.json", json.dumps(words | result))
        tell(len(found) / len(jobs), f"{job[0]}: {chosen[job[1]].words}")
    return _table(list(asked), chosen, list(plants), found)


def _played(
    case: Case, laws: Mapping[str, ControlLaw], scenarios: Sequence[Scenario], jobs: list[Job], workers: int | None
) -> Iterator[tuple[Job, dict[str, float]]]:
    """Results of jobs as they come."""
    count = min(os.cpu_count() or 1 if workers is None else checks.whole("workers", workers, 1), len(jobs))
    text = case.to_toml()
    episodes = [(job, text, laws[job[0]], scenarios[job[1]]) for job in jobs]
    if count <= 1:
        for episode in episodes:
            yield episode[0], _play(episode)
        return
    for name, law in laws.items():
        try:
            pickle.dumps(law)
        except Exception as error:
            raise InputError(
                f"laws.{name}: expected a law that other processes can be sent, got {law!r} ({error}); set workers=1"
            ) from None
    with Processes(count) as processes:
        for episode, result in processes.each(_play, episodes):
            yield episode[0], result


@lru_cache(maxsize=8)
def _arena(text: str, error: float) -> Arena:
    from tautflex.case.reading import parse_case

    return Arena(tensioned(parse_case(text), error))


def _play(episode: tuple[Job, str, ControlLaw, Scenario]) -> dict[str, float]:
    (_, _, kind), text, law, scenario = episode
    arena = _arena(text, scenario.tension_error)
    step = 0.5 * arena.case.solver.time_step if kind == "full" else None
    return play(arena, law, scenario, kind, step, _arena(text, 0.0))


def _mark(case: Case, law: ControlLaw, scenario: Scenario, kind: str) -> str:
    """Fingerprint of all that an episode depends on."""
    try:
        own = pickle.dumps(law, protocol=4)
    except Exception:
        own = repr(law).encode()
    words = json.dumps([__version__, case.to_toml(), asdict(scenario), kind], sort_keys=True)
    return hashlib.sha256(words.encode() + own).hexdigest()[:24]


def _kept(folder: Path | None, mark: str) -> dict[str, float] | None:
    """Result of an episode from its file; None if it is not there, or damaged."""
    assert folder is not None
    try:
        found = json.loads((folder / f"{mark}.json").read_text())
        return {name: float(found[name]) for name in METRICS}
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _table(
    laws: list[str], scenarios: list[Scenario], plants: list[str], found: dict[Any, dict[str, float]]
) -> xr.Dataset:
    shape = len(laws), len(scenarios), len(plants)
    data = {name: (("law", "scenario", "plant"), np.full(shape, np.nan)) for name in METRICS}
    for (law, number, kind), result in found.items():
        for name, value in result.items():
            data[name][1][laws.index(law), number, plants.index(kind)] = value
    coords = {"law": laws, "plant": plants, "scenario": np.arange(len(scenarios))}
    table = xr.Dataset(data, coords).assign_coords(
        words=("scenario", [each.words for each in scenarios]),
        tension_error=("scenario", [each.tension_error for each in scenarios]),
    )
    for name, (unit, words) in METRICS.items():
        table[name].attrs = {"units": unit, "long_name": words}
    failures = [
        f"{law}, {kind}: {scenarios[number].words}, failed at {result['failed_at']:.3g} s"
        for (law, number, kind), result in sorted(found.items())
        if not np.isnan(result["failed_at"])
    ]
    return table.assign_attrs(title="laws on the scenarios of a task", failures=failures)


def summary(found: xr.Dataset) -> dict[str, Any]:
    """What `tautflex evaluate` tells of a result of `evaluate`.

    Returns
    -------
    dict
        Name of a law -> on the first plant mean ``cost`` with its bootstrap ``interval`` [2.5 %, 97.5 %],
        ``worst_cost`` and its scenario, medians of ``settling_time`` [s] (None where most do not settle) and
        ``surface_rms`` [m], number of ``failures``, ``gap``: its mean cost less that on the reduced plant (None without
        one), and ``difference``: mean cost less that of the first law in the same scenarios, with its interval.
    """
    checks.instance("found", found, xr.Dataset, "a Dataset", remedy="evaluate(laws, case) gives one")
    first = found.isel(plant=0)
    costs, laws = first["cost"].values, [str(name) for name in found["law"].values]
    answer = dict[str, Any]()
    for number, law in enumerate(laws):
        own, worst = first.isel(law=number), int(costs[number].argmax())
        settling = np.where(np.isnan(own["settling_time"].values), np.inf, own["settling_time"].values)
        middle, gap = float(np.median(settling)), None
        if "reduced" in found["plant"].values and found["plant"].values[0] != "reduced":
            gap = float((costs[number] - found["cost"].sel(plant="reduced").isel(law=number).values).mean())
        rms = own["surface_rms"].values
        difference = costs[number] - costs[0]
        answer[law] = {
            "cost": float(costs[number].mean()),
            "interval": interval(costs[number]),
            "worst_cost": float(costs[number].max()),
            "worst_scenario": str(found["words"].values[worst]),
            "settling_time": middle if np.isfinite(middle) else None,
            "surface_rms": float(np.nanmedian(rms)) if not np.isnan(rms).all() else None,
            "failures": int((~np.isnan(own["failed_at"].values)).sum()),
            "gap": gap,
            "difference": {"mean": float(difference.mean()), "interval": interval(difference)},
        }
    return answer


def interval(values: np.ndarray[Any, Any]) -> list[float]:
    """Bootstrap interval of a mean, percentiles [Efron 1979]."""
    drawn = np.random.default_rng(0).choice(values, (_DRAWS, len(values)))
    return np.percentile(drawn.mean(axis=1), [50.0 - 0.5 * _LEVEL, 50.0 + 0.5 * _LEVEL]).tolist()
