"""Rigid-flexible coupling terms and their switches [paper (43)-(48), theory.md 3]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tautflex import checks
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array, cross_matrix

if TYPE_CHECKING:  # reading a case file asks for the switches alone
    from tautflex.mechanics.inertia import LoadMoments


@dataclass(frozen=True)
class Coupling:
    """Which terms of the rotating frame are kept; all by default.

    Parameters
    ----------
    gyroscopic
        G, the Coriolis force on relative velocity [paper (43)].
    euler
        S(dw) part of K_T, skew [paper (44)].
    centrifugal
        S(w)^2 part of K_T, softening [paper (44)].
    inertial_load
        Q_T, the load on the undeformed structure [paper (45)].
    """

    gyroscopic: bool = True
    euler: bool = True
    centrifugal: bool = True
    inertial_load: bool = True

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            checks.flag(name, value)

    def velocity_weight(self, motion: RigidMotion) -> Array:
        """Matrix Z of G = M(Z), shape (3, 3) [1/s]."""
        return 2.0 * cross_matrix(motion.angular_velocity) * float(self.gyroscopic)

    def displacement_weight(self, motion: RigidMotion) -> Array:
        """Matrix Z of K_T = M(Z), shape (3, 3) [1/s^2]."""
        return motion.euler * float(self.euler) + motion.centrifugal * float(self.centrifugal)

    def load(self, motion: RigidMotion, inertia: LoadMoments) -> Array:
        """Load Q_T on the free unknowns [N, N m], shape (size,); it stands on the left of equation (49)."""
        if not self.inertial_load:
            return np.zeros(inertia.size)
        return inertia.load(motion.euler + motion.centrifugal, motion.origin_acceleration)
