"""Drives and sensors of compiled loops: one run of a block, whatever moves the structure."""

from __future__ import annotations

import numpy as np

from tautflex.control.actuators.monitor import PERIODS, SHARE
from tautflex.control.compiled.parts import DRAWN, INTERVALS, STRESS, WHEEL, Drives, LinearLoop, LoopState, Sensing
from tautflex.numeric import Array, Indices, jit
from tautflex.reduction.marching.free_hub.hub_inertia import MOMENTUM, RATES, TWIST
from tautflex.reduction.polynomial.forces import dot


@jit
def _clipped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@jit
def _driven(d: Drives, loop: LoopState, n: int, k: int, command: float) -> float:
    """What a drive makes of a command, see `Drive.act`; its memory moves on."""
    interval, target = d.times[0], command
    if d.delay[k] > 0:
        place = loop.counts[n, INTERVALS] % d.delay[k]
        target = loop.waiting[n, k, place]
        loop.waiting[n, k, place] = command
    if d.resolution[k] > 0.0:
        target = d.resolution[k] * np.rint(target / d.resolution[k])
    target = _clipped(target, -d.limit[k], d.limit[k])
    reach = d.rate[k] * interval
    target = loop.target[n, k] + _clipped(target - loop.target[n, k], -reach, reach)
    loop.target[n, k] = target
    if d.lag[k] == 0.0:
        loop.output[n, k] = target
        return target
    left, decay = loop.output[n, k] - target, np.exp(-interval / d.lag[k])
    loop.output[n, k] = target + decay * left
    return target + left * d.lag[k] / interval * (1.0 - decay)


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
def act(d: Drives, loop: LoopState, n: int, axes: Array, command: Array) -> bool:
    """Fill what acts in the next interval, and the work that new stresses do; whether it is another than before.

    Rows of ``axes`` are those in which momenta of wheels are kept, columns those of the hub, shape (3, 3).
    """
    changed, value = False, loop.value[n]
    for k in range(command.size):
        loop.pumped[n, k] = 0.0
    for k in range(command.size):
        own = d.watched[k]
        told = 0.0 if own >= 0 and loop.watch[n, own, 3] >= PERIODS else command[k]
        found = loop.gain[n, k] * _driven(d, loop, n, k, told) + loop.offset[n, k]
        if d.kind[k] == WHEEL:
            if d.momentum[k] < np.inf:
                stored = 0.0
                for i in range(3):
                    stored += axes[i, d.axis[k]] * loop.stored[n, k, i]
                low, high = (stored - d.momentum[k]) / d.times[0], (stored + d.momentum[k]) / d.times[0]
                found = _clipped(found, min(low, 0.0), max(high, 0.0))
        else:
            found = max(found, d.lowest[k])
        change = found - value[k]
        if change == 0.0:
            continue
        changed = True
        if d.kind[k] == STRESS:
            at_once = dot(d.own[k], value)
            loop.work[n, k] += change * (loop.pull[n, k] + at_once + 0.5 * d.own[k, k] * change)
            if own >= 0:
                loop.pumped[n, own] += change * (loop.pull[n, k] + at_once - dot(d.whole[k], value))
        value[k] = found
    for k in range(command.size):
        if d.watched[k] == k and loop.watch[n, k, 3] < PERIODS:
            _watch(loop.watch[n, k], loop.pumped[n, k], d.times[3])
    return changed


@jit
def turn_of(attitude: Array, turn: Array) -> None:
    """Rotation vector of a unit quaternion, of at most half a turn [rad]."""
    sign = 1.0 if attitude[0] >= 0.0 else -1.0
    sine = np.sqrt(attitude[1] ** 2 + attitude[2] ** 2 + attitude[3] ** 2)
    share = 2.0 * sign
    if sine > 0.0:
        share = 2.0 * sign * np.arctan2(sine, sign * attitude[0]) / sine
    for i in range(3):
        turn[i] = share * attitude[1 + i]


@jit
def _fill_frame(rigid: Array, found: Array) -> None:
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
def exact(
    s: Sensing, first: Indices, second: Indices, q: Array, v: Array, rigid: Array, value: Array, reading: Array
) -> None:
    """Fill exact readings of coordinates, their rates and a hub (31,)."""
    r, m = q.size, first.size
    z, rates, turn = np.empty(s.look.shape[1]), np.empty(r + m), np.empty(3)
    for i in range(r):
        z[i], rates[i] = q[i], v[i]
    for k in range(m):
        i, j = first[k], second[k]
        z[r + k], rates[r + k] = q[i] * q[j], q[i] * v[j] + v[i] * q[j]
    for k in range(value.size):
        z[r + m + k] = value[k]
    _fill_frame(rigid, z[r + m + value.size :])
    turn_of(rigid, turn)
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
def observe(s: Sensing, loop: LoopState, number: int, reading: Array, first: bool, measurement: Array) -> None:
    """Fill what sensors make of exact readings, see `Sensor.observe`."""
    draw = loop.counts[number, DRAWN]
    for n in range(reading.size):
        past, last = loop.past[number, n], s.kept[n] - 1
        for j in range(last, 0, -1):
            past[j] = reading[n] if first else past[j - 1]
        past[0] = reading[n]
        older = max(last - 1, 0)
        share = max(0.0, s.age[n] - older) if last > 0 else 0.0
        found = past[last] * share + past[older] * (1.0 - share) + s.bias[n] + s.noise[n] * loop.draws[number, draw, n]
        if s.resolution[n] > 0.0:
            found = s.resolution[n] * np.rint(found / s.resolution[n])
        measurement[n] = found
    loop.counts[number, DRAWN] = draw + 1


@jit
def ask(law: LinearLoop, n: int, z: Array, command: Array) -> None:
    """Fill the command of a linear law for plant n, whose state moves on."""
    x = law.x[n]
    for i in range(command.size):
        command[i] = law.d[i] + dot(law.C[i], x) + dot(law.D[i], z)
    now = x.copy()
    for i in range(x.size):
        x[i] = law.b[i] + dot(law.A[i], now) + dot(law.B[i], z)


@jit
def forget(loop: LoopState, n: int) -> None:
    """Begin anew."""
    for part in (loop.waiting[n], loop.stored[n], loop.watch[n]):
        part[:] = 0.0
    for part in (loop.target[n], loop.output[n], loop.work[n], loop.pull[n]):
        part[:] = 0.0
    loop.value[n], loop.counts[n] = loop.offset[n], 0
