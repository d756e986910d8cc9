"""One interval of a loop around a reduced model on its hub: drives, steps, sensors; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.control.actuators.monitor import PERIODS, SHARE
from tautflex.control.compiled.addresses import part_at, width
from tautflex.control.compiled.parts import (
    DRAWN,
    FAILED,
    FORCE,
    INTERVALS,
    STRESS,
    WHEEL,
    Drives,
    LinearLoop,
    LoopState,
    Sensing,
)
from tautflex.motion.rotations import matrix
from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import MOMENTUM, RATES, TWIST
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
def _clipped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@jit
def _driven(d: Drives, loop: LoopState, k: int, command: float) -> float:
    """What a drive makes of a command, see `Drive.act`; its memory moves on."""
    interval, target = d.times[0], command
    if d.delay[k] > 0:
        place = loop.counts[INTERVALS] % d.delay[k]
        target = loop.waiting[k, place]
        loop.waiting[k, place] = command
    if d.resolution[k] > 0.0:
        target = d.resolution[k] * np.rint(target / d.resolution[k])
    target = _clipped(target, -d.limit[k], d.limit[k])
    reach = d.rate[k] * interval
    target = loop.target[k] + _clipped(target - loop.target[k], -reach, reach)
    loop.target[k] = target
    if d.lag[k] == 0.0:
        loop.output[k] = target
        return target
    left, decay = loop.output[k] - target, np.exp(-interval / d.lag[k])
    loop.output[k] = target + decay * left
    return target + left * d.lag[k] / interval * (1.0 - decay)


@jit
def _command(d: Drives, loop: LoopState, rigid: Array, command: Array) -> bool:
    """Fill what acts in the next interval, and the work that new stresses do; whether it is another than before."""
    changed, pumped = False, np.zeros(command.size)
    for k in range(command.size):
        own = d.watched[k]
        told = 0.0 if own >= 0 and loop.watch[own, 3] >= PERIODS else command[k]
        value = loop.gain[k] * _driven(d, loop, k, told) + loop.offset[k]
        if d.kind[k] == WHEEL:
            if d.momentum[k] < np.inf:
                stored, axes = 0.0, matrix(rigid[:4])
                for i in range(3):
                    stored += axes[i, d.axis[k]] * loop.stored[k, i]
                low, high = (stored - d.momentum[k]) / d.times[0], (stored + d.momentum[k]) / d.times[0]
                value = _clipped(value, min(low, 0.0), max(high, 0.0))
        else:
            value = max(value, d.lowest[k])
        change = value - loop.value[k]
        if change == 0.0:
            continue
        changed = True
        if d.kind[k] == STRESS:
            at_once = dot(d.own[k], loop.value)
            loop.work[k] += change * (loop.pull[k] + at_once + 0.5 * d.own[k, k] * change)
            if own >= 0:
                pumped[own] += change * (loop.pull[k] + at_once - dot(d.whole[k], loop.value))
        loop.value[k] = value
    for k in range(command.size):
        if d.watched[k] == k and loop.watch[k, 3] < PERIODS:
            _watch(loop.watch[k], pumped[k], d.times[3])
    return changed


@jit
def _watch(watch: Array, work: float, window: float) -> None:
    """One interval later, see `Watch.seen`."""
    watch[0] += 1.0
    watch[1] += work
    watch[2] += abs(work)
    if watch[0] >= window:
        watch[3] = watch[3] + 1.0 if watch[2] > 0.0 and watch[1] >= SHARE * watch[2] else 0.0
        watch[:3] = 0.0


@jit
def _copy(one: HubInputs, other: HubInputs) -> None:
    # Loops in place of array expressions, whose shape checks take seconds to compile.
    for i in range(one.load.shape[1]):
        other.load[0, i], other.inside[0, i] = one.load[0, i], one.inside[0, i]
        for a in range(3):
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
            for a in range(3):
                for i in range(now.load.shape[1]):
                    now.arms[0, a, i] += u * d.arms[k, a, i]


@jit
def _pull(d: Drives, arrays: Any, q: Array, y: Array, loop: LoopState) -> None:
    """Fill the energy that a unit of each number has where the structure is."""
    for m in range(y.size):
        y[m] = q[arrays.first[m]] * q[arrays.second[m]]
    for k in range(d.kind.size):
        if d.kind[k] != WHEEL:
            loop.pull[k] = dot(d.load[k], q) + dot(d.stress[k], y)


@jit
def _count(d: Drives, loop: LoopState, ride: HubWork, q: Array, before: Array, own: Array) -> None:
    """Take in a step on the hub, from a hub (13,) and coordinates to the present ones."""
    step, now, one, other = d.times[1], ride.rigid, matrix(before[:4]), matrix(ride.rigid[:4])
    for k in range(d.kind.size):
        u = loop.value[k]
        if u == 0.0:
            continue
        if d.kind[k] == WHEEL:
            a = d.axis[k]
            loop.work[k] += 0.5 * step * u * (before[TWIST + 3 + a] + now[TWIST + 3 + a])
            for i in range(3):
                loop.stored[k, i] -= 0.5 * step * u * (one[i, a] + other[i, a])
        elif d.kind[k] == FORCE and d.pushing[k] != 0:
            for i in range(6):
                loop.work[k] += 0.5 * step * u * d.wrench[k, i] * (before[TWIST + i] + now[TWIST + i])
            for i in range(3):
                arms = dot(d.arms[k, i], own) * before[TWIST + 3 + i] + dot(d.arms[k, i], q) * now[TWIST + 3 + i]
                loop.work[k] += 0.5 * step * u * arms


@jit
def _turn(attitude: Array, turn: Array) -> None:
    """Rotation vector of a unit quaternion, of at most half a turn [rad]."""
    sign = 1.0 if attitude[0] >= 0.0 else -1.0
    sine = np.sqrt(attitude[1] ** 2 + attitude[2] ** 2 + attitude[3] ** 2)
    share = 2.0 * sign
    if sine > 0.0:
        share = 2.0 * sign * np.arctan2(sine, sign * attitude[0]) / sine
    for i in range(3):
        turn[i] = share * attitude[1 + i]


@jit
def _exact(s: Sensing, arrays: Any, work: Work, ride: HubWork, value: Array, reading: Array) -> None:
    """Fill exact readings of the present state."""
    r, m, rigid = work.q.size, arrays.first.size, ride.rigid
    z, rates, turn = np.empty(s.look.shape[1]), np.empty(r + m), np.empty(3)
    for i in range(r):
        z[i], rates[i] = work.q[i], work.v[i]
    for k in range(m):
        i, j = arrays.first[k], arrays.second[k]
        z[r + k], rates[r + k] = work.q[i] * work.q[j], work.q[i] * work.v[j] + work.v[i] * work.q[j]
    for k in range(value.size):
        z[r + m + k] = value[k]
    _frame(rigid, z[r + m + value.size :])
    _turn(rigid, turn)
    spin = rigid[TWIST + 3 : MOMENTUM]
    for n in range(reading.size):
        reading[n] = s.level[n] + dot(s.look[n], z) + dot(s.speed[n], rates)
        reading[n] += dot(s.rotation[n], turn) + dot(s.rate[n], spin)
    if s.rms.size:
        square = 0.0
        for i in range(s.form.shape[0]):
            square += z[i] * dot(s.form[i], z[: s.form.shape[0]])
        for n in s.rms:
            reading[n] += np.sqrt(max(square, 0.0))
    gradient = np.empty(s.line.shape[1])
    for t in range(s.reading.size):
        for i in range(gradient.size):
            gradient[i] = dot(s.gradients[t, i], z)
        found = dot(s.line[t], gradient)
        for i in range(gradient.size):
            found += gradient[i] * dot(s.bend[t, i], gradient)
        reading[s.reading[t]] += found


@jit
def _frame(rigid: Array, found: Array) -> None:
    """Fill ``S(dw) + S(w)^2`` and the acceleration of the origin, shape (12,)."""
    w, t = rigid[TWIST + 3 : MOMENTUM], rigid[RATES + 3 :]
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    for i in range(3):
        for j in range(3):
            found[3 * i + j] = w[i] * w[j] - (square if i == j else 0.0)
        found[9 + i] = rigid[RATES + i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        found[3 * j + k] -= t[i]
        found[3 * k + j] += t[i]


@jit
def _observe(s: Sensing, loop: LoopState, reading: Array, first: bool, measurement: Array) -> None:
    """Fill what sensors make of exact readings, see `Sensor.observe`."""
    draw = loop.counts[DRAWN]
    for n in range(reading.size):
        past, last = loop.past[n], s.kept[n] - 1
        for j in range(last, 0, -1):
            past[j] = reading[n] if first else past[j - 1]
        past[0] = reading[n]
        older = max(last - 1, 0)
        share = max(0.0, s.age[n] - older) if last > 0 else 0.0
        found = past[last] * share + past[older] * (1.0 - share) + s.bias[n] + s.noise[n] * loop.draws[draw, n]
        if s.resolution[n] > 0.0:
            found = s.resolution[n] * np.rint(found / s.resolution[n])
        measurement[n] = found
    loop.counts[DRAWN] = draw + 1


@jit
def begin(fixed: Indices, own: Indices, measurement: Array) -> None:
    """Begin at the coordinates, their velocities and the hub that are there; the first measurement."""
    arrays, hub = part_at(ReducedArrays, fixed, 0), part_at(HubArrays, fixed, _HUB)
    d, s = part_at(Drives, fixed, _DRIVES), part_at(Sensing, fixed, _SENSING)
    base, work, ride = part_at(HubInputs, fixed, _BASE), part_at(Work, own, 0), part_at(HubWork, own, _RIDE)
    loop, now = part_at(LoopState, own, _LOOP), part_at(HubInputs, own, _NOW)
    for part in (loop.waiting, loop.stored, loop.watch):
        part[:] = 0.0
    for part in (loop.target, loop.output, loop.work, ride.work):
        part[:] = 0.0
    loop.value[:], loop.counts[:], work.counts[:], ride.marks[:] = loop.offset, 0, 0, 0.0
    ride.own[:] = 0.0
    size = d.times[1]
    work.inverse[0] = np.linalg.inv(arrays.mass + 0.5 * size * arrays.damping)
    work.sizes[0] = size
    _give(d, base, loop.value, now)
    start_hub(hub, arrays, work, ride)
    balance(arrays, hub, now, loop.counts[INTERVALS], work, ride, True)
    reading = np.empty(measurement.size)
    _pull(d, arrays, work.q, ride.at.monomials, loop)
    _exact(s, arrays, work, ride, loop.value, reading)
    _observe(s, loop, reading, True, measurement)


@jit
def _ask(law: LinearLoop, n: int, z: Array, command: Array) -> None:
    """Fill the command of a linear law for plant n, whose state moves on."""
    x = law.x[n]
    for i in range(command.size):
        command[i] = law.d[i] + dot(law.C[i], x) + dot(law.D[i], z)
    now = x.copy()
    for i in range(x.size):
        x[i] = law.b[i] + dot(law.A[i], now) + dot(law.B[i], z)


@jit
def run(
    fixed: Indices, own: Indices, around: Indices, follow: Array, command: Array, last: Array, measured: Array
) -> None:
    """Intervals of all plants side by side.

    Parameters
    ----------
    fixed, own, around
        Tables of the constants, of every plant (count, any), and of a law.
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
    rigid, reading, z = np.empty(MOMENTUM), np.empty(o), np.empty(o + follow.shape[1])
    for n in range(own.shape[0]):
        work, ride = part_at(Work, own[n], 0), part_at(HubWork, own[n], _RIDE)
        loop, before = part_at(LoopState, own[n], _LOOP), part_at(HubInputs, own[n], _BEFORE)
        now, start, pull = part_at(HubInputs, own[n], _NOW), np.empty(work.q.size), np.empty(loop.pull.size)
        for t in range(command.shape[0]):
            place = loop.counts[INTERVALS]  # of inputs that hold for all
            if law.C.shape[0]:
                for i in range(z.size):
                    z[i] = last[n, i] if i < o else follow[t, i - o]
                _ask(law, n, z, command[t, n])
            if loop.counts[FAILED] == 0 and _command(d, loop, ride.rigid, command[t, n]):
                _copy(now, before)
                _give(d, base, loop.value, now)
                jump(arrays, hub, before, place, now, place, work, ride, True)
            for k in range(pull.size):
                pull[k] = loop.pull[k]
            left = int(d.times[2])
            while left > 0 and loop.counts[FAILED] == 0:
                for k in range(MOMENTUM):
                    rigid[k] = ride.rigid[k]
                for i in range(start.size):
                    start[i] = work.q[i]
                still = work.counts[0] % CHECK_INTERVAL != 0 or stable(arrays, hub, now, place, size, work, ride)
                if not (still and explicit_step(arrays, hub, now, place, size, work, ride)):
                    loop.counts[FAILED] = 1
                else:
                    _count(d, loop, ride, work.q, rigid, start)
                left -= 1
            if loop.counts[FAILED] == 0:
                _pull(d, arrays, work.q, ride.at.monomials, loop)
                for k in range(d.kind.size):
                    if d.kind[k] == FORCE:
                        loop.work[k] -= loop.value[k] * (loop.pull[k] - pull[k])
                loop.counts[INTERVALS] += 1
                _exact(s, arrays, work, ride, loop.value, reading)
                _observe(s, loop, reading, False, last[n])
            if measured.shape[0]:
                for i in range(o):
                    measured[t, n, i] = last[n, i]
