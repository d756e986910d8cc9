"""A plant's run of the full structure."""

from __future__ import annotations

from tautflex.control.runs.run_of_plant import Place, RunOfPlant, Sight
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.numeric import Array
from tautflex.solvers.transient.free_hub.equation import HubEquation
from tautflex.solvers.transient.free_hub.motion import HubMotion
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.solvers.transient.simulate import FullRun
from tautflex.solvers.transient.status import Run, Status


class FullPlantRun(RunOfPlant):
    """Run of the full structure, see `RunOfPlant`."""

    def __init__(self, problem: TransientProblem) -> None:
        self.problem, self._run = problem, FullRun(problem)

    def start(self) -> None:
        """Start, or go on from another run's state."""
        self._run.start()

    def advance(self, number: int) -> bool:
        """Take the steps to an instant of the grid; whether they converged."""
        return self._run.advance(number)

    def renew(self) -> None:
        """Meet a change of inputs and torques that were set anew at the present instant."""
        self._run.renew()

    def push(self, wrench: Array, time: float) -> None:
        """Hold a wrench on the hub from an instant [s] on, shape (6,)."""
        if isinstance(self._run.equation, HubEquation):
            self._run.equation.commanded = wrench

    @property
    def place(self) -> Place:
        """Where structure and hub are."""
        at = self._run.at
        return Place(at.time, at.q, at.rigid if isinstance(at, HubMotion) else at.q[:0], at.q)

    def strain_energy(self) -> float:
        """Strain energy under the inputs of the present instant [J]."""
        return self._run.strain_energy()

    def wrench_of(self, load: Array, place: Place) -> Array:
        """Force, and torque about O, of forces on the free unknowns, hub axes, shape (6,)."""
        assert isinstance(self._run.equation, HubEquation)
        return self._run.equation.wrench_of(load, place.q)

    def pressure_work(self, unit: PressureLoad, before: Place, at: Place) -> float:
        """Work of pressure on the structure between two places [J]."""
        return float(unit.mean_force(before.q, at.q) @ (at.q - before.q))

    def pressure_push(self, unit: PressureLoad, place: Place) -> Array:
        """Force, and torque about O, of pressure, hub axes, shape (6,)."""
        return unit.wrench(place.q)

    def look(self, stress: bool) -> Sight:
        """What sensors see; ``stress``: of stresses too."""
        run, found = self._run, list[Array]()
        if stress:
            run.strain_energy()
            found = run.equation.workspace.stress
        return Sight(run.at.q, run.at.v, run.motion().angular_velocity, found)

    def checkpoint(self) -> Checkpoint:
        """State to go on from."""
        return self._run.checkpoint()

    def result(self, status: Status) -> Run:
        """What the run leaves."""
        return self._run.result(status)
