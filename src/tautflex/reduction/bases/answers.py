r"""Static answers to inputs: what the structure does at once when one acts, beside what the basis can do.

A force F calls for ``K^-1 F``, a stress s for ``-K^-1 b``, ``b = G' V L' s``, each less its part in the kept vectors
[theory.md 10]. An answer that is not much faster than the kept motion becomes a coordinate, by the rule that static
modal derivatives follow.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tautflex.numeric import Array
from tautflex.reduction.bases.static_derivatives import fast_frequency, moving_among
from tautflex.reduction.bases.vectors import BasisVectors, ReferenceSolver, ritz
from tautflex.solvers.static.prestress import PrestressedState

# Answers that keep less than this part of their strain energy beside the basis are in it.
_INSIDE = 1e-12
# So many stresses have coordinates of their own at most.
_FEW = 8


def static_answers(solver: ReferenceSolver, basis: BasisVectors, loads: Array) -> Array:
    """Answers to loads (n, size), stiffness-orthogonal to the kept vectors, zero where these hold them, (n, size)."""
    whole = np.array([solver.solve(load) for load in loads]).reshape(-1, loads.shape[-1])
    beside = whole - (whole @ solver.multiply(basis.kept).T / solver.energies(basis.kept)) @ basis.kept
    beside[solver.energies(beside) <= _INSIDE * solver.energies(whole)] = 0.0
    return np.asarray(beside)


def apart(state: PrestressedState, solver: ReferenceSolver, answers: Array) -> tuple[Array, Array]:
    """Natural motions among answers (n, size), of unit stiffness, and their frequencies [rad/s]."""
    energies = solver.energies(answers)
    some = energies > 0.0
    motions, inverse = moving_among(state, solver, answers[some] / np.sqrt(energies[some])[:, None])
    return motions, 1.0 / np.sqrt(inverse)


def fast_limit(solver: ReferenceSolver, basis: BasisVectors) -> float:
    """Frequency from which on what is not kept answers at once [rad/s]."""
    return basis.fast or fast_frequency(solver.energies(basis.kept), basis.amplitude)


def with_answers(state: PrestressedState, basis: BasisVectors, pushes: Array, pulls: Array) -> BasisVectors:
    """Basis whose coordinates include what answers inputs too slowly to follow at once.

    ``pushes`` are forces (n, size), ``pulls`` those of stresses (n_s, size). A stress and that of its answer cancel in
    part, up to a hundred times what is left, so that a small delay of the answer counts: a few of them become
    coordinates however fast they are. Each has two, ``psi = K^-1 b`` and ``K^-1 M psi`` (load-dependent Ritz vectors
    [Wilson, Yuan & Dickens 1982, Earthq. Eng. Struct. Dyn. 10]): the frame bends slowly where the film gives way fast,
    and one coordinate for both would let the film wait for the frame.
    """
    solver, mass = ReferenceSolver(state), state.system.inertia.mass_matrix
    limit = fast_limit(solver, basis)
    few = pulls if len(pulls) <= _FEW else pulls[:0]
    first = static_answers(solver, basis, few)
    second = static_answers(solver, basis, (mass @ first.T).T)
    known, _ = apart(state, solver, np.concatenate([first, second]))
    others = static_answers(solver, basis, np.concatenate([pushes, pulls[len(few) :]]))
    motions, pace = apart(state, solver, others - others @ solver.multiply(known).T @ known)
    slow = np.concatenate([known, motions[pace < limit]])
    if not len(slow):
        return replace(basis, fast=limit)
    kept = ritz(state, np.concatenate([basis.kept, slow]))
    # An answer is worth as much energy as the coordinate with most of it.
    worth = float(np.sqrt((solver.energies(basis.kept) * basis.amplitude**2).max()))
    parts = np.concatenate([basis.kept * basis.amplitude[:, None], worth * slow]) @ (mass @ kept.T)
    derivatives = basis.derivatives - basis.derivatives @ solver.multiply(slow).T @ slow
    text = f"{basis.description}, {len(slow)} answers to inputs"
    return BasisVectors(kept, derivatives, np.sqrt(np.sum(parts**2, axis=0)), text, limit)
