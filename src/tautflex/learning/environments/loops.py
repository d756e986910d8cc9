"""Episodes of a task side by side: what single and vector environments do, as one array program."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.control.compiled.addresses import table_of
from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.environments.bodies import bodies_of
from tautflex.learning.environments.judge import Episodes, Rules, command_rows, judge_rows, look_rows, show_rows
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
        self.actions, zeros = np.zeros((count, commands)), np.zeros
        self.seen = zeros((count, arena.observation.size))
        self.reward = zeros(count)
        self.terms = zeros((count, len(TERMS)))
        self.terminated, self.truncated = zeros((2, count), dtype=bool)
        self.place = np.full(count, -1, dtype=np.int64)
        own = self._own = Episodes(
            command=zeros((count, commands + disturbances)), actions=self.actions, before=zeros((count, commands)),
            gain=np.ones((count, commands)), disturbance=zeros((count, steps, disturbances)), place=self.place,
            readings=self.bodies.readings, failed=self.bodies.failed, reward=self.reward, terms=self.terms,
            terminated=self.terminated, truncated=self.truncated, reference=zeros((count, steps + 1, 4 * spec.axes)),
            noise=zeros((count, steps + 1, measured)), measured=zeros((count, 2, measured)),
            raw=zeros((count, self.seen.shape[1] - commands - 1)), seen=self.seen,
        )  # fmt: skip
        self._table, self._kept = table_of(Rules.of(arena), own)
        self.parameters: list[dict[str, float]] = [{} for _ in range(count)]
        self._times = np.asarray(arena.interval * np.arange(steps + 1), dtype=float)
        self._deviations = np.array([channel.noise for channel in spec.measurements for _ in range(channel.size)])

    def reset(self, row: int, random: np.random.Generator, options: Mapping[str, Any] | None = None) -> None:
        """Begin an episode whose parameters and noise are drawn."""
        arena, task = self.arena, self.arena.task
        parameters = self.parameters[row] = arena.draw(random, options)
        maneuver = task.maneuver(parameters)
        own = self._own
        own.gain[row] = arena.limits * (1.0 + (parameters["effectiveness"] - 1.0) * arena.on_structure)
        disturbance = task.disturbances(parameters, arena.steps, arena.interval)
        own.disturbance[row, :, : disturbance.shape[1]] = disturbance
        own.disturbance[row, :, disturbance.shape[1] :] = parameters["tension_error"] * arena.tension_units
        own.reference[row] = reference_table(maneuver, self._times, arena.hub)
        random.standard_normal(out=own.noise[row])
        own.noise[row] *= parameters["noise"] * self._deviations
        own.actions[row], own.before[row], self.place[row] = 0.0, 0.0, 0
        self.reward[row], self.terminated[row], self.truncated[row] = 0.0, False, False
        self.bodies.reset(row, maneuver)
        self._see(row, row + 1, True)

    def _see(self, first: int, end: int, starting: bool) -> None:
        """Fill observations of some rows."""
        look_rows(self._table, first, end, starting)
        # Here, because array libraries have it for many numbers at once.
        raw = self._own.raw[first:end]
        np.arcsinh(raw, out=raw)
        show_rows(self._table, first, end)

    def take(self, actions: Any, shape: tuple[int, ...]) -> None:
        """Take actions of all episodes, of a shape that is asked for: one number shall not count for all silently."""
        try:
            given = np.shape(actions)
            if given == shape:
                self.actions[...] = actions
                return
        except (TypeError, ValueError):
            checks.numbers("action", actions)
            raise
        raise InputError(f"action: expected shape {shape}, got {given}; give a number for each command")

    def step(self) -> None:
        """Take `actions` over one interval, in all episodes that go on."""
        if command_rows(self._table):
            raise InputError("action: expected finite numbers, got one that is none; correct the policy")
        self.bodies.step(self._own.command)
        judge_rows(self._table)
        self._see(0, self.count, False)

    def over(self, row: int) -> bool:
        """Whether an episode has ended, or none has begun."""
        return bool(self.place[row] < 0 or self.terminated[row] or self.truncated[row])

    def attitude(self, row: int) -> Array:
        """Rotation vector of the hub about its axes [rad], shape (axes,)."""
        first = self._own.measured.shape[2]
        return self.bodies.readings[row, first : first + self.arena.spec.axes]
