r"""A structure projected on a basis, in pieces that parameters weigh [theory.md 10].

On ``q = kept eta + companions p`` everything is linear in the tensions, in Young's modulus of each kind of element and
in its density, so the pieces are computed once. `assemble` weighs them and condenses the companions: with
``K_pa eta + H y`` the force that coordinates put on them,

    p = D eta + E y,   D = -K_pp^-1 K_pa,   E = -K_pp^-1 H,

and the energy stays a polynomial of degree four in eta; terms of higher degree, which p would bring through its own
stretching, are left out (they are of sixth order, because p is of second).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.mechanics.inertia import InertiaOperator
from tautflex.mechanics.system import StructuralSystem
from tautflex.reduction.bases.basis import BasisVectors
from tautflex.reduction.polynomial.monomials import pairs
from tautflex.reduction.polynomial.strains import HigherDegrees, higher_degrees
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.static.tensioning import respond

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Moments:
    """Inertia of one kind of element on all P vectors.

    Parameters
    ----------
    pair
        ``int rho V_a' V_b``, shape (3, 3, P, P).
    first
        ``int rho V_a' x_b``, shape (3, 3, P).
    zeroth
        ``int rho V_a'``, shape (3, P).
    """

    pair: Array
    first: Array
    zeroth: Array


@dataclass(frozen=True)
class Pieces:
    """Everything that parameters weigh. P = r + p vectors: kept ones first, then companions; m monomials.

    Parameters
    ----------
    kept
        Number r of coordinates.
    elastic
        Kind of element -> stiffness (P, P), proportional to Young's modulus of that kind.
    higher
        Kind of element -> forces of second degree (P, m) and third (m, m), likewise.
    stress
        Stiffness (P, P) of the prestress fields ``"x"``, ``"y"`` (proportional to the tension along x and y) and
        ``"xy"`` (to the root of their product).
    inertia
        Kind of element -> moments, proportional to its density.
    """

    kept: int
    elastic: dict[str, Array]
    higher: dict[str, HigherDegrees]
    stress: dict[str, Array]
    inertia: dict[str, Moments]


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


@dataclass(frozen=True)
class Coefficients:
    """Equation of motion of the coordinates, companions condensed.

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
        ``M(Z)`` of the coordinates by (row, column) of Z, shape (3, 3, r, r).
    turning_companions
        The same between companions (per monomial) and coordinates, shape (3, 3, m, r).
    first, zeroth
        Load moments, shapes (3, 3, r), (3, r).
    first_stress, zeroth_stress
        The loads on companions as seen by the monomials, shapes (3, 3, m), (3, m).
    follow_linear, follow_quadratic, follow_first, follow_zeroth
        Companions from coordinates (p, r), monomials (p, m) and loads (3, 3, p), (3, p).
    """

    mass: Array
    linear: Array
    quadratic: Array
    cubic: Array
    viscous: Array
    turning: Array
    turning_companions: Array
    first: Array
    zeroth: Array
    first_stress: Array
    zeroth_stress: Array
    follow_linear: Array
    follow_quadratic: Array
    follow_first: Array
    follow_zeroth: Array


def project(state: PrestressedState, basis: BasisVectors) -> Pieces:
    """Project a prestressed state on a basis.

    Parameters
    ----------
    state
        Prestressed state; all its laws must be elastic.
    basis
        Vectors.
    """
    system, vectors = state.system, np.concatenate([basis.kept, basis.companions])
    higher = higher_degrees(system, basis.kept, vectors)
    elastic = {kind: _projected(_only_elastic(system, kind), vectors) for kind in higher}
    stress = {
        name: _projected(_only_stress(system, field), vectors)
        for name, field in prestress_fields(state).items()
        if any(np.any(part) for part in field)
    }
    inertia = {kind: project_moments(system.inertia_of(kind), vectors) for kind in higher}
    return Pieces(len(basis.kept), elastic, higher, stress, inertia)


def prestress_fields(state: PrestressedState) -> dict[str, list[Array]]:
    """Initial stresses as fields proportional to the tension along x, along y, and to the root of their product.

    The response to tension is linear, so the fields of unit tension along one direction add up; what is left (a given
    shear) goes with the root, as in `Model.with_pretension_scaled`.
    """
    nominal = state.system.initial_stress
    fields = {}
    for name, scales in (("x", (1.0, 0.0)), ("y", (0.0, 1.0))):
        given = StructuralSystem.from_model(state.model.with_pretension_scaled(*scales))
        given = given if state.model.prestress_mode == "uniform" else respond(given)
        fields[name] = list(given.initial_stress)
    rest = [total - a - b for total, a, b in zip(nominal, fields["x"], fields["y"], strict=True)]
    largest = [float(np.abs(total).max(initial=0.0)) for total in nominal]
    fields["xy"] = [np.where(np.abs(part) > 1e-9 * top, part, 0.0) for part, top in zip(rest, largest, strict=True)]
    return fields


def _only_elastic(system: StructuralSystem, kind: str) -> StructuralSystem:
    """Elastic stiffness of one kind, without prestress."""
    blocks = tuple(
        block if block.kind == kind else replace(block, elasticity=np.zeros_like(block.elasticity))
        for block in system.blocks
    )
    return system.with_initial_stress([np.zeros_like(stress) for stress in system.initial_stress], blocks)


def _only_stress(system: StructuralSystem, field: list[Array]) -> StructuralSystem:
    """Stiffness of a prestress field alone."""
    blocks = tuple(replace(block, elasticity=np.zeros_like(block.elasticity)) for block in system.blocks)
    return system.with_initial_stress(field, blocks)


def _projected(system: StructuralSystem, vectors: Array) -> Array:
    matrix = system.pattern.symmetric_matrix(system.tangent(np.zeros(system.size)))
    result = vectors @ (matrix @ vectors.T)
    return 0.5 * (result + result.T)


def project_moments(inertia: InertiaOperator, vectors: Array) -> Moments:
    """Moments of an inertia operator on vectors (P, size)."""
    pair = np.zeros((3, 3, len(vectors), len(vectors)))
    unit = np.eye(3)
    for a in range(3):
        for b in range(3):
            if len(inertia.values[a][b]):
                pair[a, b] = vectors @ (inertia.matrix(np.outer(unit[a], unit[b])) @ vectors.T)
    return Moments(pair, inertia.first_moment @ vectors.T, inertia.zeroth_moment @ vectors.T)


def weigh(pieces: Pieces, factors: Factors, xp: ModuleType) -> tuple[Any, Any, Any]:
    """Stiffness, second-degree force and fourth-degree coefficients of coordinates and companions under parameters.

    Parameters
    ----------
    pieces
        Projected structure.
    factors
        Parameters, possibly traced.
    xp
        Array library: numpy, or one with its interface such as jax.numpy.

    Returns
    -------
    tuple
        Shapes (r + p, r + p), (r + p, m) and (m, m).
    """
    young = {kind: factors.youngs_modulus.get(kind, 1.0) for kind in pieces.elastic}
    tension = {
        "x": factors.tension_x,
        "y": factors.tension_y,
        "xy": xp.sqrt(factors.tension_x * factors.tension_y) if "xy" in pieces.stress else 0.0,
    }
    stiffness = sum(young[kind] * part for kind, part in pieces.elastic.items())
    stiffness = stiffness + sum(tension[name] * part for name, part in pieces.stress.items())
    force = sum(young[kind] * part.quadratic for kind, part in pieces.higher.items())
    cubic = sum(young[kind] * part.cubic for kind, part in pieces.higher.items())
    return stiffness, force, cubic


def assemble(pieces: Pieces, factors: Factors | None = None) -> Coefficients:
    """Weigh the pieces with parameters and condense the companions.

    Parameters
    ----------
    pieces
        Projected structure.
    factors
        Parameters; None is the state that was reduced.

    Returns
    -------
    Coefficients
    """
    factors = factors or Factors()
    r = pieces.kept
    stiffness, force, cubic = weigh(pieces, factors, np)
    density = {kind: factors.density.get(kind, 1.0) for kind in pieces.inertia}
    pair, first, zeroth = (
        sum(density[kind] * getattr(part, name) for kind, part in pieces.inertia.items())
        for name in ("pair", "first", "zeroth")
    )
    k_pa, k_pp, h = stiffness[r:, :r], stiffness[r:, r:], force[r:]
    # One solution for everything the companions follow.
    p = k_pp.shape[0]
    loads = np.concatenate([first[..., r:].reshape(9, p), zeroth[..., r:]])
    follow = -np.linalg.solve(k_pp, np.concatenate([k_pa, h, loads.T], axis=1))
    d, e, pulled = follow[:, :r], follow[:, r : r + h.shape[1]], follow[:, r + h.shape[1] :].T
    # Coordinates move the companions along: V' = kept + D' companions.
    reach = np.concatenate([np.eye(r), d])
    return Coefficients(
        mass=_even(np.einsum("aapq,pi,qj->ij", pair, reach, reach)),
        linear=_even(stiffness[:r, :r] + k_pa.T @ d),
        quadratic=force[:r] + mixed_quadratic(k_pa.T @ e, r, np),
        cubic=_even(cubic + 4.0 * h.T @ e),
        viscous=_even(-h.T @ e),
        turning=np.einsum("abpq,pi,qj->abij", pair, reach, reach),
        turning_companions=np.einsum("pm,abpq,qj->abmj", e, pair[..., r:, :], reach),
        first=first @ reach,
        zeroth=zeroth @ reach,
        first_stress=first[..., r:] @ e,
        zeroth_stress=zeroth[..., r:] @ e,
        follow_linear=d,
        follow_quadratic=e,
        follow_first=pulled[:9].reshape(3, 3, p),
        follow_zeroth=pulled[9:],
    )


def _even(matrix: Any) -> Any:
    return 0.5 * (matrix + matrix.T)


def mixed_quadratic(table: Any, count: int, xp: ModuleType) -> Any:
    """Force of the energy ``eta_i table[i, k] y_k``: per monomial, shape (r, m)."""
    first, second = pairs(count)
    half = xp.where(xp.asarray(first == second), 1.0, 0.5)
    # The force of sum t[i, j, k] eta_i eta_j eta_k, t symmetric in (j, k), is t[a, j, k] + 2 t[j, a, k].
    place = np.zeros((count, count), dtype=np.int64)
    place[first, second] = place[second, first] = np.arange(len(first))
    tensor = (table * half)[:, place]
    force = tensor + 2.0 * xp.swapaxes(tensor, 0, 1)
    both = force + xp.swapaxes(force, 1, 2)
    return both[:, first, second] * (0.5 / half)
