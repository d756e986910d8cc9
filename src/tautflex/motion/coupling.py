"""Rigid-flexible coupling terms and their switches [paper (43)-(48), theory.md 3]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tautflex import checks
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array, cross_matrix
from tautflex.structure.kinds import ByKind, by_kind

if TYPE_CHECKING:  # reading a case file asks for the switches alone
    from tautflex.mechanics.inertia import LoadMoments
    from tautflex.mechanics.system import StructuralSystem


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
        Q_T, the load on the undeformed structure [paper (45)], true, false or a factor >= 0; one for all, or one by
        kind of element, such as ``{ membrane = 0.5, cable = 1.0, frame = 1.0 }``. A kind that is left out has 1.
    """

    gyroscopic: bool = True
    euler: bool = True
    centrifugal: bool = True
    inertial_load: float | bool | Mapping[str, float] = True

    def __post_init__(self) -> None:
        for name in ("gyroscopic", "euler", "centrifugal"):
            checks.flag(name, getattr(self, name))
        factor = by_kind("inertial_load", self.inertial_load, checks.non_negative, 1.0)
        object.__setattr__(self, "inertial_load", factor)

    def velocity_weight(self, motion: RigidMotion) -> Array:
        """Matrix Z of G = M(Z), shape (3, 3) [1/s]."""
        return 2.0 * cross_matrix(motion.angular_velocity) * float(self.gyroscopic)

    def displacement_weight(self, motion: RigidMotion) -> Array:
        """Matrix Z of K_T = M(Z), shape (3, 3) [1/s^2]."""
        return motion.euler * float(self.euler) + motion.centrifugal * float(self.centrifugal)

    @property
    def load_by_kind(self) -> ByKind | None:
        """Factors of Q_T where kinds of element differ; they are in what makes their loads."""
        return self.inertial_load if isinstance(self.inertial_load, ByKind) else None

    @property
    def load_factor(self) -> float:
        """Factor of all that makes Q_T, 1 where kinds of element have theirs."""
        return 1.0 if self.load_by_kind is not None else float(self.inertial_load)  # type: ignore[arg-type]

    def moments(self, system: StructuralSystem) -> LoadMoments:
        """What makes the load on a structure; if kinds of element differ, their factors are in it."""
        kinds = self.load_by_kind
        return system.inertia if kinds is None else system.load_moments(kinds)

    def load(self, motion: RigidMotion, moments: LoadMoments) -> Array:
        """Load Q_T [N, N m] from `moments`, shape (size,); it stands on the left of equation (49)."""
        factor = self.load_factor
        if factor == 0.0:
            return np.zeros(moments.size)
        return factor * moments.load(motion.euler + motion.centrifugal, motion.origin_acceleration)
