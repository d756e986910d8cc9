"""Drives and sensors of compiled loops: one run of a block, whatever moves the structure."""

from __future__ import annotations

import numpy as np

from tautflex.control.actuators.monitor import PERIODS, SHARE
from tautflex.control.compiled.addresses import part_at
from tautflex.control.compiled.parts import DRAWN, INTERVALS, STRESS, WHEEL, Drives, LinearLoop, LoopState, Sensing
from tautflex.numeric import Array, Indices, Mask, jit
from tautflex.reduction.marching.free_hub.hub_inertia import MOMENTUM, RATES, TWIST
from tautflex.reduction.polynomial.forces import dot


@jit
def _clipped(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@jit
def _drive(fixed: Indices, drives: int, own: Indices, place: int, command: Array, failed: Indices) -> None:
    """Fill what drives make of commands, see `Drive.act`; their memory moves on."""
    d, loop = part_at(Drives, fixed, drives), part_at(LoopState, own, place)
    interval = d.times[0]
    for n in range(failed.size):
        if failed[n] != 0:
            continue
        for k in range(command.shape[1]):
            watched = d.watched[k]
            asked = 0.0 if watched >= 0 and loop.watch[n, watched, 3] >= PERIODS else command[n, k]
            if d.delay[k] > 0:
                turn = loop.counts[n, INTERVALS] % d.delay[k]
                late = loop.waiting[n, k, turn]
                loop.waiting[n, k, turn] = asked
                asked = late
            if d.resolution[k] > 0.0:
                asked = d.resolution[k] * np.rint(asked / d.resolution[k])
            asked = _clipped(asked, -d.limit[k], d.limit[k])
            reach = d.rate[k] * interval
            target = loop.target[n, k] + _clipped(asked - loop.target[n, k], -reach, reach)
            left, given = loop.output[n, k] - target, target
            loop.target[n, k] = loop.output[n, k] = target
            if d.lag[k] > 0.0:
                decay = np.exp(-interval / d.lag[k])
                loop.output[n, k] = target + decay * left
                given = target + left * d.lag[k] / interval * (1.0 - decay)
            loop.given[n, k] = loop.gain[n, k] * given + loop.offset[n, k]


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
def act(fixed: Indices, drives: int, own: Indices, place: int, axes: Array, command: Array, failed: Indices) -> bool:
    """Fill what acts in the next interval, and the work that new stresses do; whether it is another than before.

    Parts of drives and loops begin at these places of the tables. Rows of ``axes`` are those in which momenta of wheels
    are kept, columns those of the hub, shape (3, 3). Commands have shape (n, c); loops that failed stay.
    """
    _drive(fixed, drives, own, place, command, failed)
    d, loop, changed = part_at(Drives, fixed, drives), part_at(LoopState, own, place), False
    for n in range(failed.size):
        if failed[n] != 0:
            continue
        value = loop.value[n]
        for k in range(value.size):
            watched, found = d.watched[k], loop.given[n, k]
            loop.pumped[n, k] = 0.0
            if d.kind[k] != WHEEL:
                found = max(found, d.lowest[k])
            elif d.momentum[k] < np.inf:
                stored = 0.0
                for i in range(3):
                    stored += axes[i, d.axis[k]] * loop.stored[n, k, i]
                low, high = (stored - d.momentum[k]) / d.times[0], (stored + d.momentum[k]) / d.times[0]
                found = _clipped(found, min(low, 0.0), max(high, 0.0))
            change = found - value[k]
            if change == 0.0:
                continue
            changed = True
            if d.kind[k] == STRESS:
                at_once = dot(d.own[k], value)
                loop.work[n, k] += change * (loop.pull[n, k] + at_once + 0.5 * d.own[k, k] * change)
                if watched >= 0:
                    loop.pumped[n, watched] += change * (loop.pull[n, k] + at_once - dot(d.whole[k], value))
            value[k] = found
        for k in range(value.size):
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
def observe(
    fixed: Indices,
    sensing: int,
    own: Indices,
    place: int,
    reading: Array,
    chosen: Mask,
    first: bool,
    measurement: Array,
) -> None:
    """Fill what sensors make of exact readings (o, n) in chosen loops, see `Sensor.observe`."""
    s, loop = part_at(Sensing, fixed, sensing), part_at(LoopState, own, place)
    for n in range(chosen.size):
        if not chosen[n]:
            continue
        draw = loop.counts[n, DRAWN]
        for k in range(reading.shape[0]):
            found, last = reading[k, n], s.kept[k] - 1
            if last > 0:
                past = loop.past[n, k]
                for j in range(last, 0, -1):
                    past[j] = found if first else past[j - 1]
                past[0] = found
                share = max(0.0, s.age[k] - (last - 1))
                found = past[last] * share + past[last - 1] * (1.0 - share)
            found += s.bias[k] + s.noise[k] * loop.draws[n, draw, k]
            if s.resolution[k] > 0.0:
                found = s.resolution[k] * np.rint(found / s.resolution[k])
            measurement[n, k] = found
        loop.counts[n, DRAWN] = draw + 1


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
    loop.value[n], loop.counts[n], loop.failed[n] = loop.offset[n], 0, 0
