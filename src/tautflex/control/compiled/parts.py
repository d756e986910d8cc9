"""What a compiled loop knows of drives and sensors, and what it remembers of them; plain arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.numeric import Array, Indices

# Kinds of what a number of a command acts by; places in `LoopState.counts`.
WHEEL, FORCE, STRESS = range(3)
INTERVALS, DRAWN = range(2)


class Drives(NamedTuple):
    """Constants of the c numbers of a command, for r coordinates and m monomials.

    Parameters
    ----------
    limit, rate, lag, resolution, lowest, momentum
        As of `Drive`, `LinearInput` and `HubTorque`, shape (c,); infinite: none.
    kind
        WHEEL, FORCE or STRESS, shape (c,).
    axis
        Of wheels, shape (c,).
    delay
        Intervals until a command acts, shape (c,).
    pushing
        Whether a force pushes the spacecraft, shape (c,).
    load, stress, inside, inside_stress, wrench, arms
        Of a unit of each, as of `HubInputs`, shapes (c, r), (c, m), (c, r), (c, m), (c, 6) and (c, 3, r), or (c, 6, r).
    own, whole
        ``u own u / 2`` is what stresses store at once in the structure that answers them, and what they store in one
        that has answered, of what is watched, shape (c, c).
    watched
        Number that counts for an actuator whose pumping is watched; -1: it is not, shape (c,).
    times
        Interval and step [s], steps of an interval, and intervals of a period of the monitor, shape (4,).
    """

    limit: Array
    rate: Array
    lag: Array
    resolution: Array
    lowest: Array
    momentum: Array
    kind: Indices
    axis: Indices
    delay: Indices
    pushing: Indices
    load: Array
    stress: Array
    inside: Array
    inside_stress: Array
    wrench: Array
    arms: Array
    own: Array
    whole: Array
    watched: Indices
    times: Array


class Sensing(NamedTuple):
    """Constants of o readings.

    What they read is a row on z: coordinates, monomials, values of the actuators, and the motion of the frame, whose
    load moves what follows the coordinates (``S(dw) + S(w)^2`` and the origin's acceleration, 12 numbers).

    Parameters
    ----------
    look
        Rows on z, shape (o, z).
    speed
        Rows on the rates of coordinates and monomials, shape (o, r + m).
    rotation, rate
        Rows on the hub's rotation vector and angular velocity, shape (o, 3).
    form
        Square of the film's deflection from its plane, of the first numbers of z, shape (k, k).
    level
        What a reading is at rest, shape (o,).
    rms
        Readings that are the root of the form, shape (any,).
    gradients
        Gradients of t elements on z, shape (t, g, z).
    line
        What a gradient adds to the stress that is read, shape (t, g).
    bend
        The same, of second degree, shape (t, g, g).
    reading
        Which reading an element's stress belongs to, shape (t,).
    bias, resolution, noise, age
        As of `Sensor`, the age in intervals, shape (o,).
    kept
        Readings that are kept, shape (o,).
    """

    look: Array
    speed: Array
    rotation: Array
    rate: Array
    form: Array
    level: Array
    rms: Indices
    gradients: Array
    line: Array
    bend: Array
    reading: Indices
    bias: Array
    resolution: Array
    noise: Array
    age: Array
    kept: Indices


class LinearLoop(NamedTuple):
    """A linear law of n states around every plant, see `LawMatrices`; none where C has no rows.

    Parameters
    ----------
    A, B, C, D, b, d
        Its matrices.
    x
        States, shape (count, n).
    """

    A: Array
    B: Array
    C: Array
    D: Array
    b: Array
    d: Array
    x: Array


class LoopState(NamedTuple):
    """What n loops remember beside the motion, of c numbers of a command and o readings.

    Parameters
    ----------
    waiting
        Commands that are under way, shape (n, c, any).
    target, output, value
        What drives are told, what they give at the end of the interval, and what acts, shape (n, c).
    gain, offset
        What acts is ``gain`` times what the drive gives, plus ``offset``, shape (n, c).
    stored
        Momentum of the wheels in axes that do not turn [N m s], shape (n, c, 3).
    past
        Exact readings, newest first, shape (n, o, any).
    work
        Done by each number since the reset [J], shape (n, c).
    pull
        Energy that a unit of each number has where the structure is [J], shape (n, c).
    given
        What drives give, shape (n, c).
    pumped
        Work that a change pumps [J], shape (n, c).
    draws
        Standard normal numbers to come, shape (n, any, o).
    watch
        As of `Watch`: intervals, pumped and moved work [J], and periods that pumped, shape (n, c, 4).
    counts
        Intervals since the reset, and draws that are used, shape (n, 2).
    failed
        Not 0 where a step failed, shape (n,).
    motion
        Of a prescribed hub at the ends of the steps to come, as many as draws times steps of an interval: angle, rate
        and acceleration, and the acceleration behind that, where it may jump; shape (n, any, 4). None on a free one.
    """

    waiting: Array
    target: Array
    output: Array
    value: Array
    gain: Array
    offset: Array
    stored: Array
    past: Array
    work: Array
    pull: Array
    given: Array
    pumped: Array
    draws: Array
    watch: Array
    counts: Indices
    failed: Indices
    motion: Array

    @classmethod
    def before_reset(cls, n: int, drives: Drives, sensing: Sensing, draws: int, instants: int) -> LoopState:
        """What n loops remember before their first reset, for so many draws and instants of a prescribed hub."""
        c, o, zeros = len(drives.limit), len(sensing.bias), np.zeros
        late, old = int(drives.delay.max(initial=0)), int(sensing.kept.max(initial=1))
        target, output, value, offset, work, pull, given, pumped = zeros((8, n, c))
        return cls(
            zeros((n, c, late)), target, output, value, np.ones((n, c)), offset, zeros((n, c, 3)), zeros((n, o, old)),
            work, pull, given, pumped, zeros((n, draws, o)), zeros((n, c, 4)), zeros((n, 2), dtype=np.int64),
            zeros(n, dtype=np.int64), zeros((n, instants, 4)),
        )  # fmt: skip
