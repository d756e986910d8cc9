r"""Momentum balance of a hub with an elastic structure [theory.md 9].

All components are in hub axes, moments about the floating frame's origin O. With rigid velocities (v0, w), elastic
unknowns q and rho = x + u,

    (p, h) = R(q) (v0, w) + B(q) dq,    R = [[m 1, -S(s)], [S(s), J]],    B = [int N; int S(rho) N],

where every block comes from the constant moments of the inertia operator. The rate of (p, h) gives

    R (a0, dw) = (F, T) - B ddq - (w x (w x s) + 2 w x Z dq,  w x J w + 2 (tr(D) 1 - D') w),   D_ab = int rho_a du_b,

and the elastic equation gains B' (a0, dw), which is Q_T and K_T of a prescribed motion written at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.inertia import InertiaOperator, cross_matrix
from tautflex.motion.hub import FreeHub
from tautflex.numeric import cross

Array = NDArray[np.float64]

_LEVI_CIVITA = [(0, 1, 2, 1.0), (1, 2, 0, 1.0), (2, 0, 1, 1.0), (0, 2, 1, -1.0), (1, 0, 2, -1.0), (2, 1, 0, -1.0)]


@dataclass(frozen=True)
class RigidBlocks:
    """Momentum blocks at one elastic state.

    Parameters
    ----------
    mass
        R(q), shape (6, 6).
    coupling
        B(q), shape (6, size).
    first
        s = int rho [kg m], shape (3,).
    tensor
        J about the origin [kg m^2], shape (3, 3).
    lever
        ``int rho_a N_b`` [kg m], shape (3, 3, size): ``lever[a, b] @ dq`` is D_ab.
    """

    mass: Array
    coupling: Array
    first: Array
    tensor: Array
    lever: Array


class MomentumBalance:
    """Momentum blocks and rigid accelerations of hub plus structure.

    Parameters
    ----------
    inertia
        Inertia operator of the structure.
    hub
        The hub.
    """

    def __init__(self, inertia: InertiaOperator, hub: FreeHub) -> None:
        center = np.asarray(hub.center, dtype=float)
        self._inertia = inertia
        self.mass = inertia.mass + hub.mass
        self._first = inertia.mass_moment + hub.mass * center
        self._hub_tensor = hub.tensor + hub.mass * (center @ center * np.eye(3) - np.outer(center, center))
        self._unit = np.eye(3)

    def blocks(self, q: Array) -> RigidBlocks:
        """Momentum blocks at elastic unknowns ``q``."""
        inertia, size = self._inertia, self._inertia.pattern.size
        lever = np.empty((3, 3, size))
        for a in range(3):
            for b in range(3):
                # int rho (x_a + u_a) N_b, with int rho N_b' N_a q for the second part
                lever[a, b] = inertia.first_moment[b, a] + inertia.apply(np.outer(self._unit[b], self._unit[a]), q)
        coupling = np.zeros((6, size))
        coupling[:3] = inertia.zeroth_moment
        for k, a, b, sign in _LEVI_CIVITA:
            coupling[3 + k] += sign * lever[a, b]
        first = self._first + inertia.zeroth_moment @ q
        # int rho rho' = X2 + (x u' + u x') + u u'
        mixed = np.einsum("bai,i->ab", inertia.first_moment, q)
        square = np.einsum("abi,i->ab", lever, q) - mixed
        second = inertia.second_moment + mixed + mixed.T + 0.5 * (square + square.T)
        tensor = float(np.trace(second)) * np.eye(3) - second + self._hub_tensor
        mass = np.zeros((6, 6))
        mass[:3, :3], mass[3:, 3:] = self.mass * np.eye(3), tensor
        mass[3:, :3] = cross_matrix(first)
        mass[:3, 3:] = -mass[3:, :3]
        return RigidBlocks(mass, coupling, first, tensor, lever)

    def rates(self, blocks: RigidBlocks, wrench: Array, spin: Array, v: Array, acceleration: Array) -> Array:
        """Rigid accelerations (a0, dw) in hub axes [m/s^2], [rad/s^2], shape (6,).

        Parameters
        ----------
        blocks
            Momentum blocks at the elastic state.
        wrench
            Force and torque, shape (6,).
        spin
            Angular velocity [rad/s], shape (3,).
        v, acceleration
            Elastic velocities and accelerations, shape (size,).
        """
        right = wrench - blocks.coupling @ acceleration
        right[:3] -= cross(spin, cross(spin, blocks.first)) + 2.0 * cross(spin, blocks.coupling[:3] @ v)
        flow = np.einsum("abi,i->ab", blocks.lever, v)
        right[3:] -= cross(spin, blocks.tensor @ spin)
        right[3:] -= 2.0 * (np.trace(flow) * spin - flow.T @ spin)
        return np.asarray(np.linalg.solve(blocks.mass, right))
