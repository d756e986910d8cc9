"""Rigid accelerations: the loads that they are, and the mass that resists them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tautflex.mechanics.inertia import InertiaOperator
from tautflex.numeric import Array, cross_matrix

RIGID_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


def rigid_loads(inertia: InertiaOperator, point: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Rows ``int rho N' e`` and ``int rho N' (e x (x - x_P))`` for the three unit vectors e, shape (6, size)."""
    translations = inertia.zeroth_moment
    turns = [cross_matrix(e) for e in np.eye(3)]
    return np.array([*translations, *(inertia.load(turn, -turn @ np.asarray(point)) for turn in turns)])


def rigid_mass(inertia: InertiaOperator, point: Array) -> Array:
    """Mass matrix of the rigid structure about a point [kg, kg m, kg m^2], shape (6, 6).

    ``[[m 1, -S(h)], [S(h), J]]`` with ``h = int rho r``, ``J = int rho (r.r 1 - r r')``, ``r = x - x_P``.
    """
    mass, first = inertia.mass, inertia.mass_moment - inertia.mass * point
    second = (
        inertia.second_moment
        - np.outer(inertia.mass_moment, point)
        - np.outer(point, inertia.mass_moment)
        + mass * np.outer(point, point)
    )
    turn = cross_matrix(first)
    return np.block([[mass * np.eye(3), -turn], [turn, np.trace(second) * np.eye(3) - second]])


def mass_center(inertia: InertiaOperator) -> tuple[Array, Array]:
    """Centre of mass [m], shape (3,), and inertia tensor about it [kg m^2], shape (3, 3); of no mass the origin."""
    center = inertia.mass_moment / (inertia.mass or 1.0)
    return center, rigid_mass(inertia, center)[3:, 3:]
