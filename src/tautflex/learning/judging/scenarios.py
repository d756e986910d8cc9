"""What laws are judged on: episodes of a task, and how one of them went."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.analysis import settling_time
from tautflex.case.schema import Case
from tautflex.control.law import ControlLaw
from tautflex.control.linear import LinearPlant
from tautflex.control.loop import close_loop
from tautflex.control.signals import LoopSpec, Reference
from tautflex.control.tasks.task import Task
from tautflex.errors import InputError, NotConvergedError
from tautflex.learning.arena import Arena
from tautflex.learning.environments.references import reference_table
from tautflex.motion.attitude import attitude as attitude_of
from tautflex.numeric import Array
from tautflex.solvers.transient.status import Run, Status

TENSION_ERRORS = (-0.05, 0.0, 0.05)
# What is left of a vibration is read over the last part of an episode.
_LAST = 0.1
# Metrics of an episode: unit and words.
METRICS = {
    "cost": ("1", "mean of log(1 + (angle/tolerance)^2 + (rms/tolerance)^2)"),
    "settling_time": ("s", "time until attitude and surface stay within their tolerances"),
    "attitude_settling": ("s", "time until the attitude stays within its tolerance"),
    "surface_settling": ("s", "time until the surface stays within its tolerance"),
    "surface_rms": ("m", "root mean square of the film over its area and the last tenth of the episode"),
    "pointing": ("rad", "root mean square of the angle to the goal over the last tenth of the episode"),
    "effort": ("1", "mean square of the commands in parts of their limits"),
    "peak": ("1", "largest command in parts of its limit"),
    "work": ("J", "work of all actuators"),
    "wrinkled_fraction": ("1", "largest part of the film that wrinkles"),
    "min_principal_resultant": ("N m-1", "smallest principal film resultant"),
    "failed_at": ("s", "instant of a failure; none is the rest"),
}


@dataclass(frozen=True)
class Scenario:
    """Episode of a task.

    Parameters
    ----------
    parameters
        As drawn, without errors.
    tension_error
        Part of the pretension by which all cables are off.
    seed
        Of the sensors' noise.
    weak
        Name of an actuator -> part of its command, within its limit, that acts, in [0, 2]; no law knows of it.
    """

    parameters: Mapping[str, float]
    tension_error: float = 0.0
    seed: int = 0
    weak: Mapping[str, float] = field(default_factory=dict)

    @property
    def words(self) -> str:
        """What it is, in a line."""
        own = {name: value for name, value in self.parameters.items() if name not in Task.drawn}
        told = ", ".join(f"{name} = {value:.4g}" for name, value in own.items())
        weak = "".join(f", {name} at {part:.0%}" for name, part in self.weak.items())
        return f"{told}, tension {self.tension_error:+.0%}{weak}, seed {self.seed}"


def scenarios_of(
    task: Task, count: int = 4, errors: tuple[float, ...] = TENSION_ERRORS, seeds: int = 2
) -> list[Scenario]:
    """Grid of episodes: parameters x errors of the tension x seeds of the noise."""
    grid = task.grid(checks.whole("count", count, 1))
    seeds = checks.whole("seeds", seeds, 1)
    return [Scenario(one, error, seed) for one in grid for error in errors for seed in range(seeds)]


def tensioned(case: Case, error: float) -> Case:
    """Case whose pretension is off by a part of it."""
    if error == 0.0:
        return case
    if case.cables is None:
        raise InputError(
            "cables: expected a case with cables to judge errors of their tension, got none; give errors=()"
        )
    tensions = {name: (1.0 + error) * getattr(case.cables, name) for name in ("pretension_x", "pretension_y")}
    return case.replaced(cables=tensions)


@dataclass(frozen=True)
class Disturbed(ControlLaw):
    """Law beside what disturbs an episode, which it knows nothing of.

    Parameters
    ----------
    law
        The law.
    commands
        Numbers that it commands, the first of a command.
    table
        What the others are in each interval, shape (interval, others).
    interval
        [s].
    """

    law: ControlLaw
    commands: int
    table: Array
    interval: float

    def start(self, spec: LoopSpec) -> Any:
        """Memory of the law, which is told of its own commands alone."""
        known, seen = list[Any](), 0
        for channel in spec.commands:
            if seen < self.commands:
                known.append(channel)
            seen += channel.size
        return self.law.start(replace(spec, commands=tuple(known)))

    def act(self, memory: Any, measurement: Array, reference: Reference) -> tuple[Any, Array]:
        """Command of the law, and what disturbs."""
        memory, command = self.law.act(memory, measurement, reference)
        now = min(round(reference.time / self.interval), len(self.table) - 1)
        return memory, np.concatenate([command, self.table[now]])


@dataclass(frozen=True)
class Told(ControlLaw):
    """Law that is told the linear view of a plant as it should be, whatever plant it meets.

    Parameters
    ----------
    law
        The law.
    known
        The plant as it should be.
    beyond
        Its linear view with more modes than the law knows.
    """

    law: ControlLaw
    known: Arena
    beyond: LinearPlant | None = None

    def start(self, spec: LoopSpec) -> Any:
        """Memory of the law."""
        try:
            return self.law.start(spec)
        except InputError as error:
            if not str(error).startswith("model:"):
                raise
            return self.law.start(replace(spec, model=self.known.model, beyond=self.beyond))

    def act(self, memory: Any, measurement: Array, reference: Reference) -> tuple[Any, Array]:
        """Command of the law."""
        return self.law.act(memory, measurement, reference)


@dataclass(frozen=True)
class Weakened(ControlLaw):
    """Law whose commands act in part, which it knows nothing of.

    Parameters
    ----------
    law
        The law.
    limits, parts
        Of the commands, and what of them acts, shape (commands,).
    """

    law: ControlLaw
    limits: Array
    parts: Array

    def start(self, spec: LoopSpec) -> Any:
        """Memory of the law."""
        return self.law.start(spec)

    def act(self, memory: Any, measurement: Array, reference: Reference) -> tuple[Any, Array]:
        """The part of its command that acts."""
        memory, command = self.law.act(memory, measurement, reference)
        return memory, self.parts * np.clip(command, -self.limits, self.limits)


def weakened(arena: Arena, law: ControlLaw, weak: Mapping[str, float]) -> ControlLaw:
    """Law with actuators that act in part; InputError if a name is unknown or a part out of range."""
    if not weak:
        return law
    parts = np.ones(len(arena.limits))
    for name, part in weak.items():
        parts[arena.spec.command("weak", name)] = checks.between(f"weak.{name}", part, 0.0, 2.0)
    return Weakened(law, arena.limits, parts)


def disturbed(arena: Arena, law: ControlLaw, parameters: dict[str, float]) -> ControlLaw:
    """Law beside the disturbances of an episode."""
    table = arena.task.disturbances(parameters, arena.steps, arena.interval)
    return Disturbed(law, len(arena.limits), table, arena.interval) if table.shape[1] else law


def play(
    arena: Arena,
    law: ControlLaw,
    scenario: Scenario,
    kind: str,
    time_step: float | None = None,
    known: Arena | None = None,
) -> dict[str, float]:
    """Run an episode under a law, which is told of the plant as it should be, and tell how it went: see `METRICS`."""
    law = weakened(arena, Told(law, known or arena), scenario.weak)
    if kind == "reduced" and arena.compiles:
        return _play_compiled(arena, law, scenario)
    task, parameters = arena.task, dict(scenario.parameters)
    plant = arena.plant(kind, time_step, exact=False)
    whole = disturbed(arena, law, parameters)
    try:
        run = close_loop(plant, whole, task.maneuver(parameters), task.duration, scenario.seed, frames=0)
    except NotConvergedError as error:
        if not isinstance(error.result, Run):
            raise
        run = error.result
    if run.status is Status.INTERRUPTED:
        raise KeyboardInterrupt  # what there is of the episode must not count as all of it
    data, steps = run.data, arena.steps
    done = slice(1, min(steps, data.sizes["sample_time"] - 1) + 1)
    rms = data["surface_rms"].values[done]
    angle = _angle(data["attitude"].values[done], arena, parameters) if arena.hub is not None else 0.0 * rms
    wrinkled = data["wrinkled_fraction"].values[done] if "wrinkled_fraction" in data else 0.0 * rms
    found = measure(arena, angle, rms, data["command"].values[: len(rms), : len(arena.limits)], wrinkled)
    found["work"] = float(data["source_work"].values[-1].sum())
    if "min_principal_resultant" in data:
        found["min_principal_resultant"] = float(data["min_principal_resultant"].min())
    return found


def _play_compiled(arena: Arena, law: ControlLaw, scenario: Scenario) -> dict[str, float]:
    """The same on the compiled reduced plant."""
    task, parameters, spec = arena.task, dict(scenario.parameters), arena.spec
    plant = arena.compiled(1, exact=False)
    disturbances = task.disturbances(parameters, arena.steps, arena.interval)
    times = np.asarray(arena.interval * np.arange(arena.steps + 1), dtype=float)
    maneuver = task.maneuver(parameters)
    table = reference_table(maneuver, times, arena.hub).reshape(len(times), 4, spec.axes)
    memory = law.start(arena.spec)
    measured, commands = len(spec.measured), len(arena.limits)
    truth, given = np.zeros((arena.steps, 1 + spec.axes)), np.zeros((arena.steps, commands))
    y, done = plant.reset(scenario.seed, maneuver=maneuver if arena.hub is None else None), 0
    for number, time in enumerate(times[:-1].tolist()):
        memory, command = law.act(memory, y[:measured].copy(), Reference(time, *table[number]))
        given[number] = checks.float_array("command", command, (commands,))
        y = plant.step(np.concatenate([given[number], disturbances[number]]))
        if plant.failed[0]:
            break
        truth[number], done = y[measured:], number + 1
    off = truth[:done, :-1] - table[1 : done + 1, 3]
    found = measure(arena, np.linalg.norm(off, axis=1), truth[:done, -1], given[:done], np.zeros(done))
    return found | {"work": float(plant.work.sum()), "wrinkled_fraction": np.nan}


def start_on(law: ControlLaw, arena: Arena) -> None:
    """Try a law on the loop; InputError if it does not fit, or leaves modes beyond those that it knows unstable."""
    Told(law, arena, arena.beyond).start(arena.spec)


def measure(arena: Arena, angle: Array, rms: Array, command: Array, wrinkled: Array) -> dict[str, float]:
    """How an episode went.

    Parameters
    ----------
    arena
        Its task.
    angle, rms, wrinkled
        Angle to the goal [rad], rms [m] and part of the film that wrinkles at the ends of the intervals, shape (n,).
    command
        In the intervals, shape (n, commands); fewer than those of an episode: the plant failed.
    """
    task, steps = arena.task, arena.steps
    bad = np.flatnonzero(task.failed(angle, rms) | (wrinkled > task.wrinkled_limit))
    good = int(bad[0]) if bad.size else len(rms)
    # All of a failed episode costs the worst, so that a late failure is no better than an early one.
    cost = task.worst_cost if good < steps else float(task.cost(angle, rms).mean())
    found = dict.fromkeys(METRICS, np.nan) | {"cost": cost}
    given = command[: max(good, 1)] / arena.limits
    if given.size:
        found |= {"effort": float((np.clip(given, -1.0, 1.0) ** 2).mean()), "peak": float(np.abs(given).max())}
    found["wrinkled_fraction"] = float(wrinkled.max(initial=0.0))
    if good < steps:
        return found | {"failed_at": float((good + 1) * arena.interval)}
    last = max(1, round(_LAST * steps))
    found["surface_rms"] = float(np.sqrt((rms[-last:] ** 2).mean()))
    found["pointing"] = float(np.sqrt((angle[-last:] ** 2).mean()))
    for name, values, tolerance in (
        ("attitude_settling", angle, task.attitude_tolerance),
        ("surface_settling", rms, task.surface_tolerance),
    ):
        found[name] = settling_time((values, arena.interval), tolerance)
    found["settling_time"] = float(np.maximum(found["attitude_settling"], found["surface_settling"]))
    return found


def _angle(attitude: Array, arena: Arena, parameters: dict[str, float]) -> Array:
    """Angle between hub and goal [rad], shape (time,)."""
    maneuver = arena.task.maneuver(parameters)
    goal = attitude_of(maneuver, [maneuver.end])[0]
    vector = goal[0] * attitude[:, 1:] - attitude[:, :1] * goal[1:] - np.cross(goal[1:], attitude[:, 1:])
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(vector, axis=1), np.abs(attitude @ goal)))
