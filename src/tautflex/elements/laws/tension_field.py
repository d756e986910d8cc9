"""Tension field: film that wrinkles instead of carrying compression [theory.md 2].

With effective strain ``e = D^-1 s`` of the trial stress and principal values ``s_2 <= s_1``, ``e_1``: taut where
``s_2 >= 0``, ``s``; slack where ``e_1 <= 0``, nothing; else wrinkled, uniaxial tension ``E e_1`` along the major
principal direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numba
import numpy as np

from tautflex.elements.laws.law import LawFunction, TensionOnly, register_law
from tautflex.numeric import FASTMATH, Array
from tautflex.structure.materials import Material


@numba.njit(cache=True, fastmath=FASTMATH, error_model="numpy")
def tension_field(
    sx: float,
    sy: float,
    txy: float,
    youngs_modulus: float,
    poisson_ratio: float,
    residual: float,
    stress: Array,
    tangent: Array,
) -> float:
    """Stored energy [J/m^3] at an elastic trial stress [Pa]; stress and tangent [Pa] are filled in.

    ``residual`` is the share of the elastic law that stays in wrinkled and slack states; ``tangent`` has the
    derivatives by (ex, ey, engineering shear).
    """
    nu = poisson_ratio
    ex, ey = (sx - nu * sy) / youngs_modulus, (sy - nu * sx) / youngs_modulus
    gamma = 2.0 * (1.0 + nu) * txy / youngs_modulus
    elastic = 0.5 * (sx * ex + sy * ey + txy * gamma)
    plane = youngs_modulus / (1.0 - nu * nu)
    half, shear = 0.5 * (ex - ey), 0.5 * gamma
    radius = np.sqrt(half * half + shear * shear)
    major, minor = 0.5 * (ex + ey) + radius, 0.5 * (ex + ey) - radius
    taut = minor + nu * major >= 0.0 and major >= 0.0
    keep = 1.0 if taut else residual
    stress[0], stress[1], stress[2] = keep * sx, keep * sy, keep * txy
    tangent[0, 0] = tangent[1, 1] = keep * plane
    tangent[0, 1] = tangent[1, 0] = keep * plane * nu
    tangent[2, 2] = keep * 0.5 * plane * (1.0 - nu)
    tangent[0, 2] = tangent[2, 0] = tangent[1, 2] = tangent[2, 1] = 0.0
    if taut or major <= 0.0:
        return keep * elastic
    # Wrinkled: energy E e_1^2 / 2 with e_1 = mean + radius; radius > 0 because minor < -nu major < major.
    rest = (1.0 - keep) * youngs_modulus
    slope = (0.5 * (1.0 + half / radius), 0.5 * (1.0 - half / radius), 0.5 * shear / radius)
    curve = 0.25 * rest * major / radius**3
    bend = (shear, -shear, -half)
    for i in range(3):
        stress[i] += rest * major * slope[i]
        for j in range(3):
            tangent[i, j] += rest * slope[i] * slope[j] + curve * bend[i] * bend[j]
    return keep * elastic + 0.5 * rest * major * major


@LawFunction
def tension_field_points(stress: Array, tangent: Array, energy: Array, parameters: Array, count: int) -> None:
    """`tension_field` at every point; parameters: Young's modulus [Pa], Poisson ratio, residual share."""
    young, poisson, residual = parameters
    result, slope = np.empty(3), np.empty((3, 3))
    for e in range(count):
        energy[e] = tension_field(stress[0, e], stress[1, e], stress[2, e], young, poisson, residual, result, slope)
        for s in range(3):
            stress[s, e] = result[s]
            for r in range(3):
                tangent[s, r, e] = slope[s, r]


@register_law
@dataclass(frozen=True)
class TensionField(TensionOnly):
    """Film that wrinkles instead of carrying compression; option: `residual`."""

    name: ClassVar[str] = "tension-field"
    sections: ClassVar[tuple[str, ...]] = ("membrane",)
    function: ClassVar[LawFunction | None] = tension_field_points

    def parameters(self, material: Material) -> tuple[float, ...]:
        """Young's modulus [Pa], Poisson ratio and residual share."""
        return material.youngs_modulus, material.poisson_ratio, self.residual
