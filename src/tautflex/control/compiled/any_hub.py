"""Intervals of loops around reduced models on any hub, one plant after the other; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.control.compiled.addresses import part_at, width
from tautflex.control.compiled.loop import act, ask, exact, forget, observe
from tautflex.control.compiled.parts import FORCE, INTERVALS, WHEEL, Drives, LinearLoop, LoopState, Sensing
from tautflex.motion.rotations import matrix
from tautflex.numeric import Array, Indices, Mask, jit
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import MOMENTUM, TWIST
from tautflex.reduction.marching.free_hub.hub_mobile import stable
from tautflex.reduction.marching.free_hub.hub_steps import balance, explicit_step, jump, start_hub
from tautflex.reduction.marching.free_hub.hub_work import HubWork
from tautflex.reduction.marching.steps import CHECK_INTERVAL
from tautflex.reduction.marching.work import Work
from tautflex.reduction.polynomial.forces import ReducedArrays, dot

# Where parts begin in the tables of constants and of a plant's own arrays.
_HUB = width(ReducedArrays)
_DRIVES = _HUB + width(HubArrays)
_SENSING = _DRIVES + width(Drives)
_BASE = _SENSING + width(Sensing)
_RIDE = width(Work)
_LOOP = _RIDE + width(HubWork)
_BEFORE = _LOOP + width(LoopState)
_NOW = _BEFORE + width(HubInputs)


@jit
def _copy(one: HubInputs, other: HubInputs) -> None:
    # Loops in place of array expressions, whose shape checks take seconds to compile.
    for i in range(one.load.shape[1]):
        other.load[0, i], other.inside[0, i] = one.load[0, i], one.inside[0, i]
        for a in range(one.arms.shape[1]):
            other.arms[0, a, i] = one.arms[0, a, i]
    for m in range(one.stress.shape[1]):
        other.stress[0, m], other.inside_stress[0, m] = one.stress[0, m], one.inside_stress[0, m]
    for i in range(6):
        other.wrench[0, i] = one.wrench[0, i]


@jit
def _give(d: Drives, base: HubInputs, value: Array, now: HubInputs) -> None:
    """Fill what acts from outside."""
    _copy(base, now)
    for k in range(value.size):
        u = value[k]
        if u == 0.0:
            continue
        for i in range(6):
            now.wrench[0, i] += u * d.wrench[k, i]
        if d.kind[k] == WHEEL:
            continue
        for i in range(now.load.shape[1]):
            now.load[0, i] += u * d.load[k, i]
            now.inside[0, i] += u * d.inside[k, i]
        for m in range(now.stress.shape[1]):
            now.stress[0, m] += u * d.stress[k, m]
            now.inside_stress[0, m] += u * d.inside_stress[k, m]
        if d.kind[k] == FORCE:
            for a in range(d.arms.shape[1]):
                for i in range(now.load.shape[1]):
                    now.arms[0, a, i] += u * d.arms[k, a, i]


@jit
def _pull(d: Drives, arrays: Any, q: Array, y: Array, pull: Array) -> None:
    """Fill the energy that a unit of each number has where the structure is."""
    for m in range(y.size):
        y[m] = q[arrays.first[m]] * q[arrays.second[m]]
    for k in range(d.kind.size):
        if d.kind[k] != WHEEL:
            pull[k] = dot(d.load[k], q) + dot(d.stress[k], y)


@jit
def _count(d: Drives, loop: LoopState, ride: HubWork, q: Array, before: Array, own: Array) -> None:
    """Take in a step on the hub, from a hub (13,) and coordinates to the present ones."""
    step, now, one, other = d.times[1], ride.rigid, matrix(before[:4]), matrix(ride.rigid[:4])
    for k in range(d.kind.size):
        u = loop.value[0, k]
        if u == 0.0:
            continue
        if d.kind[k] == WHEEL:
            a = d.axis[k]
            loop.work[0, k] += 0.5 * step * u * (before[TWIST + 3 + a] + now[TWIST + 3 + a])
            for i in range(3):
                loop.stored[0, k, i] -= 0.5 * step * u * (one[i, a] + other[i, a])
        elif d.kind[k] == FORCE and d.pushing[k] != 0:
            for i in range(6):
                loop.work[0, k] += 0.5 * step * u * d.wrench[k, i] * (before[TWIST + i] + now[TWIST + i])
            for i in range(d.arms.shape[1]):
                way = TWIST + 6 - d.arms.shape[1] + i
                arms = dot(d.arms[k, i], own) * before[way] + dot(d.arms[k, i], q) * now[way]
                loop.work[0, k] += 0.5 * step * u * arms


@jit
def begin(fixed: Indices, own: Indices, fresh: Mask, measurement: Array) -> None:
    """Begin at the coordinates, their velocities and the hub that are there; the first measurement."""
    arrays, hub = part_at(ReducedArrays, fixed, 0), part_at(HubArrays, fixed, _HUB)
    d, s = part_at(Drives, fixed, _DRIVES), part_at(Sensing, fixed, _SENSING)
    base, work, ride = part_at(HubInputs, fixed, _BASE), part_at(Work, own, 0), part_at(HubWork, own, _RIDE)
    loop, now = part_at(LoopState, own, _LOOP), part_at(HubInputs, own, _NOW)
    if not fresh[0]:
        return
    forget(loop, 0)
    work.counts[:], ride.marks[:], ride.work[:], ride.own[:] = 0, 0.0, 0.0, 0.0
    size = d.times[1]
    work.inverse[0] = np.linalg.inv(arrays.mass + 0.5 * size * arrays.damping)
    work.sizes[0] = size
    _give(d, base, loop.value[0], now)
    start_hub(hub, arrays, work, ride)
    balance(arrays, hub, now, 0, work, ride, True)
    reading = np.empty((measurement.shape[1], 1))
    _pull(d, arrays, work.q, ride.at.monomials, loop.pull[0])
    exact(s, arrays.first, arrays.second, work.q, work.v, ride.rigid, loop.value[0], reading[:, 0])
    observe(fixed, _SENSING, own, _LOOP, reading, fresh, True, measurement)


@jit
def run(
    fixed: Indices, own: Indices, around: Indices, follow: Array, command: Array, last: Array, measured: Array
) -> None:
    """Intervals of all plants side by side.

    Parameters
    ----------
    fixed, own, around
        Tables of the constants, of every block of plants (block, any), and of a law.
    follow
        What the law follows at the start of every interval, shape (interval, any).
    command
        Commands, which a law fills, shape (interval, count, c).
    last
        Measurements at the start, then at the end, shape (count, o).
    measured
        Gets those at the end of every interval, shape (interval, count, o), or (0, count, o): not.
    """
    arrays, hub = part_at(ReducedArrays, fixed, 0), part_at(HubArrays, fixed, _HUB)
    d, s = part_at(Drives, fixed, _DRIVES), part_at(Sensing, fixed, _SENSING)
    base, law, size, o = part_at(HubInputs, fixed, _BASE), part_at(LinearLoop, around, 0), d.times[1], last.shape[1]
    rigid, reading, z = np.empty(MOMENTUM), np.empty((o, 1)), np.empty(o + follow.shape[1])
    one = np.ones(1, dtype=np.bool_)
    for n in range(own.shape[0]):
        work, ride = part_at(Work, own[n], 0), part_at(HubWork, own[n], _RIDE)
        loop, before = part_at(LoopState, own[n], _LOOP), part_at(HubInputs, own[n], _BEFORE)
        now, start, pull = part_at(HubInputs, own[n], _NOW), np.empty(work.q.size), np.empty(loop.pull.shape[1])
        for t in range(command.shape[0]):
            place = loop.counts[0, INTERVALS]  # of inputs that hold for all
            if law.C.shape[0]:
                for i in range(z.size):
                    z[i] = last[n, i] if i < o else follow[t, i - o]
                ask(law, n, z, command[t, n])
            if act(fixed, _DRIVES, own[n], _LOOP, matrix(ride.rigid[:4]), command[t, n : n + 1], loop.failed):
                _copy(now, before)
                _give(d, base, loop.value[0], now)
                jump(arrays, hub, before, place, now, place, work, ride, True)
            for k in range(pull.size):
                pull[k] = loop.pull[0, k]
            left = int(d.times[2])
            while left > 0 and loop.failed[0] == 0:
                for k in range(MOMENTUM):
                    rigid[k] = ride.rigid[k]
                for i in range(start.size):
                    start[i] = work.q[i]
                still = work.counts[0] % CHECK_INTERVAL != 0 or stable(arrays, hub, now, place, size, work, ride)
                if not (still and explicit_step(arrays, hub, now, place, size, work, ride)):
                    loop.failed[0] = 1
                else:
                    _count(d, loop, ride, work.q, rigid, start)
                left -= 1
            if loop.failed[0] == 0:
                _pull(d, arrays, work.q, ride.at.monomials, loop.pull[0])
                for k in range(d.kind.size):
                    if d.kind[k] == FORCE:
                        loop.work[0, k] -= loop.value[0, k] * (loop.pull[0, k] - pull[k])
                loop.counts[0, INTERVALS] += 1
                exact(s, arrays.first, arrays.second, work.q, work.v, ride.rigid, loop.value[0], reading[:, 0])
                observe(fixed, _SENSING, own[n], _LOOP, reading, one, False, last[n : n + 1])
            if measured.shape[0]:
                for i in range(o):
                    measured[t, n, i] = last[n, i]
