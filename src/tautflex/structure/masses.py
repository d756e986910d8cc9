"""Rigid bodies at nodes: payloads, feeds, tip masses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.text import brief

_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class PointMass:
    """Rigid body fixed to a node: ``1/2 m |v + w x c|^2 + 1/2 w' J w`` with the node's velocity v and turn rate w.

    It follows the node's rotation, to second order in the forces of a turning frame: pendulum and propeller moments. A
    frame that speeds up has those of its angular acceleration left out, which are of the size of (angular acceleration)
    / (its own angular frequency)^2 beside the stiffness against that turn.

    Parameters
    ----------
    node
        Node number.
    mass
        Mass m [kg], >= 0.
    inertia
        Inertia J about the body's centre of mass, global axes [kg m^2]: one number, three principal moments, or a
        tensor of shape (3, 3). The node must carry a beam.
    offset
        Centre of mass c from the node [m], shape (3,). The node must carry a beam.

    Raises
    ------
    InputError
        If the mass is negative, the inertia not symmetric and positive semidefinite, or there is neither.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.PointMass(node=15, mass=2.5, inertia=(0.1, 0.1, 0.2)).mass
    2.5
    """

    node: int
    mass: float = 0.0
    inertia: ArrayLike = 0.0
    offset: ArrayLike = (0.0, 0.0, 0.0)
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.whole("node", self.node, 0)
        checks.non_negative("mass", self.mass)
        checks.vector3("offset", self.offset)
        tensor = self.tensor
        largest = float(np.abs(tensor).max())
        if not np.allclose(tensor, tensor.T, atol=_ROUND_OFF * largest):
            raise InputError(f"inertia: expected a symmetric tensor, got {tensor.tolist()}; correct it")
        if np.linalg.eigvalsh(tensor)[0] < -_ROUND_OFF * largest:
            raise InputError(f"inertia: expected moments >= 0, got the tensor {tensor.tolist()}; correct it")
        if self.mass == 0.0 and largest == 0.0:
            raise InputError("mass: expected a mass or an inertia > 0, got neither; give one, or leave the body out")
        if self.mass == 0.0 and self.arm.any():
            raise InputError(f"offset: expected none of a body without mass, got {self.arm.tolist()}; give a mass")

    @property
    def tensor(self) -> Array:
        """Inertia tensor about the centre of mass [kg m^2], shape (3, 3)."""
        given = checks.numbers("inertia", self.inertia)
        return checks.float_array("inertia", given * np.eye(3) if given.shape in ((), (3,)) else given, (3, 3))

    @property
    def arm(self) -> Array:
        """Offset as an array [m], shape (3,)."""
        return checks.vector3("offset", self.offset)

    @property
    def turns(self) -> bool:
        """Whether the node's rotation moves it."""
        return bool(self.arm.any() or self.tensor.any())
