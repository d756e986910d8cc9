r"""Equation of motion of a reduced model: affine parts weighed, static derivatives condensed [theory.md 10].

With ``K_pa eta + H y`` the force that coordinates put on the static derivatives p,

    p = D eta + E y,   D = -K_pp^-1 K_pa,   E = -K_pp^-1 H,

and the energy stays a polynomial of degree four in eta; terms of higher degree, which p would bring through its own
stretching, are left out (they are of sixth order, because p is of second). Arrays may be numpy's or JAX's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from tautflex.numeric import Array, cross_matrix
from tautflex.reduction.polynomial.monomials import pair_table, pairs
from tautflex.reduction.polynomial.projection import Moments, Projection


@dataclass(frozen=True)
class Factors:
    """Parameters relative to the state that was reduced; 1 is that state.

    Parameters
    ----------
    tension_x, tension_y
        Prestress along x and y.
    youngs_modulus, density
        Kind of element (``"membrane"``, ``"cable"``, ``"beam"``) -> factor; missing kinds keep theirs.
    """

    tension_x: Any = 1.0
    tension_y: Any = 1.0
    youngs_modulus: Mapping[str, Any] = field(default_factory=dict)
    density: Mapping[str, Any] = field(default_factory=dict)


class CondensedModel(NamedTuple):
    """Equation of motion of the coordinates, static derivatives condensed, for k weights Z and l loads of the frame.

    For any motion (`FrameMoments.general`) these are the nine entries of Z, and of the load moments
    ``int rho V' x``, ``int rho V'`` the nine and three entries.

    Parameters
    ----------
    mass, linear
        Shape (r, r).
    quadratic
        Second-degree force per monomial, shape (r, m).
    cubic
        Fourth-degree coefficients, shape (m, m): energy ``y cubic y / 8``.
    viscous
        ``H' K_pp^-1 H``, shape (m, m): per unit of stiffness damping, ``s += viscous dy/dt``.
    turning
        ``M(Z)`` of the coordinates, shape (k, r, r).
    turning_derivatives
        The same between static derivatives (per monomial) and coordinates, shape (k, m, r).
    load, load_stress
        Loads on the coordinates, and those on static derivatives as seen by the monomials, shapes (l, r) and (l, m).
    follow_linear, follow_quadratic, follow_load
        Static derivatives from coordinates (p, r), monomials (p, m) and loads (l, p).
    """

    mass: Any
    linear: Any
    quadratic: Any
    cubic: Any
    viscous: Any
    turning: Any
    turning_derivatives: Any
    load: Any
    load_stress: Any
    follow_linear: Any
    follow_quadratic: Any
    follow_load: Any


@dataclass(frozen=True)
class FrameMoments:
    """Inertia of one kind of element for chosen weights and loads of the frame, proportional to its density.

    Parameters
    ----------
    pair
        ``M(1)``, then ``M(Z)`` of each weight on all P vectors, shape (1 + k, P, P).
    load
        Shape (l, P).
    """

    pair: Array
    load: Array

    @classmethod
    def general(cls, moments: Moments) -> FrameMoments:
        """For any motion: Z and the loads ``int rho V' x``, ``int rho V'`` entry by entry, k = 9, l = 12."""
        rows = moments.pair.reshape(9, *moments.pair.shape[2:])
        return cls(np.stack([moments.mass, *rows]), np.concatenate([*moments.first, moments.zeroth]))

    @classmethod
    def about_axis(cls, moments: Moments, axis: Array, origin: Array) -> FrameMoments:
        """For rotation about one line: ``Z = S, S^2`` of the axis, loads of angular acceleration and squared rate."""
        spin = cross_matrix(axis)
        weights = (spin, spin @ spin)
        pairs = [moments.mass, *(np.einsum("ab,abpq->pq", w, moments.pair) for w in weights)]
        # The frame's origin is at -origin from the line.
        loads = [np.einsum("ab,abp->p", w, moments.first) - (w @ origin) @ moments.zeroth for w in weights]
        return cls(np.stack(pairs), np.stack(loads))


def condense(
    projection: Projection, inertia: Mapping[str, FrameMoments], factors: Factors, xp: ModuleType
) -> CondensedModel:
    """Weigh the parts with parameters, which may be traced, and condense the static derivatives.

    ``inertia`` has moments by kind of element, for the weights and loads that are wanted; ``xp`` is numpy, or a library
    with its interface such as jax.numpy.
    """
    young = {kind: factors.youngs_modulus.get(kind, 1.0) for kind in projection.elastic}
    tension = {
        "x": factors.tension_x,
        "y": factors.tension_y,
        "xy": xp.sqrt(factors.tension_x * factors.tension_y) if "xy" in projection.stress else 0.0,
    }
    stiffness: Any = sum(young[kind] * part for kind, part in projection.elastic.items())
    stiffness = stiffness + sum(tension[name] * part for name, part in projection.stress.items())
    force: Any = sum(young[kind] * part.quadratic for kind, part in projection.higher.items())
    cubic: Any = sum(young[kind] * part.cubic for kind, part in projection.higher.items())
    r = projection.kept
    density = {kind: factors.density.get(kind, 1.0) for kind in inertia}
    pair: Any = sum(density[kind] * part.pair for kind, part in inertia.items())
    load: Any = sum(density[kind] * part.load for kind, part in inertia.items())
    k_pa, k_pp, h = stiffness[r:, :r], stiffness[r:, r:], force[r:]
    # One solution for everything that follows.
    follow = -xp.linalg.solve(k_pp, xp.concatenate([k_pa, h, load[:, r:].T], axis=1))
    loads = follow.shape[1] - len(load)
    d, e, offset = follow[:, :r], follow[:, r:loads], follow[:, loads:].T
    # Coordinates move the static derivatives along: V' = kept + D' derivatives.
    reach = xp.concatenate([xp.eye(r), d])
    moved = pair @ reach
    own = reach.T @ moved
    condensed = h.T @ e
    return CondensedModel(
        mass=even(own[0]),
        linear=even(stiffness[:r, :r] + k_pa.T @ d),
        quadratic=force[:r] + mixed_quadratic(k_pa.T @ e, r, xp),
        cubic=even(cubic + 4.0 * condensed),
        viscous=even(-condensed),
        turning=own[1:],
        turning_derivatives=e.T @ moved[1:, r:],
        load=load @ reach,
        load_stress=load[:, r:] @ e,
        follow_linear=d,
        follow_quadratic=e,
        follow_load=offset,
    )


class KindParts(NamedTuple):
    """What one kind of element adds per unit of its damping factors.

    Parameters
    ----------
    mass, stiffness
        Its mass and material stiffness on the coordinates, shape (r, r).
    viscous
        Its material stiffness on the static derivatives, per monomial, shape (m, m).
    between
        The same between coordinates and monomials, shape (r, m): 0 for a flat reference.
    """

    mass: Any
    stiffness: Any
    viscous: Any
    between: Any


def parts_by_kind(projection: Projection, c: CondensedModel, factors: Factors, xp: ModuleType) -> dict[str, KindParts]:
    """Parts of a damping by kind of element for the condensed model of the same parameters."""
    r, e = projection.kept, c.follow_quadratic
    reach, parts = xp.concatenate([xp.eye(r), c.follow_linear]), {}
    for kind, elastic in projection.elastic.items():
        stiffness = factors.youngs_modulus.get(kind, 1.0) * elastic
        mass = factors.density.get(kind, 1.0) * projection.inertia[kind].mass
        moved = reach.T @ stiffness
        parts[kind] = KindParts(
            even(reach.T @ mass @ reach), even(moved @ reach), even(e.T @ stiffness[r:, r:] @ e), moved[:, r:] @ e
        )
    return parts


def assemble(
    projection: Projection, factors: Factors | None = None, loads: Mapping[str, float] | None = None
) -> CondensedModel:
    """Equation of motion for any motion of the frame; without factors that of the state that was reduced.

    ``loads`` are factors of the loads of each kind of element.
    """
    moments = weigh_loads({kind: FrameMoments.general(part) for kind, part in projection.inertia.items()}, loads)
    return condense(projection, moments, factors or Factors(), np)


def weigh_loads(moments: dict[str, FrameMoments], factors: Mapping[str, float] | None) -> dict[str, FrameMoments]:
    """Moments whose loads have the factor of their kind of element; None are none."""
    if factors is None:
        return moments
    return {kind: replace(part, load=factors[kind] * part.load) for kind, part in moments.items()}


def even(matrix: Any) -> Any:
    """Symmetric part."""
    return 0.5 * (matrix + matrix.T)


def mixed_quadratic(table: Any, count: int, xp: ModuleType) -> Any:
    """Force of the energy ``eta_i table[i, k] y_k``: per monomial, shape (r, m)."""
    first, second = pairs(count)
    half = xp.where(xp.asarray(first == second), 1.0, 0.5)
    # The force of sum t[i, j, k] eta_i eta_j eta_k, t symmetric in (j, k), is t[a, j, k] + 2 t[j, a, k].
    tensor = (table * half)[:, pair_table(count)]
    force = tensor + 2.0 * xp.swapaxes(tensor, 0, 1)
    both = force + xp.swapaxes(force, 1, 2)
    return both[:, first, second] * (0.5 / half)
