"""What drives, sensors and the loop ask of a plant's run, whatever model it is of."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

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
    @abstractmethod
    def own(self) -> Array:
        """``u own u / 2`` is what stresses of inputs store at once in the structure that answers them, shape (n, n)."""

    @abstractmethod
    def wrench_of(self, load: Array, place: Place) -> Array:
        """Force, and torque about O, of forces on the free unknowns, hub axes, shape (6,)."""

    @abstractmethod
    def look(self, stress: bool) -> Sight:
        """What sensors see; ``stress``: of stresses too."""

    @abstractmethod
    def checkpoint(self) -> Checkpoint:
        """State to go on from."""

    @abstractmethod
    def result(self, status: Status) -> Run:
        """What the run leaves."""
