"""Intervals of loops around reduced models on hubs of one axis, a block of plants at a time; compiled."""

from __future__ import annotations

import numpy as np

from tautflex.control.compiled.addresses import part_at, width
from tautflex.control.compiled.axis_parts import ACCELERATION, ANGLE, RATE, AxisModel, AxisSpace, AxisState
from tautflex.control.compiled.axis_steps import (
    Y,
    axis_balance,
    axis_give,
    axis_jump,
    axis_stable,
    axis_step,
    axis_turn,
)
from tautflex.control.compiled.lanes import add, sum_of, times
from tautflex.control.compiled.loop import act, ask, exact, forget, observe
from tautflex.control.compiled.parts import (
    DRAWN,
    FORCE,
    INTERVALS,
    STRESS,
    WHEEL,
    Drives,
    LinearLoop,
    LoopState,
    Sensing,
)
from tautflex.numeric import Array, Indices, Mask, jit
from tautflex.reduction.marching.free_hub.hub_inertia import RATES, TWIST
from tautflex.reduction.marching.steps import CHECK_INTERVAL

# Where parts begin in the tables of constants and of a block's own arrays.
_DRIVES = width(AxisModel)
_SENSING = _DRIVES + width(Drives)
_SPACE = width(AxisState)
_LOOP = _SPACE + width(AxisSpace)


@jit
def _pull(c: AxisModel, q: Array, y: Array, pull: Array, found: Array) -> None:
    """Fill the energy that a unit of each number has where the structure is, shape (n, c)."""
    times(c.pull_load, q, pull)
    add(c.pull_stress, y, pull)
    for n in range(found.shape[0]):
        for k in range(found.shape[1]):
            found[n, k] = pull[k, n]


@jit
def _read(fixed: Indices, own: Indices) -> None:
    """Fill exact readings of all runs, shape (o, n)."""
    c, s = part_at(AxisModel, fixed, 0), part_at(Sensing, fixed, _SENSING)
    at, space, loop = part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE), part_at(LoopState, own, _LOOP)
    r, lanes, numbers, axis = at.q.shape[0], at.q.shape[1], loop.value.shape[1], c.numbers[0]
    seen, reading = space.seen, space.reading
    if c.near.shape[0] == 0:
        _read_far(c, s, at, loop, reading)
        return
    turn = 2 * r + numbers
    for i in range(r):
        for n in range(lanes):
            seen[i, n], seen[r + i, n] = at.q[i, n], at.v[i, n]
    for n in range(lanes):
        for k in range(numbers):
            seen[2 * r + k, n] = loop.value[n, k]
        # Of at most half a turn.
        angle = at.rigid[ANGLE, n]
        seen[turn + axis, n] = angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi))
        seen[turn + 3 + axis, n] = at.rigid[RATE, n]
    for i in range(reading.shape[0]):
        for n in range(lanes):
            reading[i, n] = s.level[i]
    add(c.near, seen, reading)
    if s.rms.size:
        times(s.form, at.q, space.film)
        sum_of(space.film, at.q, space.rigid[0])
        for i in s.rms:
            for n in range(lanes):
                reading[i, n] = reading[i, n] + np.sqrt(max(space.rigid[0, n], 0.0))


@jit
def _read_far(c: AxisModel, s: Sensing, at: AxisState, loop: LoopState, reading: Array) -> None:
    """Fill exact readings that need more than coordinates, one run after the other."""
    r, axis, rigid, found = at.q.shape[0], c.numbers[0], np.zeros(31), np.empty(reading.shape[0])
    q, v = np.empty(r), np.empty(r)
    for n in range(reading.shape[1]):
        for i in range(r):
            q[i], v[i] = at.q[i, n], at.v[i, n]
        rigid[0], rigid[1 + axis] = np.cos(0.5 * at.rigid[ANGLE, n]), np.sin(0.5 * at.rigid[ANGLE, n])
        rigid[TWIST + 3 + axis], rigid[RATES + 3 + axis] = at.rigid[RATE, n], at.rigid[ACCELERATION, n]
        exact(s, c.first, c.second, q, v, rigid, loop.value[n], found)
        for i in range(found.size):
            reading[i, n] = found[i]


@jit
def _value(loop: LoopState, space: AxisSpace) -> None:
    """Fill values of the actuators, behind a row of ones."""
    for n in range(loop.value.shape[0]):
        space.value[0, n] = 1.0
        for k in range(loop.value.shape[1]):
            space.value[1 + k, n] = loop.value[n, k]


@jit
def _tell(loop: LoopState, space: AxisSpace, step: int, steps: int) -> None:
    """Fill what prescribed hubs do in a step of this interval."""
    for n in range(loop.value.shape[0]):
        row = loop.motion[n, loop.counts[n, DRAWN] * steps + step]
        for k in range(row.size):
            space.told[k, n] = row[k]


@jit
def _push(d: Drives, loop: LoopState, failed: Indices) -> None:
    """Begin the work of forces in an interval: they work on the way from here."""
    for k in range(d.kind.size):
        if d.kind[k] == FORCE:
            for n in range(failed.size):
                loop.work[n, k] += loop.value[n, k] * loop.pull[n, k] if failed[n] == 0 else 0.0


@jit
def _count(fixed: Indices, own: Indices, before: Array, failed: Indices) -> None:
    """Take in an interval of hubs that were at some angles; steps add up to it by the trapezoidal rule."""
    c, d = part_at(AxisModel, fixed, 0), part_at(Drives, fixed, _DRIVES)
    at, loop, axis = part_at(AxisState, own, 0), part_at(LoopState, own, _LOOP), c.numbers[0]
    for k in range(d.kind.size):
        if d.kind[k] == STRESS or (d.kind[k] == WHEEL and d.axis[k] != axis):
            continue
        for n in range(failed.size):
            u, turned = loop.value[n, k] if failed[n] == 0 else 0.0, at.rigid[ANGLE, n] - before[n]
            if d.kind[k] == WHEEL:
                loop.work[n, k] += u * turned
                loop.stored[n, k, 0] -= u * d.times[0]
                continue
            loop.work[n, k] -= u * loop.pull[n, k]
            if d.pushing[k] != 0:
                done = c.torque[1 + k, 0] * turned
                for i in range(at.swept.shape[0]):
                    done += c.arms[1 + k, i] * at.swept[i, n]
                loop.work[n, k] += u * done


@jit
def begin(fixed: Indices, own: Indices, fresh: Mask, measurement: Array) -> None:
    """Begin at the coordinates, rates and hubs that are there, in chosen runs; their first measurements."""
    c = part_at(AxisModel, fixed, 0)
    at, space, loop = part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE), part_at(LoopState, own, _LOOP)
    for n in range(fresh.size):
        if fresh[n]:
            forget(loop, n)
            at.counts[n] = 0
    _value(loop, space)
    axis_give(fixed, own)
    axis_balance(fixed, own, fresh)
    _pull(c, at.q, space.on_y[Y], space.pull, loop.pull)
    _read(fixed, own)
    observe(fixed, _SENSING, own, _LOOP, space.reading, fresh, True, measurement)


@jit
def run(
    fixed: Indices, own: Indices, around: Indices, follow: Array, command: Array, last: Array, measured: Array
) -> None:
    """Intervals of all plants, see `any_hub.run`."""
    c, d = part_at(AxisModel, fixed, 0), part_at(Drives, fixed, _DRIVES)
    law, step, o, axes = part_at(LinearLoop, around, 0), d.times[1], last.shape[1], np.zeros((3, 3))
    z, first, axes[0] = np.empty(o + follow.shape[1]), 0, 1.0
    for block in range(own.shape[0]):
        table = own[block]
        at, space = part_at(AxisState, table, 0), part_at(AxisSpace, table, _SPACE)
        loop = part_at(LoopState, table, _LOOP)
        lanes, turned, failed = at.q.shape[1], np.empty(at.q.shape[1]), loop.failed
        going, rows = np.empty(lanes, dtype=np.bool_), slice(first, first + lanes)
        for t in range(command.shape[0]):
            for n in range(lanes):
                if law.C.shape[0]:
                    for i in range(z.size):
                        z[i] = last[first + n, i] if i < o else follow[t, i - o]
                    ask(law, first + n, z, command[t, first + n])
                turned[n] = at.rigid[ANGLE, n]
            if act(fixed, _DRIVES, table, _LOOP, axes, command[t, rows], failed):
                _value(loop, space)
                axis_jump(fixed, table)
            _push(d, loop, failed)
            at.swept[:] = 0.0
            for part in range(int(d.times[2])):
                for n in range(lanes):
                    looks = failed[n] == 0 and at.counts[n] % CHECK_INTERVAL == 0
                    if looks and not axis_stable(fixed, table, n, step):
                        failed[n] = 1
                if c.numbers[2]:
                    _tell(loop, space, part, int(d.times[2]))
                axis_step(fixed, table, step, failed)
                if c.numbers[2]:
                    axis_turn(fixed, table, failed)
            _pull(c, at.q, space.on_y[Y], space.pull, loop.pull)
            _read(fixed, table)
            _count(fixed, table, turned, failed)
            for n in range(lanes):
                going[n] = failed[n] == 0
                loop.counts[n, INTERVALS] += going[n]
            observe(fixed, _SENSING, table, _LOOP, space.reading, going, False, last[rows])
            if measured.shape[0]:
                measured[t, rows] = last[rows]
        first += lanes
