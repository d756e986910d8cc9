"""Kernels of episodes: commands from actions, rewards from readings, observations from noisy ones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.control.compiled.addresses import FIELDS, part_at, width
from tautflex.learning.arena import Arena
from tautflex.numeric import Array, Indices, Mask, jit


class Rules(NamedTuple):
    """Constants of a task and its loop.

    ``numbers`` are attitude and surface tolerance, attitude and surface limit, effort and change weight, what a cost of
    one is paid, worst reward, steps of an episode, interval and duration; the others as in `Observation`, the matrix
    by columns, and the step of the numbers of each sensor, shape (measurement,).
    """

    numbers: Array
    columns: Array
    knee: Array
    span: Array
    resolution: Array

    @classmethod
    def of(cls, arena: Arena) -> Rules:
        """Rules of an arena."""
        task, seen, spec = arena.task, arena.observation, arena.spec
        numbers = [
            task.attitude_tolerance, task.surface_tolerance, task.attitude_limit, task.surface_limit,
            task.effort_weight, task.change_weight, 1.0 / np.log1p(1e4), task.worst_reward(len(arena.limits)),
            arena.steps, arena.interval, task.duration,
        ]  # fmt: skip
        resolution = [arena.sensors[each.name].resolution for each in spec.measurements for _ in range(each.size)]
        span = np.arcsinh(seen.largest / seen.knee)
        return cls(
            np.array(numbers, dtype=float), np.ascontiguousarray(seen.matrix.T), seen.knee, span,
            np.array(resolution, dtype=float),
        )  # fmt: skip


class Episodes(NamedTuple):
    """Arrays of episodes side by side, see `Loops`.

    ``before`` are the actions before, ``raw`` what is seen before its scale bends, shape (count, rows); of ``measured``
    the last measurement and the one before, shape (count, 2, measurement).
    """

    command: Array
    actions: Array
    before: Array
    gain: Array
    disturbance: Array
    place: Indices
    readings: Array
    failed: Indices
    reward: Array
    terms: Array
    terminated: Mask
    truncated: Mask
    reference: Array
    noise: Array
    measured: Array
    raw: Array
    seen: Array


FIELDS[Rules] = "12111"
FIELDS[Episodes] = "22223i2i12bb33322"
_EPISODES = width(Rules)


@jit
def command_rows(table: Indices) -> bool:
    """Fill commands; actions are clipped to [-1, 1]. Whether one of those that count is no number."""
    e = part_at(Episodes, table, _EPISODES)
    count = e.actions.shape[1]
    for row in range(len(e.actions)):
        now = min(max(e.place[row], 0), e.disturbance.shape[1] - 1)
        for k in range(count):
            if not np.isfinite(e.actions[row, k]):
                return True
            e.actions[row, k] = min(max(e.actions[row, k], -1.0), 1.0)
            e.command[row, k] = e.gain[row, k] * e.actions[row, k]
        for k in range(e.disturbance.shape[2]):
            e.command[row, count + k] = e.disturbance[row, now, k]
    return False


@jit
def judge_rows(table: Indices) -> None:
    """Fill rewards and ends of the interval that was done; episodes that are over stay."""
    n, e = part_at(Rules, table, 0).numbers, part_at(Episodes, table, _EPISODES)
    axes, last = e.reference.shape[2] // 4, e.readings.shape[1] - 1
    for row in range(len(e.actions)):
        if e.place[row] < 0 or e.terminated[row] or e.truncated[row]:
            continue
        e.place[row] += 1
        square, effort, change, place = 0.0, 0.0, 0.0, e.place[row]
        for k in range(axes):
            off = e.readings[row, last - axes + k] - e.reference[row, place, 3 * axes + k]
            square += off * off
        error, rms = np.sqrt(square), e.readings[row, last]
        for k in range(e.actions.shape[1]):
            effort += e.actions[row, k] ** 2
            change += (e.actions[row, k] - e.before[row, k]) ** 2
            e.before[row, k] = e.actions[row, k]
        cost = np.log1p((error / n[0]) ** 2 + (rms / n[1]) ** 2)
        e.terms[row, 0], e.terms[row, 1], e.terms[row, 2] = error, rms, cost
        e.terms[row, 3], e.terms[row, 4] = n[4] * effort, n[5] * change
        e.reward[row] = -cost * n[6] - e.terms[row, 3] - e.terms[row, 4]
        if e.failed[row] != 0 or not (error <= n[2] and rms <= n[3]):
            e.terminated[row] = True
            e.reward[row] = n[7] * (n[8] - place + 1.0)
        elif place >= n[8]:
            e.truncated[row] = True


@jit
def look_rows(table: Indices, first: int, end: int, starting: bool) -> None:
    """Fill noisy readings of some rows, and what is seen of them on a straight scale."""
    rules, e = part_at(Rules, table, 0), part_at(Episodes, table, _EPISODES)
    size, width = e.measured.shape[2], e.reference.shape[2]
    rows, z = e.raw.shape[1], np.empty(2 * size + width)
    for row in range(first, end):
        now = max(e.place[row], 0)
        for k in range(size):
            reading = e.readings[row, k] + e.noise[row, now, k]
            if rules.resolution[k] > 0.0:
                reading = rules.resolution[k] * np.rint(reading / rules.resolution[k])
            e.measured[row, 1, k] = reading if starting else e.measured[row, 0, k]
            e.measured[row, 0, k] = reading
            z[k], z[size + k] = reading, e.measured[row, 1, k]
        for k in range(width):
            z[2 * size + k] = e.reference[row, now, k]
        raw = e.raw[row]
        raw[:] = 0.0
        for j in range(z.size):
            for i in range(rows):
                raw[i] += rules.columns[j, i] * z[j]
        for i in range(rows):
            raw[i] /= rules.knee[i]


@jit
def show_rows(table: Indices, first: int, end: int) -> None:
    """Fill observations of some rows from what was looked at, whose scale is bent by now."""
    rules, e = part_at(Rules, table, 0), part_at(Episodes, table, _EPISODES)
    rows, commands = e.raw.shape[1], e.actions.shape[1]
    for row in range(first, end):
        for i in range(rows):
            e.seen[row, i] = min(max(e.raw[row, i] / rules.span[i], -1.0), 1.0)
        for k in range(commands):
            e.seen[row, rows + k] = e.actions[row, k]
        gone = max(e.place[row], 0) * rules.numbers[9] / rules.numbers[10]
        e.seen[row, rows + commands] = 1.0 - 2.0 * gone
