"""A reduced model on a hub that turns about one axis, as arrays whose last axis is the run.

Everything that is linear is a matrix by columns: a product with it adds up in one order for one run or sixty-four, so
that a run is the same in any company.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.control.compiled.parts import FORCE, WHEEL, Drives, Sensing
from tautflex.numeric import Array, Indices
from tautflex.reduction.marching.free_hub.hub_arrays import HubInputs
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.polynomial.monomials import pairs

# Places in `AxisState.rigid`.
ANGLE, RATE, ACCELERATION, MOMENTUM, TORQUE = range(5)
# Terms below this part of the largest one they stand beside are round-off of a symmetric structure.
_ROUND_OFF = 1e-10


class AxisModel(NamedTuple):
    """Constants of r coordinates, m monomials and c numbers of a command; matrices by columns, (from, to).

    Parameters
    ----------
    first, second
        Factors of the monomials, shape (m,).
    mass, damping, linear, inverse, still
        Shape (r, r); ``inverse`` is that of ``M + h C / 2``, ``still`` that of the mass.
    quadratic
        Second-degree force, shape (m, r), or (m, 0) if there is none.
    fields, fields_back
        F and F' in one or two products, shapes (m, k) and (k, m), or ``F'F`` (m, m) and (0, m).
    viscous, viscous_back
        The same of what damps static derivatives.
    reach, spin
        Of `HubArrays` about the axis, shapes (r,) and (r, r), or (r, 0).
    turned, turning
        Slope D of what monomials make of the momentum per rate, ``D = turned + turning q`` and
        ``G = reach + spin q + (turned + D) q / 2``; row by row, shapes (r r,) and (r, r r), or (0,) and (r, 0).
    pull, pull_slope, square_follow, square_through
        Centrifugal force per coordinate with that of monomials of which it is linear, shapes (r,), (r, r), (m, r) and
        (r, m).
    inertia
        Of hub and structure at the reference [kg m^2], shape (1,).
    load, stress, torque, arms
        Of what acts without commands in the first row and of a unit of each number, shapes (1 + c, r), (1 + c, m),
        (1 + c, 1) and (1 + c, r).
    pull_load, pull_stress
        Energy of a unit of each number per coordinate and monomial, shapes (r, c) and (m, c).
    root
        F itself, shape (k, m).
    stiffening, lagging
        Quadratic forms of the coordinates: the trace of what the fields add to ``M^-1 K``, and the rate of the lagged
        damping [1/s^2, 1/s], shape (r, r).
    bounds
        Largest eigenvalue of ``M^-1 K`` at rest, and how far others may be beyond it per length of the stress, of the
        coordinates, and of its square, shape (4,).
    near
        Readings per coordinate, its rate, number of a command, rotation vector and angular velocity, shape
        (2 r + c + 6, o), or (0, o) where they need more.
    numbers
        Axis, whether a force pushes the spacecraft, and whether the hub's motion is prescribed, shape (3,).
    """

    first: Indices
    second: Indices
    mass: Array
    damping: Array
    linear: Array
    inverse: Array
    still: Array
    quadratic: Array
    fields: Array
    fields_back: Array
    viscous: Array
    viscous_back: Array
    reach: Array
    spin: Array
    turned: Array
    turning: Array
    pull: Array
    pull_slope: Array
    square_follow: Array
    square_through: Array
    inertia: Array
    load: Array
    stress: Array
    torque: Array
    arms: Array
    pull_load: Array
    pull_stress: Array
    root: Array
    stiffening: Array
    lagging: Array
    bounds: Array
    near: Array
    numbers: Indices


class AxisState(NamedTuple):
    """Where n runs are.

    Parameters
    ----------
    q, v, a, forces
        Coordinates, rates, accelerations, and internal force, shape (r, n).
    rigid
        Angle, rate, acceleration, momentum of the hub about its axis, and torque on it, shape (5, n).
    coupling, inertia
        Momentum per rate of the coordinates, and moment of inertia, shapes (r, n) and (1, n).
    load, stress, torque, arms
        What acts, shapes (r, n), (m, n), (1, n) and (r, n).
    swept
        Integral of coordinates times rate over an interval, shape (r, n).
    counts
        Steps, shape (n,).
    """

    q: Array
    v: Array
    a: Array
    forces: Array
    rigid: Array
    coupling: Array
    inertia: Array
    load: Array
    stress: Array
    torque: Array
    arms: Array
    swept: Array
    counts: Indices


class AxisSpace(NamedTuple):
    """Space of a step: ``on_q`` (14, r, n), ``on_y`` (4, m, n), ``slope`` (r r, n), ``rigid`` (12, n), and more.

    ``told`` is what a prescribed hub does at the end of the step, see `LoopState`, shape (4, n).
    """

    on_q: Array
    on_y: Array
    slope: Array
    fields: Array
    rigid: Array
    value: Array
    pull: Array
    seen: Array
    reading: Array
    film: Array
    told: Array


def axis_of(run: HubRun, drives: Drives) -> int:
    """Axis about which runs may go side by side as arrays; -1: they may not."""
    turns, attitude = run.hub.turns, run.ride.rigid[1:4]
    if len(turns) != 1 or np.delete(attitude, turns[0]).any():
        return -1
    limited = (drives.kind == WHEEL) & np.isfinite(drives.momentum)
    return -1 if np.any(drives.axis[limited] != turns[0]) else int(turns[0])


def _both(root: Array) -> tuple[Array, Array]:
    """``R'R`` as one product or two, whichever is shorter."""
    k, m = root.shape
    if k > 0 and 2 * k >= m:
        return root.T @ root, np.zeros((0, m))
    return np.ascontiguousarray(root.T), np.ascontiguousarray(root)


def _trace(root: Array, still: Array) -> Array:
    """T with ``q' T q = tr(Y' R'R Y M^-1)``, shape (r, r)."""
    r = len(still)
    first, second = pairs(r)
    slopes = np.zeros((len(root), r, r))
    slopes[:, first, second] = root
    slopes = slopes + slopes.transpose(0, 2, 1)
    return np.asarray(np.einsum("kab,ac,kcd->bd", slopes, still, slopes, optimize=True))


def turning_of(follow: Array, table: Array) -> tuple[Array, Array]:
    """Slope of ``Y' (follow + T' q) - T y`` at rest and per coordinate, shapes (r r,) and (r, r r)."""
    r = len(table)
    first, second = pairs(r)
    both = np.zeros((r + 1, r, r))
    both[:, first, second] = np.concatenate([follow[None], table])
    both += both.transpose(0, 2, 1)
    own = both[1:]
    # d^2 G_i / dq_j dq_b by (b, i, j).
    second_slope = -own.transpose(2, 0, 1) + own + own.transpose(2, 1, 0)
    return both[0].ravel(), second_slope.reshape(r, r * r)


def axis_model(
    run: HubRun, drives: Drives, sensing: Sensing, base: HubInputs, axis: int, driven: bool = False
) -> AxisModel:
    """Constants of a run on a hub of one axis, whose motion may be prescribed, under some drives and sensors."""
    arrays, hub, row, step = run.arrays, run.hub, 3 + axis, float(drives.times[1])
    r, m, c = len(arrays.mass), len(arrays.first), len(drives.kind)
    amplitude = run.rom.basis.amplitude
    products = amplitude[arrays.first] * amplitude[arrays.second]

    def kept(part: Array, size: Array, beside: Array) -> Array:
        """Without columns where a part is round-off of what it stands beside."""
        small = np.abs(part * size).max(initial=0.0) <= _ROUND_OFF * np.abs(beside).max(initial=0.0)
        return np.zeros((part.shape[1], 0)) if small else np.ascontiguousarray(part.T)

    reach = hub.reach[row]
    spin = kept(hub.spin[0], amplitude, reach)
    turned, turning = turning_of(hub.reach_follow[row], hub.spin_follow[0])
    size = np.abs(turned).reshape(r, r) + (np.abs(turning) * amplitude[:, None]).sum(axis=0).reshape(r, r)
    if (size * amplitude).max() <= _ROUND_OFF * np.abs(reach).max():
        turned, turning = turned[:0], turning[:, :0]
    square_follow = kept(hub.square_follow[0], products, hub.square[0] * amplitude)
    slope = np.zeros((r, r))
    np.add.at(slope, (arrays.first, arrays.second), hub.pull_follow[0])
    pull_slope = hub.square[0] + slope + slope.T
    near = np.concatenate([
        sensing.look[:, :r], sensing.speed[:, :r], sensing.look[:, r + m : r + m + c], sensing.rotation, sensing.rate,
    ], axis=1).T  # fmt: skip
    reaches = sensing.look[:, r : r + m].any() or sensing.look[:, r + m + c :].any() or sensing.speed[:, r:].any()
    if reaches or len(sensing.reading) or (len(sensing.rms) and len(sensing.form) != r):
        near = np.zeros((0, len(sensing.bias)))
    fields, fields_back = _both(arrays.fields)
    viscous, viscous_back = _both(arrays.viscous)
    still = np.linalg.inv(arrays.mass)
    stiffening, light = _trace(arrays.fields, still), float(np.linalg.norm(still, 2))
    stiffest = float(np.linalg.eigvals(still @ arrays.linear).real.max())
    stressed, bent = (
        float(np.linalg.norm(part, 2)) if part.size else 0.0
        for part in (arrays.fields.T @ arrays.fields, arrays.quadratic)
    )
    return AxisModel(
        first=arrays.first,
        second=arrays.second,
        mass=arrays.mass.T.copy(),
        damping=arrays.damping.T.copy(),
        linear=arrays.linear.T.copy(),
        inverse=np.linalg.inv(arrays.mass + 0.5 * step * arrays.damping).T.copy(),
        still=still.T.copy(),
        quadratic=arrays.quadratic.T.copy(),
        fields=fields,
        fields_back=fields_back,
        viscous=viscous,
        viscous_back=viscous_back,
        reach=reach.copy(),
        spin=spin,
        turned=turned,
        turning=np.ascontiguousarray(turning),
        pull=hub.pull[0].copy(),
        pull_slope=pull_slope.T.copy(),
        square_follow=square_follow,
        square_through=hub.square_follow[0].copy() if square_follow.shape[1] else np.zeros((r, 0)),
        inertia=np.array([hub.tensor[axis, axis]]),
        load=np.concatenate([base.load, drives.load]),
        stress=np.concatenate([base.stress, drives.stress]),
        torque=np.concatenate([base.wrench, drives.wrench])[:, row : row + 1].copy(),
        arms=np.concatenate([base.arms, drives.arms])[:, axis - 3].copy(),
        pull_load=drives.load.T.copy(),
        pull_stress=drives.stress.T.copy(),
        root=arrays.fields,
        stiffening=stiffening,
        lagging=_trace(arrays.viscous, np.eye(r)),
        bounds=np.array([stiffest, *(2.0 * light * np.array([1.0, bent, stressed]))]),
        near=np.ascontiguousarray(near),
        numbers=np.array([axis, np.any((drives.kind == FORCE) & (drives.pushing != 0)), driven], dtype=np.int64),
    )


def new_axis_state(model: AxisModel, runs: int) -> AxisState:
    """Zeros of the right shapes."""
    r, m = len(model.reach), len(model.first)
    zeros = np.zeros
    q, v, a, forces = zeros((4, r, runs))
    return AxisState(
        q, v, a, forces, zeros((5, runs)), zeros((r, runs)), zeros((1, runs)), zeros((r, runs)), zeros((m, runs)),
        zeros((1, runs)), zeros((r, runs)), zeros((r, runs)), zeros(runs, dtype=np.int64),
    )  # fmt: skip


def new_axis_space(model: AxisModel, runs: int) -> AxisSpace:
    """Zeros of the right shapes."""
    r, m, c = len(model.reach), len(model.first), len(model.load)
    k, o = max(len(model.fields_back), len(model.viscous_back)), model.near.shape[1]
    shapes = (14, r), (4, m), (len(model.turned),), (k,), (12,), (c,), (c - 1,), (len(model.near),), (o,), (r,), (4,)
    return AxisSpace(*(np.zeros((*shape, runs)) for shape in shapes))


def start_angle(rigid: Array, axis: int) -> float:
    """Angle about an axis of a hub that is turned about it alone [rad]."""
    return float(2.0 * np.arctan2(rigid[1 + axis], rigid[0]))
