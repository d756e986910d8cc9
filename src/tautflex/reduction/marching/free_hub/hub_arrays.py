r"""What a reduced model on a free hub adds to its own arrays [theory.md 9]: inertia that hub and coordinates share.

With the coordinates' displacement ``V z``, z = (eta, y) coordinates and monomials (the static derivatives that follow
them), S_k the cross-product matrix of the hub's axis k and ``rho = x + V z``, everything is linear or quadratic in z:

    B_k = int rho e_k . (rho x V) = b_k + A_k z,                     A_k  = M(S_k), skew
    g_kl = int rho V' S_k S_l rho (even part) = c_kl + D_kl z,       D_kl = M((S_k S_l + S_l S_k) / 2)
    J_kl = J0_kl - (2 c_kl z + z' D_kl z),                           s = s0 + int rho V z.

What static derivatives do among themselves is left out, here as in the equation of prescribed motion: they have no mass
there. The Lagrangian keeps all its symmetries, so that momentum and energy stay exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.mechanics.inertia import InertiaOperator
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array, Indices, cross_matrix
from tautflex.reduction.polynomial.condensation import CondensedModel

# Terms below this part of the largest of their kind are round-off of a symmetric structure.
_ROUND_OFF = 1e-12


class HubArrays(NamedTuple):
    """Constant arrays of r coordinates and m monomials on a hub that turns about n axes, which make k pairs.

    Parameters
    ----------
    freedom
        1 for velocities of the origin and angular velocities that are free, shape (6,).
    turns
        Axes about which the hub turns, shape (n,).
    first, second
        Places in ``turns`` of the pairs, shape (k,).
    reach, reach_follow
        b of unit accelerations of the hub, on coordinates and monomials, shapes (6, r) and (6, m).
    spin, spin_follow
        A on coordinates, and between coordinates and monomials (transposed), shapes (n, r, r) and (n, r, m).
    pull, pull_follow, square, square_follow
        c and D of the pairs, likewise.
    spun, squared
        Whether ``spin_follow`` and ``square_follow`` have entries, shapes (n,) and (k,).
    mass, center, tensor
        Of hub and structure at the reference [kg], [kg m], [kg m^2], the latter shapes (3,) and (3, 3).
    """

    freedom: Array
    turns: Indices
    first: Indices
    second: Indices
    reach: Array
    reach_follow: Array
    spin: Array
    spin_follow: Array
    pull: Array
    pull_follow: Array
    square: Array
    square_follow: Array
    spun: Array
    squared: Array
    mass: float
    center: Array
    tensor: Array


class HubInputs(NamedTuple):
    """What acts from outside at a row of instants; arrays with one row hold for all.

    Parameters
    ----------
    load, stress
        As of `FrameTerms`, but of inputs alone, shapes (n, r) and (n, m).
    inside, inside_stress
        What of these changes of stress do, which are not forces from outside, shapes (n, r) and (n, m); (n, 0): none.
    wrench
        Force, and torque about O, on hub and structure at the reference, hub axes, shape (n, 6).
    arms
        Torque per coordinate, what forces gain in arm as their nodes move, shape (n, 3, r); (n, 6, r): force and torque
        of pressure, whose direction changes, too.
    """

    load: Array
    stress: Array
    inside: Array
    inside_stress: Array
    wrench: Array
    arms: Array


def hub_arrays(
    c: CondensedModel, inertia: InertiaOperator, hub: FreeHub, size: int, freedom: Array | None = None
) -> HubArrays:
    """Arrays of a reduced model whose structure has this inertia; ``freedom`` in place of that of the hub."""
    freedom = hub.freedom if freedom is None else freedom
    turns = np.flatnonzero(freedom[3:])
    first, second = np.triu_indices(len(turns))
    crosses = np.array([cross_matrix(axis) for axis in np.eye(3)])
    spin, product = crosses[turns], crosses[turns[first]] @ crosses[turns[second]]
    square = 0.5 * (product + product.transpose(0, 2, 1))
    turning, follow = c.turning.reshape(3, 3, size, size), c.turning_derivatives.reshape(3, 3, -1, size)
    load = np.concatenate([c.load, c.load_stress], axis=1)
    reach = np.concatenate([load[9:], crosses.reshape(3, 9) @ load[:9]])
    pull = square.reshape(-1, 9) @ load[:9]
    # Monomials last: there are many, and the kernels' inner loops run along them.
    spin_follow, square_follow = (
        np.ascontiguousarray(np.einsum("nab,abmr->nrm", weights, follow)) for weights in (spin, square)
    )
    scale = _ROUND_OFF * float(np.abs(follow).max(initial=0.0))
    for each in (spin_follow, square_follow):
        each[np.abs(each) <= scale] = 0.0
    weight, center = hub.mass, np.asarray(hub.center, dtype=float)
    offset = hub.offset_inertia
    second_moment = inertia.second_moment
    return HubArrays(
        freedom,
        turns,
        first,
        second,
        np.ascontiguousarray(reach[:, :size]),
        np.ascontiguousarray(reach[:, size:]),
        np.einsum("nab,abij->nij", spin, turning),
        spin_follow,
        np.ascontiguousarray(pull[:, :size]),
        np.ascontiguousarray(pull[:, size:]),
        np.einsum("nab,abij->nij", square, turning),
        square_follow,
        spin_follow.any(axis=(1, 2)).astype(float),
        square_follow.any(axis=(1, 2)).astype(float),
        inertia.mass + weight,
        inertia.mass_moment + weight * center,
        hub.tensor + offset + np.trace(second_moment) * np.eye(3) - second_moment,
    )


def inputs_from(inputs: HubInputs, first: int) -> HubInputs:
    """The inputs from one instant on; those that hold for all stay."""
    return HubInputs(*(part if len(part) == 1 else part[first:] for part in inputs))
