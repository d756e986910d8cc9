"""Kernels of episodes: commands from actions, rewards from readings, observations from noisy ones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.learning.arena import Arena
from tautflex.numeric import Array, Indices, Mask, jit_in_order


class Rules(NamedTuple):
    """Constants of a task and its loop.

    ``numbers`` are attitude and surface tolerance, attitude and surface limit, effort and change weight, what a cost of
    one is paid, worst reward, steps of an episode, interval and duration; the others as in `Observation`, and the step
    of the numbers of each sensor, shape (measurement,).
    """

    numbers: Array
    limits: Array
    matrix: Array
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
            np.array(numbers, dtype=float), arena.limits, np.ascontiguousarray(seen.matrix), seen.knee, span,
            np.array(resolution, dtype=float),
        )  # fmt: skip


@jit_in_order
def command_rows(command: Array, actions: Array, gain: Array, disturbance: Array, place: Indices) -> bool:
    """Fill commands; actions are clipped to [-1, 1]. Whether one of those that count is no number."""
    count = actions.shape[1]
    for row in range(len(actions)):
        now = min(max(place[row], 0), disturbance.shape[1] - 1)
        for k in range(count):
            if not np.isfinite(actions[row, k]):
                return True
            actions[row, k] = min(max(actions[row, k], -1.0), 1.0)
            command[row, k] = gain[row, k] * actions[row, k]
        for k in range(disturbance.shape[2]):
            command[row, count + k] = disturbance[row, now, k]
    return False


@jit_in_order
def _judge_rows(
    rules: Rules, readings: Array, failed: Indices, place: Indices, actions: Array, before: Array, reward: Array,
    terms: Array, terminated: Mask, truncated: Mask, reference: Array,
) -> None:  # fmt: skip
    """Fill rewards and ends of the interval that was done; episodes that are over stay."""
    n = rules.numbers
    axes, last = reference.shape[2] // 4, readings.shape[1] - 1
    for row in range(len(actions)):
        if place[row] < 0 or terminated[row] or truncated[row]:
            continue
        place[row] += 1
        square, effort, change = 0.0, 0.0, 0.0
        for k in range(axes):
            off = readings[row, last - axes + k] - reference[row, place[row], 3 * axes + k]
            square += off * off
        error, rms = np.sqrt(square), readings[row, last]
        for k in range(actions.shape[1]):
            effort += actions[row, k] ** 2
            change += (actions[row, k] - before[row, k]) ** 2
            before[row, k] = actions[row, k]
        cost = np.log1p((error / n[0]) ** 2 + (rms / n[1]) ** 2)
        terms[row, 0], terms[row, 1], terms[row, 2] = error, rms, cost
        terms[row, 3], terms[row, 4] = n[4] * effort, n[5] * change
        reward[row] = -cost * n[6] - terms[row, 3] - terms[row, 4]
        if failed[row] != 0 or not (error <= n[2] and rms <= n[3]):
            terminated[row] = True
            reward[row] = n[7] * (n[8] - place[row] + 1.0)
        elif place[row] >= n[8]:
            truncated[row] = True


@jit_in_order
def see_rows(
    rules: Rules, first: int, end: int, readings: Array, place: Indices, noise: Array, reference: Array,
    measured: Array, actions: Array, seen: Array, starting: bool,
) -> None:  # fmt: skip
    """Fill observations of some rows: noise on readings, then `Observation`."""
    size, width = measured.shape[2], reference.shape[2]
    rows, z = len(rules.knee), np.empty(2 * measured.shape[2] + reference.shape[2])
    for row in range(first, end):
        now = max(place[row], 0)
        for k in range(size):
            reading = readings[row, k] + noise[row, now, k]
            if rules.resolution[k] > 0.0:
                reading = rules.resolution[k] * np.rint(reading / rules.resolution[k])
            measured[row, 1, k] = reading if starting else measured[row, 0, k]
            measured[row, 0, k] = reading
            z[k], z[size + k] = reading, measured[row, 1, k]
        for k in range(width):
            z[2 * size + k] = reference[row, now, k]
        for i in range(rows):
            total = 0.0
            for j in range(len(z)):
                total += rules.matrix[i, j] * z[j]
            seen[row, i] = min(max(np.arcsinh(total / rules.knee[i]) / rules.span[i], -1.0), 1.0)
        for k in range(actions.shape[1]):
            seen[row, rows + k] = actions[row, k]
        seen[row, rows + actions.shape[1]] = 1.0 - 2.0 * now * rules.numbers[9] / rules.numbers[10]


@jit_in_order
def finish_rows(
    rules: Rules, readings: Array, failed: Indices, place: Indices, actions: Array, before: Array, reward: Array,
    terms: Array, terminated: Mask, truncated: Mask, reference: Array, noise: Array, measured: Array, seen: Array,
) -> None:  # fmt: skip
    """Fill rewards, ends and observations of the interval that was done."""
    _judge_rows(rules, readings, failed, place, actions, before, reward, terms, terminated, truncated, reference)
    see_rows(rules, 0, len(actions), readings, place, noise, reference, measured, actions, seen, False)
