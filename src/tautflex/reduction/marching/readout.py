"""Samples of a reduced run, read from its stored coordinates part by part, so that memory stays flat."""

from __future__ import annotations

import numpy as np

from tautflex.numeric import Array, Indices
from tautflex.reduction.marching.frame_terms import BLOCK, in_blocks
from tautflex.reduction.marching.run import ReducedRun
from tautflex.solvers.transient.restart.keeper import Storage, in_memory, let_go
from tautflex.solvers.variables import OF_SURFACE, SCALARS

# Samples of a part: whole blocks, so that no reading depends on the parts.
_PART = 64 * BLOCK


class Readout:
    """What a full run stores of every sample, from stored coordinates.

    Parameters
    ----------
    run
        The run.
    storage
        Where the arrays are; their room is taken before the run begins.

    Attributes
    ----------
    times, place
        Instants [s] of the samples, and their places among the stored coordinates, shape (sample,).
    spin, probe
        As of `Samples`.
    coordinate
        Shape (sample, r).
    scalars
        As of `Samples`; NaN but for energies and surface.
    size
        Twice the energy that the coordinates have by their linear stiffness, shape (sample,) [J].
    moving, still
        Largest energy of motion [J], and largest size of what stresses of inputs store in the structure at rest.
    """

    times: Array
    place: Indices
    size: Array
    moving = still = 0.0

    def __init__(self, run: ReducedRun, storage: Storage = in_memory) -> None:
        count, problem = len(run.problem.stored_steps), run.problem
        self._run = run
        self.spin = storage("spin", (count, 2, 3), "f8")
        self.probe = storage("probe", (count, 2, len(problem.placed.names), 3), "f8")
        self._numbers = storage("numbers", (len(SCALARS) + len(OF_SURFACE), count), "f8")
        alone = len(run.stored) == count
        self.coordinate = run.eta if alone else storage("coordinate", (count, run.rom.size), "f8")

    def read(self) -> None:
        """Read all samples that the run has come to, and its largest energy."""
        run, steps = self._run, self._run.problem.stored_steps
        rows = np.arange(steps.start, min(steps.stop, run.reached + 1), steps.step, dtype=np.int64)
        self.times = np.asarray(run.problem.shift + rows * run.problem.time_step, dtype=np.float64)
        self.place, self.size = np.searchsorted(run.stored, rows), np.empty(len(rows))
        before = steps.start // run.problem.every
        for first in range(-(before % BLOCK), len(rows), _PART):
            self._read(slice(max(first, 0), min(first + _PART, len(rows))), before)
        count = len(rows)
        self.spin, self.probe, self.coordinate = self.spin[:count], self.probe[:count], self.coordinate[:count]
        self.scalars = dict(zip([*SCALARS, *OF_SURFACE], self._numbers[:, :count], strict=True))

    def _read(self, part: slice, before: int) -> None:
        run, times = self._run, self.times[part]
        before, eta, rate = before + part.start, run.eta[self.place[part]], run.rate[self.place[part]]
        motions = run.motions(times)
        self.spin[part] = motions[:, :6].reshape(-1, 2, 3)
        energy = in_blocks(run.energies, before, times, eta, rate)
        self._numbers[:2, part], self._numbers[2 : len(SCALARS), part] = energy.T, np.nan
        surface = in_blocks(lambda eta, at: run.rom.surface(eta, run.prescribed_offset(at)), before, eta, motions)
        self._numbers[len(SCALARS) :, part] = surface.T
        self.probe[part] = in_blocks(run.read, before, times, eta, rate, motions)
        if self.coordinate is not run.eta:
            self.coordinate[part] = eta
        self.size[part] = np.einsum("nr,nr->n", eta @ run.arrays.linear, eta)
        # What stresses of inputs store in the structure at rest may be of either sign.
        u, total = run.inputs.stresses(times), energy.sum(axis=1)
        still = 0.5 * np.einsum("tk,tk->t", u, u @ run.inputs.own)
        run.largest = float(np.max(total, initial=run.largest))
        # Eased tension takes strain energy of the reference away: what moves has no less than by its linear stiffness.
        least = energy[:, 0] + 0.5 * self.size[part]
        self.moving = float(np.max(np.maximum(total - still, least), initial=self.moving))
        self.still = float(np.max(np.abs(still), initial=self.still))
        let_go(run.eta, self.spin, self.probe, self._numbers, self.coordinate)
