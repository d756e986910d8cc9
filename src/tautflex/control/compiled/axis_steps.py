"""Steps of runs side by side on hubs of one axis: those of `hub_steps`, without books; compiled."""

from __future__ import annotations

import numpy as np

from tautflex.control.compiled.addresses import part_at, width
from tautflex.control.compiled.axis_parts import (
    ACCELERATION,
    ANGLE,
    MOMENTUM,
    RATE,
    TORQUE,
    AxisModel,
    AxisSpace,
    AxisState,
)
from tautflex.control.compiled.lanes import add, add_slopes, add_through, monomials, sum_of, times
from tautflex.numeric import Array, Indices, Mask, jit
from tautflex.reduction.marching.steps import STABLE_SHARE

_SPACE = width(AxisState)
# Place in `AxisSpace.told` of the acceleration behind a step, after those of `AxisState.rigid`.
_BEHIND = ACCELERATION + 1
# Places in `AxisSpace.on_q` and `on_y`.
HALF, Q, V, KNOWN, FREE, PULLS, SOLVED, PULLED, PARTS, COUPLING, SPUN, SPAN, FRAME, ON_Q = range(14)
Y, RATES, STRESS, ON_Y = range(4)
# Turns in which velocity and Coriolis force of a step agree; where the motion is prescribed nothing else is late.
_TURNS, _TURNS_ALONG = 2, 8
# Places in `AxisSpace.rigid`.
_INERTIA, _SHARE, _PUSH, _MOMENTUM, _RATE, _ACCELERATION, _LEFT, _FELT, _MOVING, _REACHED, _BENT, _KEPT = range(12)


@jit
def _place(fixed: Indices, own: Indices) -> None:
    """Fill forces and the hub's inertia at coordinates and rates in the space."""
    c, at, s = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE)
    q, v, y, rates, stress = s.on_q[Q], s.on_q[V], s.on_y[Y], s.on_y[RATES], s.on_y[STRESS]
    parts, coupling, pulls, on_q = s.on_q[PARTS], s.on_q[COUPLING], s.on_q[PULLS], s.on_q[ON_Q]
    r, m, lanes = q.shape[0], y.shape[0], q.shape[1]
    monomials(c.first, c.second, q, v, y, rates)
    for k in range(m):
        for n in range(lanes):
            stress[k, n] = at.stress[k, n]
    add_through(c.fields, c.fields_back, y, s.fields, stress)
    add_through(c.viscous, c.viscous_back, rates, s.fields, stress)
    times(c.linear, q, parts)
    add(c.quadratic, y, parts)
    add_slopes(c.first, c.second, stress, q, parts)
    for i in range(r):
        for n in range(lanes):
            coupling[i, n], pulls[i, n] = c.reach[i], c.pull[i]
    add(c.spin, q, coupling)
    if c.turned.size:
        for k in range(r * r):
            for n in range(lanes):
                s.slope[k, n] = c.turned[k]
        add(c.turning, q, s.slope)
        for i in range(r):
            for j in range(r):
                for n in range(lanes):
                    mean = 0.5 * (c.turned[r * i + j] + s.slope[r * i + j, n])
                    coupling[i, n] = coupling[i, n] + mean * q[j, n]
    add(c.pull_slope, q, pulls)
    inertia, push = s.rigid[_INERTIA], s.rigid[_PUSH]
    inertia[:], push[:] = c.inertia[0], 0.0
    if c.square_follow.shape[1]:
        times(c.square_follow, y, on_q)
        times(c.square_through, q, s.on_y[ON_Y])
        add_slopes(c.first, c.second, s.on_y[ON_Y], q, pulls)
        for i in range(r):
            for n in range(lanes):
                pulls[i, n] = pulls[i, n] + on_q[i, n]
                inertia[n] = inertia[n] + on_q[i, n] * q[i, n]
    for i in range(r):
        for n in range(lanes):
            inertia[n] = inertia[n] - (pulls[i, n] + c.pull[i]) * q[i, n]
            push[n] = push[n] + at.arms[i, n] * q[i, n]
    for n in range(lanes):
        push[n] = push[n] + at.torque[0, n]


@jit
def _frame(slope: Array, v: Array, rate: Array, frame: Array) -> None:
    """Fill ``w (D - D') v``, the Coriolis forces of the monomials."""
    r, lanes = v.shape
    frame[:] = 0.0
    for i in range(r if slope.size else 0):
        for j in range(r):
            for n in range(lanes):
                frame[i, n] = frame[i, n] + (slope[r * i + j, n] - slope[r * j + i, n]) * v[j, n]
        for n in range(lanes):
            frame[i, n] = rate[n] * frame[i, n]


@jit
def _bend(slope: Array, v: Array, result: Array) -> None:
    """Fill ``v' D v``, what the monomials' curvature adds to the rate of a momentum."""
    r, lanes = v.shape
    result[:] = 0.0
    for i in range(r if slope.size else 0):
        for j in range(r):
            for n in range(lanes):
                result[n] = result[n] + slope[r * i + j, n] * v[j, n] * v[i, n]


@jit
def axis_step(fixed: Indices, own: Indices, step: float, failed: Indices) -> None:
    """One step of central differences of all runs; those where it is not stable fail and stay.

    See `hub_steps.explicit_step`. A prescribed hub turns as it is told: see `axis_turn`.
    """
    c, at, s = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE)
    half, q, v, known, free = s.on_q[HALF], s.on_q[Q], s.on_q[V], s.on_q[KNOWN], s.on_q[FREE]
    pulls, solved, pulled, parts = s.on_q[PULLS], s.on_q[SOLVED], s.on_q[PULLED], s.on_q[PARTS]
    coupling, spun, span, frame, on_q = s.on_q[COUPLING], s.on_q[SPUN], s.on_q[SPAN], s.on_q[FRAME], s.on_q[ON_Q]
    inertia, share, push, momentum = s.rigid[_INERTIA], s.rigid[_SHARE], s.rigid[_PUSH], s.rigid[_MOMENTUM]
    rate, acceleration, left, felt = s.rigid[_RATE], s.rigid[_ACCELERATION], s.rigid[_LEFT], s.rigid[_FELT]
    moving, reached, bent = s.rigid[_MOVING], s.rigid[_REACHED], s.rigid[_BENT]
    r, lanes, spins, driven = q.shape[0], q.shape[1], c.spin.shape[1] > 0, c.numbers[2] != 0
    turns = _TURNS if not driven else _TURNS_ALONG if spins else 1
    for i in range(r):
        for n in range(lanes):
            forth = at.v[i, n] + 0.5 * step * at.a[i, n]
            half[i, n] = forth
            q[i, n] = at.q[i, n] + step * forth
            v[i, n] = forth + 0.5 * step * at.a[i, n]
    _place(fixed, own)
    # Stiffness that this very step has felt, against what central differences can follow.
    times(c.mass, half, on_q)
    felt[:], moving[:] = 0.0, 0.0
    sum_of(coupling, half, left)
    for i in range(r):
        for n in range(lanes):
            felt[n] = felt[n] + half[i, n] * (parts[i, n] - at.forces[i, n])
            moving[n] = moving[n] + half[i, n] * on_q[i, n]
    for n in range(lanes):
        moving[n] = moving[n] - (0.0 if driven else left[n] * left[n] / inertia[n])
        rate[n] = s.told[RATE, n] if driven else at.rigid[RATE, n] + step * at.rigid[ACCELERATION, n]
        acceleration[n] = s.told[ACCELERATION, n]
        momentum[n] = at.rigid[MOMENTUM, n] + 0.5 * step * (at.rigid[TORQUE, n] + push[n])
    _frame(s.slope, v, rate, frame)
    times(c.damping, half, known)
    for i in range(r):
        for n in range(lanes):
            known[i, n] = known[i, n] + parts[i, n] + at.load[i, n] + frame[i, n]
    times(c.inverse, known, frame)
    times(c.inverse, pulls, pulled)
    times(c.inverse, coupling, solved)
    sum_of(coupling, solved, share)
    span[:] = 0.0
    for _ in range(turns):
        if spins:
            times(c.spin, v, spun)
            times(c.inverse, spun, span)
        sum_of(coupling, v, reached)
        _bend(s.slope, v, bent)
        sum_of(pulls, v, left)
        for n in range(lanes):
            rate[n] = rate[n] if driven else (momentum[n] - reached[n]) / inertia[n]
            left[n] = push[n] + 2.0 * left[n] * rate[n] - bent[n]
        for i in range(r):
            for n in range(lanes):
                free[i, n] = -(frame[i, n] + rate[n] * (rate[n] * pulled[i, n] + 2.0 * span[i, n]))
                left[n] = left[n] - coupling[i, n] * free[i, n]
        for n in range(0 if driven else lanes):
            acceleration[n] = left[n] / (inertia[n] - share[n])
        for i in range(r):
            for n in range(lanes):
                free[i, n] = free[i, n] - acceleration[n] * solved[i, n]
                v[i, n] = half[i, n] + 0.5 * step * free[i, n]
    sum_of(coupling, v, reached)
    for n in range(lanes):
        if not step * felt[n] <= 4.0 * moving[n] * (1.0 + 1e-9) + 1e-300:
            failed[n] = 1
        rate[n] = rate[n] if driven else (momentum[n] - reached[n]) / inertia[n]
    if c.numbers[1]:
        for i in range(r):
            for n in range(lanes):
                at.swept[i, n] = at.swept[i, n] + 0.5 * step * (at.q[i, n] * at.rigid[RATE, n] + q[i, n] * rate[n])
    for n in range(lanes):
        if failed[n] == 0:
            at.rigid[ANGLE, n] = at.rigid[ANGLE, n] + 0.5 * step * (at.rigid[RATE, n] + rate[n])
            at.rigid[RATE, n], at.rigid[ACCELERATION, n] = rate[n], acceleration[n]
            at.rigid[MOMENTUM, n], at.rigid[TORQUE, n], at.inertia[0, n] = momentum[n], push[n], inertia[n]
    for i in range(r):
        for n in range(lanes):
            stays = failed[n] != 0
            at.q[i, n] = at.q[i, n] if stays else q[i, n]
            at.v[i, n] = at.v[i, n] if stays else v[i, n]
            at.a[i, n] = at.a[i, n] if stays else free[i, n]
            at.forces[i, n] = at.forces[i, n] if stays else parts[i, n]
            at.coupling[i, n] = at.coupling[i, n] if stays else coupling[i, n]
    for n in range(lanes):
        at.counts[n] += 1


@jit
def axis_balance(fixed: Indices, own: Indices, fresh: Mask) -> None:
    """Momentum and accelerations of runs that begin, at their coordinates, rates and hubs; see `hub_steps.balance`."""
    c, at, s = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE)
    known, free, pulls, solved = s.on_q[KNOWN], s.on_q[FREE], s.on_q[PULLS], s.on_q[SOLVED]
    v, coupling, parts, frame, span = s.on_q[V], s.on_q[COUPLING], s.on_q[PARTS], s.on_q[FRAME], s.on_q[SPAN]
    inertia, push, left, bent = s.rigid[_INERTIA], s.rigid[_PUSH], s.rigid[_LEFT], s.rigid[_BENT]
    share, reached, swing = s.rigid[_SHARE], s.rigid[_REACHED], s.rigid[_MOVING]
    rate, r, lanes = at.rigid[RATE], v.shape[0], v.shape[1]
    for i in range(r):
        for n in range(lanes):
            s.on_q[Q, i, n], v[i, n], span[i, n] = at.q[i, n], at.v[i, n], 0.0
    _place(fixed, own)
    _frame(s.slope, v, rate, frame)
    add(c.spin, v, span)
    times(c.damping, v, known)
    for i in range(r):
        for n in range(lanes):
            turned = rate[n] * (rate[n] * pulls[i, n] + 2.0 * span[i, n])
            known[i, n] = known[i, n] + parts[i, n] + at.load[i, n] + frame[i, n] + turned
    times(c.still, known, free)
    times(c.still, coupling, solved)
    _bend(s.slope, v, bent)
    sum_of(pulls, v, swing)
    sum_of(coupling, free, left)
    sum_of(coupling, solved, share)
    sum_of(coupling, v, reached)
    for n in range(lanes):
        if fresh[n]:
            found = push[n] + 2.0 * swing[n] * rate[n] - bent[n] + left[n]
            acceleration = at.rigid[ACCELERATION, n] if c.numbers[2] else found / (inertia[n] - share[n])
            at.rigid[ACCELERATION, n], at.rigid[TORQUE, n] = acceleration, push[n]
            at.rigid[MOMENTUM, n], at.inertia[0, n] = inertia[n] * rate[n] + reached[n], inertia[n]
            for i in range(r):
                at.a[i, n] = -free[i, n] - acceleration * solved[i, n]
                at.forces[i, n], at.coupling[i, n] = parts[i, n], coupling[i, n]


@jit
def axis_give(fixed: Indices, own: Indices) -> None:
    """Fill what acts, from what does so without commands and the values in the space."""
    c, at, s = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE)
    times(c.load, s.value, at.load)
    times(c.stress, s.value, at.stress)
    times(c.torque, s.value, at.torque)
    times(c.arms, s.value, at.arms)


@jit
def axis_jump(fixed: Indices, own: Indices) -> None:
    """Let what acts jump to the values in the space; accelerations take up the change, see `hub_steps.jump`."""
    c, at, s = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE)
    change, free, solved, arms, stress = s.on_q[KNOWN], s.on_q[FREE], s.on_q[SOLVED], s.on_q[ON_Q], s.on_y[STRESS]
    push, left, share, inside = s.rigid[_PUSH], s.rigid[_LEFT], s.rigid[_SHARE], s.on_q[PARTS]
    r, m, lanes = change.shape[0], stress.shape[0], change.shape[1]
    for i in range(r):
        for n in range(lanes):
            change[i, n], arms[i, n], inside[i, n] = -at.load[i, n], -at.arms[i, n], 0.0
    for k in range(m):
        for n in range(lanes):
            stress[k, n] = -at.stress[k, n]
    for n in range(lanes):
        push[n] = -at.torque[0, n]
    axis_give(fixed, own)
    for k in range(m):
        for n in range(lanes):
            stress[k, n] = stress[k, n] + at.stress[k, n]
    add_slopes(c.first, c.second, stress, at.q, inside)
    for n in range(lanes):
        push[n] = push[n] + at.torque[0, n]
    for i in range(r):
        for n in range(lanes):
            change[i, n] = change[i, n] + at.load[i, n] + inside[i, n]
            push[n] = push[n] + (arms[i, n] + at.arms[i, n]) * at.q[i, n]
    times(c.still, change, free)
    times(c.still, at.coupling, solved)
    sum_of(at.coupling, free, left)
    sum_of(at.coupling, solved, share)
    for n in range(lanes):
        at.rigid[TORQUE, n] = at.rigid[TORQUE, n] + push[n]
        left[n] = 0.0 if c.numbers[2] else (push[n] + left[n]) / (at.inertia[0, n] - share[n])
        at.rigid[ACCELERATION, n] = at.rigid[ACCELERATION, n] + left[n]
    for i in range(r):
        for n in range(lanes):
            at.a[i, n] = at.a[i, n] - free[i, n] - left[n] * solved[i, n]
            at.forces[i, n] = at.forces[i, n] + inside[i, n]


@jit
def axis_turn(fixed: Indices, own: Indices, failed: Indices) -> None:
    """Hubs that are prescribed stand as they are told behind a step; coordinates take up jumps of the acceleration."""
    c, at, s = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0), part_at(AxisSpace, own, _SPACE)
    solved, jump, jumps = s.on_q[SOLVED], s.rigid[_LEFT], 0.0
    for n in range(failed.size):
        jump[n] = s.told[_BEHIND, n] - s.told[ACCELERATION, n] if failed[n] == 0 else 0.0
        jumps += abs(jump[n])
        if failed[n] == 0:
            at.rigid[ANGLE, n], at.rigid[RATE, n] = s.told[ANGLE, n], s.told[RATE, n]
            at.rigid[ACCELERATION, n] = s.told[_BEHIND, n]
    if jumps == 0.0:
        return
    times(c.still, at.coupling, solved)
    for i in range(at.a.shape[0]):
        for n in range(failed.size):
            at.a[i, n] = at.a[i, n] - jump[n] * solved[i, n]


@jit
def _stiffness(c: AxisModel, q: Array, given: Array, n: int) -> Array:
    """Tangent of the internal force of a run, see `polynomial.forces.tangent`, shape (r, r)."""
    r, m = q.size, c.first.size
    result, moved, stress = c.linear.T.copy(), np.empty(r), np.empty(m)
    for k in range(m):
        stress[k] = given[k, n]
    for number in range(c.root.shape[0]):
        field, strain = c.root[number], _slope(c.first, c.second, c.root[number], q, moved)
        for k in range(m):
            stress[k] += strain * field[k]
        for i in range(r):
            for j in range(r):
                result[i, j] += moved[i] * moved[j]
    for k in range(m):
        i, j = c.first[k], c.second[k]
        result[i, j] += stress[k]
        result[j, i] += stress[k]
        for number in range(c.quadratic.shape[1]):
            result[number, i] += c.quadratic[k, number] * q[j]
            result[number, j] += c.quadratic[k, number] * q[i]
    return result


@jit
def _slope(first: Indices, second: Indices, field: Array, q: Array, moved: Array) -> float:
    """Fill the derivatives of a field of the monomials; the field."""
    moved[:] = 0.0
    total = 0.0
    for k in range(field.size):
        i, j = first[k], second[k]
        one, other = field[k] * q[i], field[k] * q[j]
        moved[i] += other
        moved[j] += one
        total += one * q[j]
    return total


@jit
def axis_stable(fixed: Indices, own: Indices, n: int, step: float) -> bool:
    """Whether central differences follow the stiffness, and the lagged damping, of a run; see `hub_mobile.stable`."""
    c, at = part_at(AxisModel, fixed, 0), part_at(AxisState, own, 0)
    r = at.q.shape[0]
    q, coupling = np.empty(r), np.empty(r)
    for i in range(r):
        q[i], coupling[i] = at.q[i, n], 0.0 if c.numbers[2] else at.coupling[i, n]
    size, stress, stiff, lagged, share, limit = 0.0, 0.0, 0.0, 0.0, 0.0, STABLE_SHARE * 4.0 / (step * step)
    for i in range(r):
        size += q[i] * q[i]
        for j in range(r):
            stiff += q[i] * q[j] * c.stiffening[i, j]
            lagged += q[i] * q[j] * c.lagging[i, j]
            share += coupling[i] * coupling[j] * c.still[i, j]
    if not step * lagged <= STABLE_SHARE:
        return False
    for k in range(c.first.size):
        stress += at.stress[k, n] * at.stress[k, n]
    # Eigenvalues of a sum are at most the sum of the largest ones, and most often that is enough.
    stiff += c.bounds[0] + c.bounds[1] * np.sqrt(stress) + c.bounds[2] * np.sqrt(size) + c.bounds[3] * size
    if stiff * at.inertia[0, n] <= limit * (at.inertia[0, n] - share):
        return True
    matrix, moving = _stiffness(c, q, at.stress, n), c.mass.copy()
    for i in range(r):
        for j in range(r):
            moving[i, j] -= coupling[i] * coupling[j] / at.inertia[0, n]
    lower = np.linalg.cholesky(moving)
    half = np.linalg.solve(lower, matrix)
    return np.linalg.eigvalsh(np.linalg.solve(lower, half.T))[-1] <= limit
