"""Sensors of a reduced model as rows on its coordinates, what follows them, its actuators and its frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tautflex.control.actuators.bank import Bank
from tautflex.control.compiled.parts import Sensing
from tautflex.control.sensors.sensor import PreparedSensor, Sensor
from tautflex.control.sensors.surface_rms import SurfaceRms
from tautflex.errors import UnsupportedError
from tautflex.mechanics.loads.prepared import StressChange
from tautflex.mechanics.surface import SurfaceOnVectors
from tautflex.numeric import Array, Indices
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.on_basis import OnBasis
from tautflex.reduction.polynomial.monomials import pairs

# Terms of a sensor below this part of its largest one are round-off.
_ROUND_OFF = 1e-10


def sensing_of(
    run: HubRun,
    sensors: Mapping[str, Sensor],
    prepared: Mapping[str, PreparedSensor],
    interval: float,
    bank: Bank,
) -> Sensing:
    """Constants of all readings of a run under some actuators.

    Raises
    ------
    UnsupportedError
        If a sensor's reading is not linear, but for the film's deflection.
    """
    rom, system = run.rom, run.rom.state.system
    vectors, columns = moved_by(run, bank)
    extended = np.pad(vectors, ((0, 0), (0, 1)))
    moving, rows, terms, first = rom.size + rom.monomial_count, list[int](), list[Any](), 0
    size = sum(bound.size for bound in prepared.values())
    look, speed, (rotation, rate), level = (
        np.zeros((size, len(vectors))),
        np.zeros((size, moving)),
        np.zeros((2, size, 3)),
        np.zeros(size),
    )
    for name, bound in prepared.items():
        own = slice(first, first + bound.size)
        first += bound.size
        if isinstance(sensors[name], SurfaceRms):
            rows += range(own.start, own.stop)
            continue
        if bound.function is not None or bound.rows is None:
            raise UnsupportedError(
                f"sensors.{name}: expected a reading that is linear, or SurfaceRms, in a compiled plant, got "
                f"{type(sensors[name]).__name__}; use Plant"
            )
        given = bound.rows
        if given.displacement is not None:
            look[own] = given.displacement @ vectors.T
        if given.velocity is not None:
            speed[own] = given.velocity @ vectors[:moving].T
        if given.rotation is not None:
            rotation[own] = given.rotation
        if given.rate is not None:
            rate[own] = given.rate
        _clean(look[own], speed[own], rom)
        for number, weights in given.stress.items():
            block = system.blocks[number]
            level[own] += np.einsum("nrs,rs->n", weights, system.initial_stress[number])
            if number in columns:
                look[own, moving : moving + columns[number].shape[2]] += np.einsum(
                    "nrs,rsc->nc", weights, columns[number]
                )
            for n, row in zip(*np.nonzero(np.abs(weights).sum(axis=2)), strict=True):
                pulled = weights[n, row] @ block.elasticity[row]
                terms.append(
                    (
                        own.start + n,
                        block.gradient[row] @ extended[:, system.row_places[number][row]].T,
                        pulled @ block.linear,
                        0.5 * np.einsum("s,sgh->gh", pulled, block.quadratic),
                    )
                )
    flat = rom.film.count == rom.size
    form = (rom.film if flat else SurfaceOnVectors(system.surface, vectors)).form if rows else np.zeros((0, 0))
    each = [sensor for name, sensor in sensors.items() for _ in range(prepared[name].size)]
    age = np.array([sensor.delay / interval for sensor in each])
    bias, resolution, noise = (
        np.array([getattr(sensor, name) for sensor in each]) for name in ("bias", "resolution", "noise")
    )
    return Sensing(
        look, speed, rotation, rate, np.ascontiguousarray(form), level, np.array(rows, dtype=np.int64),
        *_stacked(terms, len(vectors)), bias, resolution, noise, age, np.array(np.ceil(age - 1e-9) + 1, dtype=np.int64),
    )  # fmt: skip


def _clean(look: Array, speed: Array, rom: OnBasis) -> None:
    """Take out of a sensor's rows what is round-off of a flat structure, whose film follows nothing in its plane."""
    amplitude, r, m = rom.basis.amplitude, rom.size, rom.monomial_count
    first, second = pairs(r)
    size = amplitude[first] * amplitude[second]
    least = _ROUND_OFF * float(np.abs(look[:, :r] * amplitude).max(initial=0.0))
    moved = _ROUND_OFF * float(np.abs(speed[:, :r] * amplitude).max(initial=0.0))
    parts = (look[:, r : r + m], size, least), (look[:, r + m :], 1.0, least), (speed[:, r:], size, moved)
    for part, unit, limit in parts:
        if np.abs(part * unit).max(initial=0.0) <= limit:
            part[:] = 0.0


def moved_by(run: HubRun, bank: Bank) -> tuple[Array, dict[int, Array]]:
    """Displacement by coordinates, monomials, numbers of the actuators and motion of the frame, shape (z, size).

    And the stresses of these numbers by block, shapes (row, strain, c).
    """
    rom, inputs = run.rom, run.inputs
    size, basis = rom.state.system.size, rom.basis
    follow = rom.monomial_vectors if len(basis.derivatives) else np.zeros((rom.monomial_count, size))
    answers, columns, first, used = np.zeros((bank.size, size)), dict[int, Array](), 0, 0
    for item in bank.items:
        count = item.channel.size
        if isinstance(item.bound, StressChange):
            answers[first : first + count] = inputs.answers[used : used + count]
            for number, column in inputs.columns.items():
                whole = columns.setdefault(number, np.zeros((*column.shape[:2], bank.size)))
                whole[:, :, first : first + count] = column[:, :, used : used + count]
            used += count
        first += count
    factor = run.problem.coupling.load_factor
    frame = (
        factor * rom.coefficients.follow_load @ basis.derivatives if len(basis.derivatives) else np.zeros((12, size))
    )
    return np.concatenate([basis.kept, follow, answers, frame]), columns


def _stacked(terms: list[Any], size: int) -> tuple[Array, Array, Array, Indices]:
    """Terms of elements' stresses as arrays; gradients with fewer numbers than others are filled up."""
    most = max((len(line) for _, _, line, _ in terms), default=0)
    gradients, lines = np.zeros((len(terms), most, size)), np.zeros((len(terms), most))
    bends = np.zeros((len(terms), most, most))
    for n, (_, gradient, line, bend) in enumerate(terms):
        count = len(line)
        gradients[n, :count], lines[n, :count], bends[n, :count, :count] = gradient, line, bend
    return gradients, lines, bends, np.array([reading for reading, *_ in terms], dtype=np.int64)
