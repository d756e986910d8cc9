"""Plants in blocks as compiled loops take them: one at a time on any hub, many on a hub of one axis."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.control.compiled import any_hub, axis_run
from tautflex.control.compiled.axis_parts import (
    ANGLE,
    RATE,
    AxisState,
    axis_model,
    axis_of,
    new_axis_space,
    new_axis_state,
    start_angle,
)
from tautflex.control.compiled.parts import Drives, LoopState, Sensing
from tautflex.numeric import Array
from tautflex.reduction.marching.free_hub.hub_arrays import HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import TWIST
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.marching.free_hub.hub_work import HubWork, new_hub_work
from tautflex.reduction.marching.work import Work, new_work


class AnyHubBlocks:
    """Blocks of one plant on any hub.

    Attributes
    ----------
    kernels
        Module of ``begin`` and ``run``.
    lanes
        Most plants of a block.
    fixed
        Parts with the constants.
    """

    kernels: Any = any_hub
    lanes = 1

    def __init__(self, run: HubRun, drives: Drives, sensing: Sensing) -> None:
        self._run, self._drives, self._rows = run, drives, list[tuple[Work, HubWork]]()
        self._base = whole_inputs(run, drives)
        self.fixed: tuple[Any, ...] = (run.arrays, run.hub, drives, sensing, self._base)

    def block(self, loop: LoopState) -> tuple[Any, ...]:
        """Parts of one more block."""
        run = self._run
        work, ride = new_work(run.rom.size), new_hub_work(run.hub, run.arrays.mass, run.ride.given.size)
        self._rows.append((work, ride))
        return work, ride, loop, *(whole_inputs(run, self._drives) for _ in range(2))

    def place(self, row: int, q: Array, v: Array, told: Array | None = None) -> None:
        """Place a plant at coordinates and rates, on its hub at the start."""
        work, ride = self._rows[row]
        work.q[:], work.v[:], ride.rigid[:] = q, v, self._run.ride.rigid

    def coordinates(self, row: int) -> Array:
        """Coordinates of a plant, shape (r,)."""
        return self._rows[row][0].q


class AxisBlocks:
    """Blocks of many plants on a hub of one axis, see `AnyHubBlocks`."""

    kernels: Any = axis_run
    lanes = 64

    def __init__(self, run: HubRun, drives: Drives, sensing: Sensing, axis: int, driven: bool) -> None:
        self._run, self._axis, self._rows = run, axis, list[tuple[AxisState, int]]()
        self._model = axis_model(run, drives, sensing, whole_inputs(run, drives), axis, driven)
        self.fixed: tuple[Any, ...] = (self._model, drives, sensing)

    def block(self, loop: LoopState) -> tuple[Any, ...]:
        """Parts of one more block."""
        runs = len(loop.value)
        state = new_axis_state(self._model, runs)
        self._rows += [(state, lane) for lane in range(runs)]
        return state, new_axis_space(self._model, runs), loop

    def place(self, row: int, q: Array, v: Array, told: Array | None = None) -> None:
        """Place a plant at coordinates and rates; on its hub at the start, or one that is told where it is."""
        (state, lane), rigid = self._rows[row], self._run.ride.rigid
        state.q[:, lane], state.v[:, lane] = q, v
        if told is not None:
            state.rigid[: len(told), lane] = told
            return
        state.rigid[ANGLE, lane] = start_angle(rigid, self._axis)
        state.rigid[RATE, lane] = rigid[TWIST + 3 + self._axis]

    def coordinates(self, row: int) -> Array:
        """Coordinates of a plant, shape (r,)."""
        state, lane = self._rows[row]
        return state.q[:, lane]


def blocks_of(run: HubRun, drives: Drives, sensing: Sensing, driven: bool) -> AnyHubBlocks | AxisBlocks:
    """Blocks for a run under some drives and sensors, on a hub that may be driven about its one axis."""
    axis = axis_of(run, drives)
    return AnyHubBlocks(run, drives, sensing) if axis < 0 else AxisBlocks(run, drives, sensing, axis, driven)


def whole_inputs(run: HubRun, drives: Drives) -> HubInputs:
    """What acts without commands, with as many numbers as the drives have."""
    base = run.inputs_at(np.zeros(1), np.inf)
    shapes = (part.shape[1:] for part in (drives.load, drives.stress, drives.inside, drives.inside_stress))
    load, stress, inside, pulled = (
        part.copy() if part.shape[1:] == shape else np.zeros((1, *shape))
        for part, shape in zip(base, shapes, strict=False)
    )
    return HubInputs(load, stress, inside, pulled, base.wrench.copy(), base.arms.copy())
