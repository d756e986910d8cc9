"""State of a structure on a free hub at one instant."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tautflex.motion import rotations
from tautflex.numeric import Array
from tautflex.solvers.transient.free_hub.balance import RigidState, inertial, rigid_parts
from tautflex.solvers.transient.state import MotionState

_NONE = np.zeros(0)


@dataclass
class HubMotion(MotionState):
    """State of the structure and of the hub at one instant.

    Parameters
    ----------
    rigid
        The hub, shape (31,), see `RigidState`.
    balanced
        Elastic acceleration that balances all forces, shape (size,), where it is not ``a``.
    power, work
        Power of all external forces [W], and their work since the start [J].
    """

    rigid: Array = field(kw_only=True)
    balanced: Array = field(default_factory=lambda: _NONE, kw_only=True)
    power: float = field(default=0.0, kw_only=True)
    work: float = field(default=0.0, kw_only=True)

    @property
    def hub(self) -> RigidState:
        """The hub."""
        return rigid_parts(self.rigid)

    @property
    def true(self) -> Array:
        """Elastic acceleration that balances all forces, shape (size,)."""
        return self.balanced if self.balanced.size else self.a

    @property
    def velocity(self) -> Array:
        """Velocity of the floating frame's origin, inertial axes [m/s], shape (3,)."""
        velocity: Array = rotations.matrix(self.hub.attitude) @ self.hub.twist[:3]
        return velocity


def slopes(at: HubMotion) -> Array:
    """Rates of attitude, position, twist, momentum and work, shape (20,)."""
    hub = at.hub
    twist = hub.rates.copy()
    twist[:3] -= np.cross(hub.twist[3:], hub.twist[:3])
    attitude = 0.5 * rotations.product(hub.attitude, np.append(0.0, hub.twist[3:]))
    return np.concatenate([attitude, at.velocity, twist, inertial(hub.attitude, hub.position, hub.wrench), [at.power]])
