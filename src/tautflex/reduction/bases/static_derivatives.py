"""Static modal derivatives: the in-plane fields that a deflection calls for [Idelsohn & Cardona 1985].

Stretching a film in its plane is far stiffer than moving it sideways, so these fields are in equilibrium at every
instant. Those that are not much faster than the kept motion, such as the bending of the frame in its plane, become
unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tautflex.numeric import Array, cross_matrix
from tautflex.reduction.bases.vectors import BasisVectors, ReferenceSolver, ritz
from tautflex.reduction.polynomial.monomials import pairs
from tautflex.reduction.polynomial.strains import quadratic_forces
from tautflex.solvers.modal.rigid import RIGID_DIRECTIONS
from tautflex.solvers.static.prestress import PrestressedState

TREATMENTS = ("condensed", "unknowns", "none")
# Fields below this part of the largest strain energy are round-off.
_NEGLIGIBLE = 1e-12
# Coordinates below this part of the largest do not set the pace of the derivatives.
_NOTABLE = 0.05
# A derivative is in equilibrium at every instant if its frequency is this many times the fastest forcing.
_FAST = 2.0


def add_static_derivatives(
    state: PrestressedState,
    solver: ReferenceSolver,
    kept: Array,
    amplitude: Array,
    directions: Sequence[str],
    mode: str,
    text: str,
) -> BasisVectors:
    """Static modal derivatives of the kept vectors, split into slow ones (unknowns) and fast ones (condensed).

    ``kept`` and ``amplitude``, which weighs what the derivatives are worth, are as in `BasisVectors`, ``mode`` is one
    of `TREATMENTS`, ``directions`` have the rigid accelerations whose spin pulls on the derivatives.
    """
    nothing = np.zeros((0, state.system.size))
    if mode == "none":
        return BasisVectors(kept, nothing, amplitude, f"{text}, no static derivatives")
    first, second = pairs(len(kept))
    sizes = np.maximum(amplitude, 1e-2 * amplitude.max())
    forces = quadratic_forces(state.system, kept) * (sizes[first] * sizes[second])[:, None]
    fields = np.array([-solver.solve(force) for force in forces])
    # Responses to the centrifugal loads of unit angular velocities carry the stiffening by spin.
    inertia = state.system.inertia
    spins = [cross_matrix(np.eye(3)[RIGID_DIRECTIONS.index(name) - 3]) for name in directions if name.startswith("r")]
    loads = [load for spin in spins if np.any(load := inertia.load(spin @ spin))]
    offset = np.array([solver.solve(load) for load in loads]).reshape(-1, state.system.size)
    offset = offset * np.sqrt(solver.energies(fields).max() / solver.energies(offset))[:, None]
    fields = np.concatenate([fields, offset])
    # Orthogonal to the kept vectors in the energy, so that both do not compete.
    fields = fields - (fields @ solver.multiply(kept).T / solver.energies(kept)) @ kept
    limit = fast_frequency(solver.energies(kept), amplitude)
    span, inverse = moving_among(state, solver, fields)
    if not len(span):
        return BasisVectors(kept, nothing, amplitude, f"{text}, no static derivatives", limit)
    slow = inverse * limit**2 > 1.0 if mode == "condensed" else np.ones(len(span), dtype=bool)
    joined, fast, moving = ritz(state, np.concatenate([kept, span[slow]])), span[~slow], int(slow.sum())
    text = f"{text}, {moving} moving and {len(fast)} condensed static derivatives"
    # What a coordinate is worth, from the kept vectors and from the fields that they call for.
    parts = np.concatenate([kept * amplitude[:, None], fields]) @ (inertia.mass_matrix @ joined.T)
    worth = np.sqrt(np.sum(parts**2, axis=0))
    return BasisVectors(joined, fast, worth, text, limit)


def fast_frequency(squares: Array, amplitude: Array) -> float:
    """Frequency from which on a companion is in equilibrium at every instant [rad/s].

    ``squares`` of the frequencies of the kept vectors, which force it at up to twice their own.
    """
    return _FAST * 2.0 * float(np.sqrt(squares[amplitude > _NOTABLE * amplitude.max()].max()))


def moving_among(state: PrestressedState, solver: ReferenceSolver, fields: Array) -> tuple[Array, Array]:
    """Natural motions of the span of fields (n, size), of unit stiffness, and inverse squares of their frequencies."""
    gram = fields @ solver.multiply(fields).T
    values, turn = np.linalg.eigh(0.5 * (gram + gram.T))
    keep = values > _NEGLIGIBLE * max(values.max(initial=0.0), 0.0)
    span = (turn[:, keep] / np.sqrt(values[keep])).T @ fields
    inverse, turn = np.linalg.eigh(span @ (state.system.inertia.mass_matrix @ span.T))
    return turn.T @ span, inverse
