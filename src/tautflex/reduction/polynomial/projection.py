r"""A structure projected on a basis, in affine parts that parameters weigh [theory.md 10].

On ``q = kept eta + derivatives p`` everything is linear in the tensions, in Young's modulus of each kind of element and
in its density, so the parts are computed once; `condense` weighs them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tautflex.mechanics.inertia import InertiaOperator
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.reduction.bases.vectors import BasisVectors
from tautflex.reduction.polynomial.strains import HigherDegrees, higher_degrees
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.static.tensioning import respond


@dataclass(frozen=True)
class Moments:
    """Inertia of one kind of element on all P vectors.

    Parameters
    ----------
    mass
        ``V' M V``, shape (P, P).
    pair
        ``int rho V_a' V_b``, with the second order of what turns, shape (3, 3, P, P).
    first
        ``int rho V_a' x_b``, shape (3, 3, P).
    zeroth
        ``int rho V_a'``, shape (3, P).
    """

    mass: Array
    pair: Array
    first: Array
    zeroth: Array


@dataclass(frozen=True)
class Projection:
    """Affine parts that parameters weigh. P = r + p vectors: kept ones first, then static derivatives; m monomials.

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


def project(state: PrestressedState, basis: BasisVectors) -> Projection:
    """Project a prestressed state, whose laws must all be elastic, on a basis."""
    system, vectors = state.system, np.concatenate([basis.kept, basis.derivatives])
    higher = higher_degrees(system, basis.kept, vectors)
    none = [np.zeros_like(stress) for stress in system.initial_stress]
    elastic = {kind: _stiffness(system, vectors, none, kind) for kind in system.kinds}
    stress = {
        name: _stiffness(system, vectors, field)
        for name, field in prestress_fields(state).items()
        if any(np.any(part) for part in field)
    }
    inertia = {kind: project_moments(system.inertia_of(kind), vectors) for kind in system.kinds}
    return Projection(len(basis.kept), elastic, higher, stress, inertia)


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


def _stiffness(system: StructuralSystem, vectors: Array, stress: list[Array], elastic: str | None = None) -> Array:
    """Stiffness of a prestress field, and of the elastic matrices of one kind of element, on vectors, shape (P, P)."""
    blocks = tuple(
        block if block.kind == elastic else replace(block, elasticity=np.zeros_like(block.elasticity))
        for block in system.blocks
    )
    part = system.with_initial_stress(stress, blocks)
    matrix = part.pattern.symmetric_matrix(part.tangent(np.zeros(system.size)))
    result = vectors @ (matrix @ vectors.T)
    return 0.5 * (result + result.T)


def project_moments(inertia: InertiaOperator, vectors: Array) -> Moments:
    """Moments of an inertia operator on vectors (P, size)."""
    pair = np.zeros((3, 3, len(vectors), len(vectors)))
    for a, b in np.ndindex(3, 3):
        if len(inertia.values[a][b]):
            pair[a, b] = vectors @ (inertia.matrix(np.outer(np.eye(3)[a], np.eye(3)[b])) @ vectors.T)
    mass = np.einsum("aapq->pq", pair)
    if inertia.moving is not None:
        mass = vectors @ (inertia.mass_matrix @ vectors.T)
    return Moments(mass, pair, inertia.first_moment @ vectors.T, inertia.zeroth_moment @ vectors.T)
