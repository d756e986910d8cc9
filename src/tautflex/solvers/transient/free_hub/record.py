"""What a run on a free hub starts from, and what it leaves in the record beside the elastic motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from tautflex.errors import InputError
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import RigidMotion, Segment
from tautflex.motion.triples import axes_of, times
from tautflex.numeric import Array
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.free_hub.motion import HubMotion
from tautflex.solvers.transient.probes import ProbeSet
from tautflex.solvers.transient.recorder import Recorder
from tautflex.solvers.transient.restart.keeper import Storage, in_memory
from tautflex.solvers.transient.state import MotionState
from tautflex.solvers.variables import HUB, about, described

# Vectors of every sample, and where they and the attitude are in the hub and the work beside it, shape (32,).
_HISTORIES = ("hub_position", "hub_velocity", "linear_momentum", "angular_momentum")
_STORED = np.r_[0:10, 13:19, 31]


def check_coupling(coupling: Coupling) -> None:
    """Raise InputError unless all terms of the moving frame are on and whole: momentum has no switch and no factor."""
    if coupling != Coupling():
        raise InputError(f"coupling: expected all terms, whole, on a free hub, got {coupling!r}; leave coupling out")


def steady_motion(hub: FreeHub, inertia: InertiaOperator) -> RigidMotion:
    """Motion of the hub with its angular velocity kept and the centre of mass unaccelerated, or its origin held."""
    spin, own = np.asarray(hub.angular_velocity, dtype=float), np.asarray(hub.center, dtype=float)
    center = (inertia.mass_moment + hub.mass * own) / (inertia.mass + hub.mass)
    return RigidMotion(spin, np.zeros(3), -hub.freedom[:3] * np.cross(spin, np.cross(spin, center)))


class HubRecorder(Recorder):
    """Collects samples of a run on a free hub; parameters are those of `Recorder`."""

    def __init__(
        self, equation: EquationOfMotion, probes: ProbeSet, samples: int, field_steps: set[int], frame_steps: set[int],
        storage: Storage = in_memory,
    ) -> None:  # fmt: skip
        super().__init__(equation, probes, samples, field_steps, frame_steps, storage)
        self._of_hub = storage("hub", (len(self._time), 4 + 3 * len(_HISTORIES) + 1), "f8")

    def store(self, at: MotionState, segment: Segment) -> None:
        """Store one sample."""
        assert isinstance(at, HubMotion)
        self._store_hubs(np.append(at.rigid, at.work)[None])
        super().store(at, segment)
        self._numbers[self.count - 1, 0] = self._equation.kinetic_energy(at)

    def stored_on_hub(self, hubs: Array) -> None:
        """Count samples that `record` has stored, with the hub and the work at each, shape (n, 32)."""
        self._store_hubs(hubs)
        self.stored(np.concatenate([hubs[:, 10:13], hubs[:, 28:31], hubs[:, 25:28]], axis=1))

    def _store_hubs(self, hubs: Array) -> None:
        """Store what the next samples have of the hub, its velocity in its own axes still, and the work."""
        self._of_hub[self.count : self.count + len(hubs)] = hubs[:, _STORED]

    def to_dataset(self, attributes: dict[str, Any]) -> xr.Dataset:
        """Dataset with the hub's motion, momenta and work added; kinetic energy is that of the whole spacecraft."""
        rows = self._of_hub[: self.count]
        vectors = rows[:, 4:-1].reshape(-1, len(_HISTORIES), 3).copy()
        # All samples at once, by the numbers that compiled code turns one vector with.
        axes = axes_of.py_func(tuple(rows[:, :4].T))
        vectors[:, 1] = np.stack(times.py_func(axes, tuple(vectors[:, 1].T)), axis=1)
        return hub_variables(super().to_dataset(attributes), rows[:, :4], vectors, rows[:, -1])


def hub_variables(data: xr.Dataset, attitude: Array, vectors: Array, work: Array) -> xr.Dataset:
    """Dataset with the hub added: attitude (n, 4), position, velocity and both momenta (n, 4, 3), and work (n,) [J]."""
    arrays = {name: vectors[:, column] for column, name in enumerate(_HISTORIES)}
    data = data.assign(described(HUB, arrays | {"attitude": attitude, "work": work}) | {"quaternion": list("wxyz")})
    data["kinetic_energy"].attrs |= about(HUB["kinetic_energy"])
    return data
