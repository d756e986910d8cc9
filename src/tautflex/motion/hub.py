"""Free rigid hub: the spacecraft body that carries the structure and is moved by it [theory.md 9]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.text import brief


@dataclass(frozen=True)
class HubState:
    """What a feedback law may read.

    Parameters
    ----------
    time
        [s].
    attitude
        Unit quaternion, scalar first, floating frame -> inertial frame, shape (4,).
    angular_velocity
        In hub axes [rad/s], shape (3,).
    position, velocity
        Of the floating frame's origin, inertial axes [m], [m/s], shape (3,).
    probe_displacement, probe_velocity
        Elastic motion of the run's probes in hub axes [m], [m/s], shape (probe, 3).
    """

    time: float
    attitude: Array
    angular_velocity: Array
    position: Array
    velocity: Array
    probe_displacement: Array
    probe_velocity: Array
    __repr__ = brief


Actuation = Callable[[float, HubState], ArrayLike]


@dataclass(frozen=True)
class FreeHub:
    """Rigid hub that is free to move and carries the supports of the structure.

    Parameters
    ----------
    mass
        Mass of the hub [kg], > 0.
    inertia
        Inertia tensor about the hub's centre of mass in hub axes [kg m^2], shape (3,) or (3, 3).
    center
        Centre of mass of the hub in the floating frame [m].
    angular_velocity
        Spin at t = 0 in hub axes [rad/s].
    velocity
        Velocity of the floating frame's origin at t = 0, inertial axes [m/s].
    attitude
        Unit quaternion at t = 0, scalar first.
    torque, force
        Torque about the floating frame's origin [N m] and force at it [N], both in hub axes: None, three numbers, or
        a function (time, HubState) -> three numbers. A table goes in as a function, e.g. through
        `scipy.interpolate.CubicSpline`.
    breaks
        Instants at which torque or force jump [s]; integrators step onto them.
    axes
        What the hub is free to do, ``"free"`` (turn about all axes and move), ``"xyz"`` (turn about an origin at rest),
        or ``"x"``, ``"y"``, ``"z"`` (turn about that axis through an origin at rest).

    Raises
    ------
    InputError
        If a value has the wrong shape or range, no body has such an inertia, or the start or a force moves what the
        axes hold.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), axes="x").axes
    'x'
    """

    mass: float
    inertia: ArrayLike
    center: tuple[float, float, float] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    attitude: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    torque: ArrayLike | Actuation | None = None
    force: ArrayLike | Actuation | None = None
    breaks: tuple[float, ...] = ()
    axes: str = "free"
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.positive("mass", self.mass)
        checks.one_of("axes", self.axes, ("free", "xyz", "x", "y", "z"))
        for name in ("center", "angular_velocity", "velocity"):
            checks.vector3(name, getattr(self, name))
        tensor = self.tensor
        if not np.allclose(tensor, tensor.T) or np.linalg.eigvalsh(tensor)[0] <= 0.0:
            raise InputError(f"inertia: expected a symmetric positive definite tensor, got {tensor.tolist()}")
        smallest, middle, largest = np.linalg.eigvalsh(tensor)
        if largest > (1.0 + 1e-9) * (smallest + middle):
            raise InputError(
                f"inertia: expected moments of which none is larger than the sum of the others, as those of every body "
                f"are, got {smallest:g}, {middle:g}, {largest:g} kg m^2; check the tensor"
            )
        if abs(float(np.linalg.norm(checks.float_array("attitude", self.attitude, (4,)))) - 1.0) > 1e-6:
            raise InputError(f"attitude: expected a unit quaternion, scalar first, got {self.attitude!r}")
        for name in ("torque", "force"):
            value = getattr(self, name)
            if callable(value):
                checks.function(name, value, "time", "state")
            elif value is not None:
                checks.vector3(name, value)
        checks.float_array("breaks", self.breaks, (None,))
        free = self.freedom
        for name, allowed in (("velocity", free[:3]), ("angular_velocity", free[3:])):
            if np.any(np.asarray(getattr(self, name))[allowed == 0.0]):
                raise InputError(
                    f"{name}: expected none where axes = {self.axes!r} holds the hub, got {getattr(self, name)!r}"
                )
        if self.force is not None and not free[:3].any():
            raise InputError(
                f"force: expected None on a hub whose origin rests (axes = {self.axes!r}), got {self.force!r}; use "
                "axes = 'free'"
            )

    @property
    def freedom(self) -> Array:
        """1 where the velocity of the origin and the angular velocity, hub axes, are free, else 0, shape (6,)."""
        turns = [float(self.axes in ("free", "xyz", name)) for name in "xyz"]
        return np.array([float(self.axes == "free")] * 3 + turns)

    @property
    def tensor(self) -> Array:
        """Inertia tensor about the hub's centre of mass [kg m^2], shape (3, 3)."""
        given = checks.numbers("inertia", self.inertia)
        return checks.float_array("inertia", np.diag(given) if given.ndim == 1 else given, (3, 3))

    @property
    def offset_inertia(self) -> Array:
        """What its inertia about the floating frame's origin has beside `tensor` [kg m^2], shape (3, 3)."""
        center = np.asarray(self.center, dtype=float)
        return np.asarray(self.mass * (center @ center * np.eye(3) - np.outer(center, center)))

    @property
    def feedback(self) -> bool:
        """Whether force or torque is a function of time and motion."""
        return callable(self.force) or callable(self.torque)

    def wrench(self, state: HubState | None = None) -> Array:
        """Force [N] and torque [N m] in hub axes at a state, shape (6,); without feedback they need none."""
        return np.concatenate([_evaluate("force", self.force, state), _evaluate("torque", self.torque, state)])


def _evaluate(name: str, given: ArrayLike | Actuation | None, state: HubState | None) -> Array:
    if given is None:
        return np.zeros(3)
    if not callable(given):
        return checks.vector3(name, given)
    assert state is not None, "a function needs a state"
    return checks.vector3(name, given(state.time, state))
