"""Answer of a reduced model to a transient problem: same question, same result."""

from __future__ import annotations

import time as clock

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.interrupts import deferred, meet
from tautflex.mechanics.membrane import survey_at
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.marching.readout import Readout
from tautflex.reduction.marching.resume import final, go_on, kept, resume
from tautflex.reduction.marching.run import ReducedRun
from tautflex.reduction.marching.schedule import stretches
from tautflex.reduction.marching.validity import check_validity
from tautflex.reduction.on_basis import OnBasis
from tautflex.solvers.transient.accuracy.verdict import judge
from tautflex.solvers.transient.problem import Progress, TransientProblem
from tautflex.solvers.transient.recorder import Samples, run_dataset
from tautflex.solvers.transient.restart.keeper import Keeper, in_memory
from tautflex.solvers.transient.status import Run, Status
from tautflex.solvers.variables import REDUCED_RUN, described


def new_run(rom: OnBasis, problem: TransientProblem) -> ReducedRun:
    """Run of a problem, before its start."""
    return (HubRun if isinstance(problem.maneuver, FreeHub) else ReducedRun)(rom, problem)


def solve_reduced(
    rom: OnBasis, problem: TransientProblem, progress: Progress = None, keeper: Keeper | None = None
) -> Run:
    """Integrate the equation of motion of a reduced model.

    Besides what a full run stores, ``run.data`` has the coordinates; resultants of the film are evaluated at the
    instants of ``check_time`` (the largest motion of each of a few windows) and are NaN between them. Raises as
    `ReducedRun`, and InputError if the step of an explicit method is not stable.
    """
    run = new_run(rom, problem)
    began, status = clock.perf_counter(), Status.COMPLETED
    if keeper is not None:
        run.eta, run.rate = keeper.array("coordinates", (2, *run.eta.shape))
    samples = Readout(run, in_memory if keeper is None else keeper.array)
    with deferred():
        try:
            if keeper is not None and keeper.kept is not None:
                began -= go_on(run, keeper.kept)
            elif not resume(run):
                run.start()
            for end in _limits(run):
                meet()
                if keeper is not None and keeper.due():
                    keeper.keep(run.time, kept(run, clock.perf_counter() - began))
                if not run.advance(end, progress):
                    status = Status.NOT_CONVERGED
                    break
        except KeyboardInterrupt:
            status = Status.INTERRUPTED
        return result_of(run, status, clock.perf_counter() - began, samples)


def _limits(run: ReducedRun) -> list[int]:
    """Instants of the grid where steps may be cut without taking others: ends of stretches, and the last."""
    problem = run.problem
    left = stretches(run.segments, problem.time_step, run.reached, problem.count, problem.shift)
    return [*sorted({int(stretch.grid[-1]) for stretch in left} - {-1, problem.count}), problem.count]


def result_of(run: ReducedRun, status: Status, seconds: float, samples: Readout | None = None) -> Run:
    """What a run leaves, whose steps took some seconds; its samples are read into what there is for them."""
    problem = run.problem
    statistics = run.statistics
    statistics.seconds = seconds
    ended = {"status": status.value, "status_message": status.message, "statistics": statistics.to_json()}
    data, balance = _dataset(run, samples or Readout(run)).assign_attrs(ended), run.balance()
    accuracy = judge(problem, run.books.errors, balance, run.largest, problem.time_step)
    data.attrs |= accuracy.attributes | {"warnings": data.attrs["warnings"] + accuracy.warnings}
    ended_in = final(run, status is Status.COMPLETED)
    return Run(data, status, statistics, run.time, (), accuracy.error, balance, ended_in)


def _dataset(run: ReducedRun, samples: Readout) -> xr.Dataset:
    """Everything a full run stores, from the stored coordinates."""
    rom, problem = run.rom, run.problem
    samples.read()
    checked = check_validity(run, samples)
    for name, values in checked.scalars.items():
        samples.scalars[name][checked.samples] = values
    record = Samples(samples.times, samples.probe, samples.spin, samples.scalars, _fields(run), *_frames(run))
    said = [*run.idle, *run.warnings, *checked.warnings]
    attributes = problem.attributes | {"reduced_model": repr(rom), "warnings": said}
    attributes["title"] += ", reduced model"
    data = run_dataset(rom.model, problem.placed, record, attributes)
    for name in checked.scalars:
        data[name].attrs["comment"] = (
            f"at the {checked.samples.size} instants check_time, NaN between; no peaks of the run"
        )
    arrays = {"coordinate": samples.coordinate, "truncated_energy": checked.truncated}
    instants = described(REDUCED_RUN, {"check_time": samples.times[checked.samples]})
    return run.complete(data.assign(described(REDUCED_RUN, arrays)).assign_coords(instants), samples.place)


def _frames(run: ReducedRun) -> tuple[Array, NDArray[np.float32]]:
    """Times of frames and displacement of all nodes then."""
    rows = np.array([row for row in sorted(run.problem.frame_steps) if row <= run.reached], dtype=np.int64)
    times = np.asarray(run.problem.shift + rows * run.problem.time_step, dtype=np.float64)
    if not len(rows):
        return times, np.zeros((0, len(run.rom.model.nodes), 3), dtype=np.float32)
    offset = run.prescribed_offset(run.motions(times))
    frames = run.rom.frames(run.eta[np.searchsorted(run.stored, rows)], offset)
    if run.inputs.columns:
        frames += run.rom.state.system.translations(run.inputs.answer(times)).astype(np.float32)
    return times, frames


def _fields(run: ReducedRun) -> tuple[Array, Array, NDArray[np.int8]]:
    """Times, displacements of all nodes and film states of stored fields."""
    system, model = run.rom.state.system, run.rom.model
    rows = [row for row in sorted(run.problem.field_steps) if row <= run.reached]
    times = np.array([run.problem.instant(row) for row in rows])
    fields = np.empty((len(rows), len(model.nodes), 3))
    states = np.empty((len(rows), int(model.triangle_owner.max(initial=-1)) + 1), dtype=np.int8)
    for number, row in enumerate(rows):
        at, eta = times[number : number + 1], run.eta[np.searchsorted(run.stored, row)]
        q = run.rom.displacement(eta, run.prescribed_offset(run.motions(at))[0]) + run.inputs.answer(at)[0]
        fields[number], states[number] = system.translations(q), survey_at(system, q).membrane_states()
    return times, fields, states
