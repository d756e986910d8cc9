"""A plant's run of a reduced model."""

from __future__ import annotations

import time as clock

import numpy as np

from tautflex.control.runs.run_of_plant import Place, RunOfPlant, Sight
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.mechanics.loads.signals import Held
from tautflex.numeric import Array
from tautflex.reduction.marching.free_hub.hub_run import HubRun
from tautflex.reduction.marching.resume import final, resume
from tautflex.reduction.marching.simulation import new_run, result_of
from tautflex.reduction.on_basis import OnBasis
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.solvers.transient.status import Run, Status


class ReducedPlantRun(RunOfPlant):
    """Run of a reduced model, see `RunOfPlant`."""

    def __init__(self, problem: TransientProblem) -> None:
        assert isinstance(problem.plant, OnBasis)
        self.problem, self._run = problem, new_run(problem.plant, problem)
        self._workspace, self._began = problem.state.system.workspace(), clock.perf_counter()

    def start(self) -> None:
        """Start, or go on from another run's state."""
        if not resume(self._run):
            self._run.start()

    def advance(self, number: int) -> bool:
        """Take the steps to an instant of the grid; whether they were stable or converged."""
        return self._run.advance(number)

    def renew(self) -> None:
        """Meet a change of inputs and torques that were set anew at the present instant."""
        self._run.renew()

    def push(self, wrench: Array, time: float) -> None:
        """Hold a wrench on the hub from an instant [s] on, shape (6,)."""
        if not isinstance(self._run, HubRun):
            return
        if self._run.commanded is None:
            self._run.commanded = Held(wrench)
        else:
            self._run.commanded.hold(wrench, time)

    @property
    def place(self) -> Place:
        """Where structure and hub are; what answers stresses at once is no way that forces work on."""
        run = self._run
        rigid = run.ride.rigid.copy() if isinstance(run, HubRun) else np.zeros(0)
        return Place(run.time, run.rom.displacement(run.work.q), rigid, run.work.q.copy())

    def strain_energy(self) -> float:
        """Strain energy under the inputs of the present instant [J]."""
        run = self._run
        return float(run.energies(np.array([run.time]), run.work.q[None], run.work.v[None])[0, 1])

    @property
    def own(self) -> Array:
        """``u own u / 2`` is what stresses of inputs store at once in the structure that answers them, shape (n, n)."""
        return self._run.inputs.own

    def wrench_of(self, load: Array, place: Place) -> Array:
        """Force, and torque about O, of forces on the free unknowns, hub axes, shape (6,)."""
        run = self._run
        assert isinstance(run, HubRun)
        wrench: Array = load @ run.to_wrench
        wrench[3:] += (load @ run.to_arms).reshape(3, -1) @ place.coordinates
        return wrench

    def pressure_work(self, unit: PressureLoad, before: Place, at: Place) -> float:
        """Work of pressure on the structure between two places [J]: the model's own force has a potential."""
        size, pressed = self._run.inputs.pressed(unit)
        work, (first, second) = 0.0, np.triu_indices(self._run.rom.size)
        for sign, place in ((1.0, at), (-1.0, before)):
            eta = place.coordinates
            work += sign * float(pressed.load @ eta)
            if pressed.beside.size:
                work += sign * float(pressed.beside @ (eta[first] * eta[second]))
        return size * work

    def pressure_push(self, unit: PressureLoad, place: Place) -> Array:
        """Force, and torque about O, of pressure, hub axes, shape (6,)."""
        run = self._run
        assert isinstance(run, HubRun)
        wrench, slopes = run.pushed_by(unit)
        return np.asarray(wrench + slopes @ place.coordinates)

    def look(self, stress: bool) -> Sight:
        """What sensors see; ``stress``: of stresses too."""
        run, found = self._run, list[Array]()
        q, v = run.motion_at(run.time, run.work.q, run.work.v)
        if stress:
            self._workspace.change_initial_stress(run.inputs.given.stress(run.time))
            self._workspace.strain_energy(q)
            found = self._workspace.stress
        return Sight(q, v, run.motions(np.array([run.time]))[0, :3], found)

    def checkpoint(self) -> Checkpoint:
        """State to go on from."""
        found = final(self._run, True)
        assert found is not None
        return found

    def result(self, status: Status) -> Run:
        """What the run leaves."""
        return result_of(self._run, status, clock.perf_counter() - self._began)
