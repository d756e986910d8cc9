r"""Nonlinear laws: stress and tangent from the elastic trial stress [theory.md 2].

A law sees the trial stress ``s = sigma_0 + D strain`` of one element and replaces it. Both laws here are gradients of
a convex stored energy (Pipkin's relaxed energy), so that statics stay well posed:

* *slack* cable: ``s`` where positive, else nothing;
* *tension field*: with effective strain ``e = D^-1 s`` and principal values ``s_2 <= s_1``, ``e_1``,
  taut where ``s_2 >= 0``: ``s``; slack where ``e_1 <= 0``: nothing; else wrinkled, uniaxial tension ``E e_1`` along
  the major principal direction.

A small share of the elastic law, `RESIDUAL_STIFFNESS`, stays in slack and wrinkled states, so that Newton's tangent is
never singular; the compression it leaves is that share of the elastic law's.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ELASTIC, SLACK, TENSION_FIELD = 0, 1, 2
LAWS = {"elastic": ELASTIC, "slack": SLACK, "tension-field": TENSION_FIELD}
RESIDUAL_STIFFNESS = 1e-7
FILM_STATES = ("taut", "wrinkled", "slack")

_jit = numba.njit(cache=True, error_model="numpy")


@_jit
def slack_factor(trial: float, residual: float) -> float:
    """Factor on stress and stiffness of a cable at a trial stress [Pa]; ``residual`` where it is slack."""
    return 1.0 if trial > 0.0 else residual


@_jit
def film_state(sx: float, sy: float, txy: float, poisson_ratio: float) -> int:
    """Index in `FILM_STATES` of a plane stress, elastic trial or tension-field alike (mixed criterion)."""
    mean = 0.5 * (sx + sy)
    radius = np.sqrt(0.25 * (sx - sy) * (sx - sy) + txy * txy)
    # A uniaxial stress is taut in spite of its round-off.
    if mean - radius >= -1e-12 * (mean + radius) and mean + radius > 0.0:
        return 0
    # Major principal strain of the trial stress, times E.
    return 1 if mean + radius - poisson_ratio * (mean - radius) > 0.0 else 2


@_jit
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
    """Tension-field stress and tangent of an isotropic film.

    Parameters
    ----------
    sx, sy, txy
        Elastic trial stress [Pa].
    youngs_modulus, poisson_ratio
        Of the film [Pa], [-].
    residual
        Share of the elastic law that stays in wrinkled and slack states [-].
    stress
        Filled with the stress (sx, sy, txy) [Pa], shape (3,).
    tangent
        Filled with d stress / d strain (engineering shear) [Pa], shape (3, 3).

    Returns
    -------
    float
        Stored energy density [J/m^3].
    """
    nu = poisson_ratio
    ex, ey, gamma = (
        (sx - nu * sy) / youngs_modulus,
        (sy - nu * sx) / youngs_modulus,
        2.0 * (1.0 + nu) * txy / youngs_modulus,
    )
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
