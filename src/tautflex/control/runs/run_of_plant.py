"""What drives, sensors and the loop ask of a plant's run, whatever model it is of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from tautflex.mechanics.loads.prepared import FilmPressure, LinearInput, PatternLoad
from tautflex.mechanics.loads.pressure import PressureLoad
from tautflex.numeric import Array
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.solvers.transient.status import Run, Status


class Place(NamedTuple):
    """Where a structure and its hub are.

    Parameters
    ----------
    time
        [s].
    q
        Free unknowns as far as forces work on them, shape (size,).
    rigid
        The hub, shape (31,), see `RigidState`; (0,): there is none.
    coordinates
        In which the run has the arms of forces, shape (any,).
    """

    time: float
    q: Array
    rigid: Array
    coordinates: Array


class Sight(NamedTuple):
    """What sensors look at; see `SensedMotion`.

    Parameters
    ----------
    q, v
        Free unknowns and their velocities, shape (size,).
    rate
        Angular velocity of the floating frame in its own axes [rad/s], shape (3,).
    stress
        Stress of each block at q, shapes (row, strain); empty where nobody looks.
    """

    q: Array
    v: Array
    rate: Array
    stress: list[Array]


class RunOfPlant(ABC):
    """A run that goes on as long as it is commanded."""

    problem: TransientProblem

    @abstractmethod
    def start(self) -> None:
        """Start, or go on from another run's state."""

    @abstractmethod
    def advance(self, number: int) -> bool:
        """Take the steps to an instant of the grid; whether they converged."""

    @abstractmethod
    def renew(self) -> None:
        """Meet a change of inputs and torques that were set anew at the present instant."""

    @abstractmethod
    def push(self, wrench: Array, time: float) -> None:
        """Hold a wrench on the hub from an instant [s] on, shape (6,)."""

    @property
    @abstractmethod
    def place(self) -> Place:
        """Where structure and hub are."""

    @abstractmethod
    def strain_energy(self) -> float:
        """Strain energy under the inputs of the present instant [J]."""

    @property
    def own(self) -> Array:
        """``u own u / 2`` is what stresses of inputs store at once in the structure that answers them, shape (n, n)."""
        return np.zeros((0, 0))

    @abstractmethod
    def wrench_of(self, load: Array, place: Place) -> Array:
        """Force, and torque about O, of forces on the free unknowns, hub axes, shape (6,)."""

    @abstractmethod
    def pressure_work(self, unit: PressureLoad, before: Place, at: Place) -> float:
        """Work of pressure on the structure between two places [J]."""

    @abstractmethod
    def pressure_push(self, unit: PressureLoad, place: Place) -> Array:
        """Force, and torque about O, of pressure, hub axes, shape (6,)."""

    def work_of(self, bound: LinearInput, value: Array, before: Place, at: Place) -> float:
        """Work on the structure of numbers of an input that is no stress between two places [J]."""
        if isinstance(bound, FilmPressure):
            return float(value[0]) * self.pressure_work(bound.unit, before, at)
        assert isinstance(bound, PatternLoad)
        return float(bound.pattern @ value @ (at.q - before.q))

    def push_of(self, bound: LinearInput, value: Array, place: Place) -> Array:
        """Force, and torque about O, of the same on the spacecraft, hub axes, shape (6,)."""
        if isinstance(bound, FilmPressure):
            return float(value[0]) * self.pressure_push(bound.unit, place)
        assert isinstance(bound, PatternLoad)
        return np.zeros(6) if bound.internal else bound.held @ value + self.wrench_of(bound.pattern @ value, place)

    @abstractmethod
    def look(self, stress: bool) -> Sight:
        """What sensors see; ``stress``: of stresses too."""

    @abstractmethod
    def checkpoint(self) -> Checkpoint:
        """State to go on from."""

    @abstractmethod
    def result(self, status: Status) -> Run:
        """What the run leaves."""
