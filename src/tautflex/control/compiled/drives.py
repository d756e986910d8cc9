"""Drives and effects of a reduced model's actuators as arrays, one row for each number of a command."""

from __future__ import annotations

import numpy as np

from tautflex.control.actuators.bank import Bank
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.control.actuators.monitor import Monitor
from tautflex.control.compiled.parts import FORCE, STRESS, Drives
from tautflex.mechanics.loads.prepared import FilmPressure, PatternLoad, StressChange
from tautflex.numeric import Array
from tautflex.reduction.marching.free_hub.hub_run import HubRun


def drives_of(run: HubRun, bank: Bank, monitor: Monitor, times: Array) -> Drives:
    """Constants of all numbers of a command."""
    total, r, m = bank.size, run.rom.size, run.rom.monomial_count
    none, inputs = np.full(total, np.inf), run.inputs
    limit, rate, momentum, lowest = none.copy(), none.copy(), none.copy(), -none
    lag, resolution, (own, whole) = np.zeros(total), np.zeros(total), np.zeros((2, total, total))
    watched = np.full(total, -1)
    kind, axis, delay, pushing = np.zeros((4, total), dtype=np.int64)
    load, inside = np.zeros((2, total, r))
    stress, pulled = np.zeros((2, total, m))
    wrench, arms = np.zeros((total, 6)), np.zeros((total, 6 if inputs.followers else 3, r))
    first = used = 0
    stresses: list[int] = []
    count = sum(d.bound.count for d in bank.items if d.bound is not None)
    each_load, each_stress = inputs.driven(np.eye(count)) if count else (load[:0], stress[:0])
    for item in bank.items:
        drive, n = item.drive, item.channel.size
        own_places = slice(first, first + n)
        first += n
        limit[own_places] = np.inf if drive.limit is None else drive.limit
        rate[own_places] = np.inf if drive.rate is None else drive.rate
        lag[own_places], resolution[own_places] = drive.lag, drive.resolution
        delay[own_places] = len(item.memory.waiting)
        if isinstance(drive, HubTorque):
            axis[own_places] = drive.rows.argmax(axis=1)
            wrench[own_places, 3:] = drive.rows
            momentum[own_places] = np.inf if drive.momentum is None else drive.momentum
            continue
        bound, given = item.bound, slice(used, used + n)
        assert bound is not None
        used += n
        load[own_places], stress[own_places] = each_load[given], each_stress[given]
        lowest[own_places] = bound.lowest
        if isinstance(bound, StressChange):
            kind[own_places] = STRESS
            stresses += range(own_places.start, own_places.stop)
            if drive.monitor:
                watched[own_places], whole[own_places, own_places] = own_places.start, monitor.own[item.channel.name]
        elif isinstance(bound, PatternLoad):
            kind[own_places], pushing[own_places] = FORCE, not bound.internal
            if not bound.internal:
                wrench[own_places] = bound.held.T + bound.pattern.T @ run.to_wrench
                arms[own_places, -3:] = (bound.pattern.T @ run.to_arms).reshape(n, 3, r)
        elif isinstance(bound, FilmPressure):
            kind[own_places], pushing[own_places] = FORCE, 1
            wrench[own_places], arms[own_places] = run.pushed_by(bound.unit)
    if stresses:
        inside[stresses], pulled[stresses] = inputs.beta, inputs.stress
        own[np.ix_(stresses, stresses)] = inputs.own
    return Drives(
        limit, rate, lag, resolution, lowest, momentum, kind, axis, delay, pushing, load, stress, inside, pulled,
        wrench, arms, own, whole, watched, times,
    )  # fmt: skip
