"""A constitutive law: worn film that has kept a share of its stress and stiffness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import tautflex as tf


@tf.LawFunction
def worn(stress, tangent, energy, parameters, count):
    """A share of the elastic plane stress; parameters: Young's modulus [Pa], Poisson's ratio, share."""
    young, nu, share = parameters
    plane = share * young / (1.0 - nu * nu)
    for e in range(count):
        sx, sy, txy = stress[0, e], stress[1, e], stress[2, e]
        energy[e] = 0.5 * share * (sx * sx + sy * sy - 2.0 * nu * sx * sy + 2.0 * (1.0 + nu) * txy * txy) / young
        stress[0, e], stress[1, e], stress[2, e] = share * sx, share * sy, share * txy
        for i in range(3):
            for j in range(3):
                tangent[i, j, e] = 0.0
        tangent[0, 0, e], tangent[1, 1, e] = plane, plane
        tangent[0, 1, e], tangent[1, 0, e] = nu * plane, nu * plane
        tangent[2, 2, e] = 0.5 * (1.0 - nu) * plane


@tf.register
@dataclass(frozen=True)
class Worn(tf.Law):
    """Film that has kept half of its stiffness, and with it of its tension.

    Parameters
    ----------
    kept
        Share of the elastic stress that is left.
    """

    name: ClassVar[str] = "worn"
    sections: ClassVar[tuple[str, ...]] = ("membrane",)
    function: ClassVar[tf.LawFunction | None] = worn
    kept: float = 0.5

    def parameters(self, material: tf.Material) -> tuple[float, ...]:
        return material.youngs_modulus, material.poisson_ratio, self.kept
