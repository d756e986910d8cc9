"""Tension field: film that wrinkles instead of carrying compression [theory.md 2].

With effective strain ``e = D^-1 s`` of the trial stress and principal values ``s_2 <= s_1``, ``e_1``: taut where
``s_2 >= 0``, ``s``; slack where ``e_1 <= 0``, nothing; else wrinkled, uniaxial tension ``E e_1`` along the major
principal direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex.elements.laws.law import LawFunction, TensionOnly, register_law
from tautflex.numeric import Array, jit
from tautflex.structure.materials import Material

# Two points are exact for the stress of taut and slack parts; in wrinkled ones they serve the tangent alone.
_GAUSS = (0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0))


@jit
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


@jit
def _inside(slope: float, start: Array, end: Array) -> tuple[float, float]:
    """Where between two states ``slope * mean >= radius``, a cone: one stretch, as shares of the way; else (1, 1).

    States are mean, half difference and half shear of the strains. Ends are roots of the square of that border.
    """
    move = end - start
    radius, radius_end = np.hypot(start[1], start[2]), np.hypot(end[1], end[2])
    above, above_end = slope * start[0] - radius, slope * end[0] - radius_end
    square = (slope * move[0]) ** 2 - move[1] ** 2 - move[2] ** 2
    half = slope * slope * start[0] * move[0] - start[1] * move[1] - start[2] * move[2]
    constant = above * (slope * start[0] + radius)
    root = np.sqrt(max(half * half - square * constant, 0.0))
    # The larger of two roots loses nothing in its sum, and their product gives the other one.
    enter = -constant / (half + root) if half >= 0.0 else (root - half) / square
    leave = -(half + root) / square if half >= 0.0 else constant / (root - half)
    if above < 0.0 and above_end < 0.0:
        crossed = square < 0.0 and half > 0.0 and half < -square and half * half > square * constant
        if not (crossed and slope * (start[0] * square - move[0] * half) < 0.0):
            return 1.0, 1.0
    first, last = 0.0 if above >= 0.0 else enter, 1.0 if above_end >= 0.0 else leave
    return min(max(0.0, first), 1.0), min(max(0.0, last), 1.0)


@jit
def _wrinkled_mean(start: Array, end: Array, stress: Array) -> None:
    """Fill in the mean stress of a wrinkled film between two states, mean, half difference and half shear of E e.

    The stress is ``(mean + radius) (1 + n) / 2`` with the unit vector ``n = (difference, shear) / radius``. The means
    of radius, n and n times the share of the way follow from that of 1 / radius, ``2 artanh(z) / length`` with z =
    length / (sum of both radii) [docs/integrators.md]. Whatever the last digits of ``bend`` are, the work of the mean
    stress is the change of ``(mean + radius)^2 / 2``.
    """
    total = np.hypot(start[1], start[2]) + np.hypot(end[1], end[2])
    middle, move = 0.5 * (start + end), end - start
    length2 = move[1] ** 2 + move[2] ** 2
    if total == 0.0:
        stress[0] = stress[1] = 0.5 * middle[0]
        stress[2] = 0.0
        return
    z2 = min(length2 / (total * total), 1.0 - 1e-16)
    # bend = (artanh(z) / z - 1) / z^2
    if z2 > 0.1:
        z = np.sqrt(z2)
        bend = (np.arctanh(z) / z - 1.0) / z2
    else:
        bend = 0.0
        for k in range(16, -1, -1):
            bend = bend * z2 + 1.0 / (2 * k + 3)
    growth = 2.0 * (middle[1] * move[1] + middle[2] * move[2]) / total
    sag = (length2 - growth * growth) * (1.0 - bend * (1.0 - z2)) / (4.0 * total)
    curve = (sag + growth * growth * bend / (2.0 * total)) / length2 if length2 > 0.0 else 0.0
    # Factors of middle and move: n has (along, -turn), n times (share - 1/2) has (-turn, curve).
    along, turn = 2.0 * (1.0 + z2 * bend) / total, growth * bend / (total * total)
    of_middle = 1.0 + middle[0] * along - move[0] * turn
    of_move = move[0] * curve - middle[0] * turn
    size = middle[0] + 0.5 * total - sag
    tilt = of_middle * middle[1] + of_move * move[1]
    stress[0], stress[1] = 0.5 * (size + tilt), 0.5 * (size - tilt)
    stress[2] = 0.5 * (of_middle * middle[2] + of_move * move[2])


@LawFunction
def tension_field_average(stress: Array, tangent: Array, energy: Array, parameters: Array, count: int) -> None:
    """`Law.average` of the tension field: the way is cut where it enters or leaves taut and slack states."""
    young, poisson, residual = parameters
    start, end, first, last = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    cuts, trial, point, result, mean, slope = (
        np.empty(6),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty((3, 3)),
    )
    for e in range(count):
        for state, row in ((start, 0), (end, 3)):
            state[0] = 0.5 * (1.0 - poisson) * (stress[row, e] + stress[row + 1, e])
            state[1] = 0.5 * (1.0 + poisson) * (stress[row, e] - stress[row + 1, e])
            state[2] = (1.0 + poisson) * stress[row + 2, e]
        taut = _inside((1.0 + poisson) / (1.0 - poisson), start, end)
        slack = _inside(-1.0, start, end)
        near, far = (taut, slack) if sum(taut) <= sum(slack) else (slack, taut)
        cuts[:] = 0.0, near[0], near[1], far[0], far[1], 1.0
        mean.fill(0.0)
        tangent[:, :, e] = 0.0
        for part in range(5):
            a, b = cuts[part], cuts[part + 1]
            if b <= a:
                continue
            result.fill(0.0)
            for place in _GAUSS:
                share = a + (b - a) * place
                for s in range(3):
                    trial[s] = (1.0 - share) * stress[s, e] + share * stress[3 + s, e]
                tension_field(trial[0], trial[1], trial[2], young, poisson, residual, point, slope)
                for r in range(3):
                    result[r] += 0.5 * point[r]
                    for s in range(3):
                        tangent[r, s, e] += (b - a) * share * slope[r, s]
            if part % 2 == 0:
                for s in range(3):
                    first[s], last[s] = (1.0 - a) * start[s] + a * end[s], (1.0 - b) * start[s] + b * end[s]
                    trial[s] = stress[s, e] + 0.5 * (a + b) * (stress[3 + s, e] - stress[s, e])
                _wrinkled_mean(first, last, point)
                for s in range(3):
                    result[s] = residual * trial[s] + (1.0 - residual) * point[s]
            for s in range(3):
                mean[s] += (b - a) * result[s]
        for s in range(3):
            stress[s, e] = mean[s]


@register_law
@dataclass(frozen=True)
class TensionField(TensionOnly):
    """Film that wrinkles instead of carrying compression; option: `residual`."""

    name: ClassVar[str] = "tension-field"
    sections: ClassVar[tuple[str, ...]] = ("membrane",)
    function: ClassVar[LawFunction | None] = tension_field_points
    average: ClassVar[LawFunction | None] = tension_field_average

    def parameters(self, material: Material) -> tuple[float, ...]:
        """Young's modulus [Pa], Poisson ratio and residual share."""
        return material.youngs_modulus, material.poisson_ratio, self.residual
