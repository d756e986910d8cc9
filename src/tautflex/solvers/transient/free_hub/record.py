"""What a run on a free hub starts from, and what it leaves in the record beside the elastic motion."""

from __future__ import annotations

import numpy as np
import xarray as xr

from tautflex.errors import InputError
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.numeric import Array
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.equation import MotionState
from tautflex.solvers.transient.free_hub.equation import HubEquation, HubMotion
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.variables import COMPONENTS, HUB, about, described

# Vectors of every sample.
_HISTORIES = ("hub_position", "hub_velocity", "linear_momentum", "angular_momentum")


_REST = RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))


def check_coupling(coupling: Coupling) -> None:
    """Raise InputError unless all terms of the moving frame are on: momentum has no switch."""
    if coupling != Coupling():
        raise InputError(f"coupling: expected all terms on a free hub, got {coupling!r}; leave coupling out")


class HubFlight:
    """One run on a free hub.

    Parameters
    ----------
    equation
        Equation of motion.
    """

    def __init__(self, equation: HubEquation) -> None:
        self._equation = equation
        self._samples: list[tuple[Array, Array, float]] = []

    def segments(self) -> tuple[Segment, ...]:
        """One segment: the motion is not known beforehand."""
        return (Segment(0.0, np.inf, lambda time: _REST),)

    def start(self, velocity: Array) -> HubMotion:
        """Spinning equilibrium for the hub's angular velocity with the centre of mass unaccelerated."""
        equation = self._equation
        spin, center = np.asarray(equation.hub.angular_velocity, dtype=float), equation.body[10] / equation.body[9]
        motion = RigidMotion(spin, np.zeros(3), -np.cross(spin, np.cross(spin, center)))
        q = spinning_equilibrium(equation.state, motion, Coupling())
        return equation.start(0.0, q, velocity, motion)

    def record(self, recorder: Recorder, driver: GridDriver, at: MotionState, step: int, every: int) -> None:
        """Store the sample and the field of a grid step."""
        assert isinstance(at, HubMotion)
        recorder.store_field(step, at.time, at.q)
        if step % every:
            return
        equation, hub = self._equation, at.hub
        equation.set_time(at.time)
        strain = equation.workspace.strain_energy(at.q) - float(equation.state.reference_force @ at.q)
        motion = equation.motion(at, driver.segment_at(at.time))
        recorder.store(at.time, at.q, at.v, motion, equation.kinetic_energy(at), strain)
        vectors = np.array([hub.position, at.velocity, hub.momentum[:3], hub.momentum[3:]])
        self._samples.append((hub.attitude, vectors, at.work))

    def complete(self, data: xr.Dataset) -> xr.Dataset:
        """Dataset with the hub's motion, momenta and work added; kinetic energy is that of the whole spacecraft."""
        vectors = np.array([sample[1] for sample in self._samples]).reshape(-1, 4, 3)
        arrays = {name: vectors[:, column] for column, name in enumerate(_HISTORIES)}
        arrays["attitude"] = np.array([sample[0] for sample in self._samples]).reshape(-1, 4)
        arrays["work"] = np.array([sample[2] for sample in self._samples])
        data = data.assign(described(HUB, arrays)).assign_coords(component=COMPONENTS, quaternion=["w", "x", "y", "z"])
        data["kinetic_energy"].attrs |= about(HUB["kinetic_energy"])
        return data
