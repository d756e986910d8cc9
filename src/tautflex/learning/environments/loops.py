"""Episodes of a task side by side: what single and vector environments do, as one array program."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.environments.bodies import bodies_of
from tautflex.learning.environments.judge import Rules, command_rows, finish_rows, see_rows
from tautflex.learning.environments.references import reference_table
from tautflex.numeric import Array

# What an episode's instant is paid for, in `Loops.terms`.
TERMS = ("attitude_error", "surface_rms", "cost", "effort", "change")


class Loops:
    """Episodes side by side.

    Parameters
    ----------
    arena
        Structure, loop and task.
    kind
        ``"reduced"`` or ``"full"``.
    count
        How many.

    Attributes
    ----------
    actions
        Last ones, shape (count, commands).
    seen
        Observations, shape (count, size).
    reward
        Shape (count,).
    terms
        See `TERMS`, shape (count, 5).
    terminated, truncated
        Shape (count,).
    parameters
        Of the episodes.
    """

    def __init__(self, arena: Arena, kind: str, count: int = 1) -> None:
        self.arena, self.count = arena, count
        self.bodies = bodies_of(arena, kind, count)
        spec, steps = arena.spec, arena.steps
        measured, commands = len(spec.measured), len(spec.commanded)
        disturbances = len(arena.disturbances)
        self.rules = Rules.of(arena)
        self.actions, self._before = np.zeros((2, count, commands))
        self._command = np.zeros((count, commands + disturbances))
        self._gain = np.ones((count, commands))
        self._disturbance = np.zeros((count, steps, disturbances))
        self._reference = np.zeros((count, steps + 1, 4 * spec.axes))
        self._noise = np.zeros((count, steps + 1, measured))
        self._measured = np.zeros((count, 2, measured))
        self.seen = np.zeros((count, arena.observation.size))
        self.reward = np.zeros(count)
        self.terms = np.zeros((count, len(TERMS)))
        self.terminated, self.truncated = np.zeros((2, count), dtype=bool)
        self.place = np.full(count, -1, dtype=np.int64)
        self.parameters: list[dict[str, float]] = [{} for _ in range(count)]
        self._times = np.asarray(arena.interval * np.arange(steps + 1), dtype=float)
        self._deviations = np.array([channel.noise for channel in spec.measurements for _ in range(channel.size)])

    def reset(self, row: int, random: np.random.Generator, options: Mapping[str, Any] | None = None) -> None:
        """Begin an episode whose parameters and noise are drawn."""
        arena, task = self.arena, self.arena.task
        parameters = self.parameters[row] = arena.draw(random, options)
        maneuver = task.maneuver(parameters)
        self._gain[row] = self.rules.limits * (1.0 + (parameters["effectiveness"] - 1.0) * arena.on_structure)
        disturbance = task.disturbances(parameters, arena.steps, arena.interval)
        self._disturbance[row, :, : disturbance.shape[1]] = disturbance
        self._disturbance[row, :, disturbance.shape[1] :] = parameters["tension_error"] * arena.tension_units
        self._reference[row] = reference_table(maneuver, self._times, arena.hub)
        random.standard_normal(out=self._noise[row])
        self._noise[row] *= parameters["noise"] * self._deviations
        self.actions[row], self._before[row], self.place[row] = 0.0, 0.0, 0
        self.reward[row], self.terminated[row], self.truncated[row] = 0.0, False, False
        self.bodies.reset(row, maneuver)
        see_rows(
            self.rules, row, row + 1, self.bodies.readings, self.place, self._noise, self._reference, self._measured,
            self.actions, self.seen, True,
        )  # fmt: skip

    def step(self) -> None:
        """Take `actions` over one interval, in all episodes that go on."""
        if command_rows(self._command, self.actions, self._gain, self._disturbance, self.place):
            raise InputError("action: expected finite numbers, got one that is none; correct the policy")
        self.bodies.step(self._command)
        finish_rows(
            self.rules, self.bodies.readings, self.bodies.failed, self.place, self.actions, self._before, self.reward,
            self.terms, self.terminated, self.truncated, self._reference, self._noise, self._measured, self.seen,
        )  # fmt: skip

    def over(self, row: int) -> bool:
        """Whether an episode has ended, or none has begun."""
        return bool(self.place[row] < 0 or self.terminated[row] or self.truncated[row])

    def attitude(self, row: int) -> Array:
        """Rotation vector of the hub about its axes [rad], shape (axes,)."""
        first = self._measured.shape[2]
        return self.bodies.readings[row, first : first + self.arena.spec.axes]
