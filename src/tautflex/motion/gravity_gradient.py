"""Torque of gravity on a spacecraft in a circular orbit: its near parts are pulled more than its far ones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.system import HasSystem, StructuralSystem, system_of
from tautflex.motion.hub import FreeHub, HubState
from tautflex.motion.rotations import exponential, matrix
from tautflex.numeric import Array
from tautflex.text import brief


@dataclass(frozen=True)
class GravityGradient:
    """``3 n^2 d x J d`` with the direction d to the centre of the Earth in hub axes [Hughes 1986, 8.1]: a hub's torque.

    Parameters
    ----------
    inertia
        Inertia of the whole spacecraft about its centre of mass in hub axes [kg m^2], shape (3, 3); see
        `gravity_gradient`.
    orbital_rate
        Angular velocity n of the circular orbit [rad/s], > 0; 1.1e-3 in a low one.
    nadir
        Direction to the Earth at t = 0 in inertial axes, of any length.
    orbit_normal
        Axis of the orbit in inertial axes, of any length, across ``nadir``.

    Raises
    ------
    InputError
        If a value has the wrong shape or range.
    """

    inertia: ArrayLike
    orbital_rate: float
    nadir: ArrayLike = (0.0, 0.0, -1.0)
    orbit_normal: ArrayLike = (0.0, 1.0, 0.0)
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.float_array("inertia", self.inertia, (3, 3))
        checks.positive("orbital_rate", self.orbital_rate)
        down, normal = (self._unit(name) for name in ("nadir", "orbit_normal"))
        if abs(down @ normal) > 1e-9:
            raise InputError(
                f"orbit_normal: expected an axis across the nadir, got {self.orbit_normal!r} beside {self.nadir!r}"
            )

    def _unit(self, name: str) -> Array:
        vector = checks.vector3(name, getattr(self, name))
        if not vector.any():
            raise InputError(f"{name}: expected a vector with a length, got {vector.tolist()}; give a direction")
        return np.asarray(vector / np.linalg.norm(vector))

    @cached_property
    def _parts(self) -> tuple[Array, Array, Array]:
        """Inertia, nadir at t = 0, and axis times rate."""
        return np.array(self.inertia, dtype=float), self._unit("nadir"), self.orbital_rate * self._unit("orbit_normal")

    def __call__(self, time: float, state: HubState) -> Array:
        """Torque at an instant [s] in hub axes [N m], shape (3,)."""
        inertia, nadir, turning = self._parts
        down = matrix(state.attitude).T @ (matrix(exponential(time * turning)) @ nadir)
        return np.asarray(3.0 * self.orbital_rate**2 * np.cross(down, inertia @ down))


def gravity_gradient(
    source: StructuralSystem | HasSystem,
    hub: FreeHub,
    orbital_rate: float,
    nadir: ArrayLike = (0.0, 0.0, -1.0),
    orbit_normal: ArrayLike = (0.0, 1.0, 0.0),
) -> GravityGradient:
    """Torque of gravity on a structure and its hub, as they are at rest.

    Write ``replace(hub, torque=gravity_gradient(state, hub, 1.1e-3))``. The deflection of the structure changes neither
    the inertia nor the pull on its parts here: those differ by ``n^2 x``, a millionth of g and less per metre.

    Parameters
    ----------
    source
        State or reduced model.
    hub
        The hub that carries it.
    orbital_rate, nadir, orbit_normal
        See `GravityGradient`.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> hub = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0))
    >>> pull = tf.gravity_gradient(state, hub, orbital_rate=1.1e-3)
    >>> from dataclasses import replace
    >>> replace(hub, torque=pull).torque is pull
    True
    """
    checks.instance("hub", hub, FreeHub, "a FreeHub(...)")
    structure = system_of("source", source).inertia
    center = np.asarray(hub.center, dtype=float)
    mass = structure.mass + hub.mass
    middle = (structure.mass_moment + hub.mass * center) / mass
    second = structure.second_moment + hub.mass * np.outer(center, center) - mass * np.outer(middle, middle)
    return GravityGradient(hub.tensor + np.trace(second) * np.eye(3) - second, orbital_rate, nadir, orbit_normal)
