"""What a run on a free hub starts from, and what it leaves in the record beside the elastic motion."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.errors import InputError
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.motion.rotations import matrix
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.driver import GridDriver
from tautflex.solvers.transient.equation import MotionState
from tautflex.solvers.transient.free_hub.stepper import HubMotion, HubStepper
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.variables import COMPONENTS, HUB, about, described

Array = NDArray[np.float64]

# Vectors of every sample.
_HISTORIES = ("hub_position", "hub_velocity", "linear_momentum", "angular_momentum")


def check_coupling(coupling: Coupling) -> None:
    """Raise InputError unless all terms of the moving frame are on: momentum has no switch."""
    if coupling != Coupling():
        raise InputError(f"coupling: expected all terms on a free hub, got {coupling!r}; leave coupling out")


class HubFlight:
    """One run on a free hub.

    Parameters
    ----------
    state
        Prestressed state.
    hub
        The hub.
    stepper
        Its stepper.
    """

    def __init__(self, state: PrestressedState, hub: FreeHub, stepper: HubStepper) -> None:
        self._state, self._hub, self._stepper = state, hub, stepper
        self._samples: list[tuple[Array, Array, float]] = []

    def segments(self) -> tuple[Segment, ...]:
        """One segment: the motion is not known beforehand."""
        rest = RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3))
        return (Segment(0.0, np.inf, lambda time: rest),)

    def start(self, velocity: Array) -> HubMotion:
        """Spinning equilibrium for the hub's angular velocity with the centre of mass unaccelerated."""
        spin = np.asarray(self._hub.angular_velocity, dtype=float)
        inertia = self._state.system.inertia
        center = inertia.mass_moment + self._hub.mass * np.asarray(self._hub.center, dtype=float)
        center = center / (inertia.mass + self._hub.mass)
        motion = RigidMotion(spin, np.zeros(3), -np.cross(spin, np.cross(spin, center)))
        q = spinning_equilibrium(self._state, motion, Coupling())
        return self._stepper.start(0.0, q, velocity)

    def record(self, recorder: Recorder, driver: GridDriver, at: MotionState, step: int, every: int) -> None:
        """Store the sample and the field of a grid step."""
        assert isinstance(at, HubMotion)
        recorder.store_field(step, at.time, at.q)
        if step % every:
            return
        self._stepper.equation.set_time(at.time)
        energy = self._state.system.strain_energy(at.q)
        strain = energy - float(self._state.reference_force @ at.q)
        motion = RigidMotion(at.twist[3:], at.rates[3:], at.rates[:3])
        recorder.store(at.time, at.q, at.v, motion, (self._stepper.energy(at), strain))
        vectors = np.array([at.position, matrix(at.attitude) @ at.twist[:3], at.momentum[:3], at.momentum[3:]])
        self._samples.append((at.attitude, vectors, at.work))

    def complete(self, data: xr.Dataset) -> xr.Dataset:
        """Dataset with the hub's motion, momenta and work added; kinetic energy is that of the whole spacecraft."""
        vectors = np.array([sample[1] for sample in self._samples]).reshape(-1, 4, 3)
        arrays = {name: vectors[:, column] for column, name in enumerate(_HISTORIES)}
        arrays["attitude"] = np.array([sample[0] for sample in self._samples]).reshape(-1, 4)
        arrays["work"] = np.array([sample[2] for sample in self._samples])
        data = data.assign(described(HUB, arrays)).assign_coords(component=COMPONENTS, quaternion=["w", "x", "y", "z"])
        data["kinetic_energy"].attrs |= about(HUB["kinetic_energy"])
        return data
