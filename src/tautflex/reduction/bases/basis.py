r"""Bases of reduced models: what the structure may do, as vectors [theory.md 10].

A basis has two parts. *Kept* vectors carry the unknowns ``eta``. *Companions* are displacements that follow at once,
``p = E y(eta)``: stretching a film in its plane is far stiffer than moving it sideways, so the in-plane fields that
a deflection calls for (static modal derivatives [Idelsohn & Cardona 1985]) are in equilibrium at every instant. Those
that are not much faster than the kept motion, such as the bending of the frame in its plane, become unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.inertia import InertiaOperator, cross_matrix
from tautflex.reduction.bases.snapshots import full_snapshots, transverse_unknowns
from tautflex.reduction.polynomial.monomials import pairs
from tautflex.reduction.polynomial.strains import quadratic_forces
from tautflex.solvers.linear.factorization import SymmetricFactorization
from tautflex.solvers.modal.natural import RIGID_DIRECTIONS, solve_modes
from tautflex.solvers.static.prestress import PrestressedState

Array = NDArray[np.float64]

COMPANIONS = ("condensed", "unknowns", "none")
# Companion fields below this part of the largest strain energy are round-off.
_NEGLIGIBLE = 1e-12
# Coordinates below this part of the largest do not set the pace of the companions.
_NOTABLE = 0.05
# A companion is in equilibrium at every instant if its frequency is this many times the fastest forcing.
_FAST = 2.0


@dataclass(frozen=True)
class BasisVectors:
    """Vectors of a reduced model, as free unknowns of the structure.

    Parameters
    ----------
    kept
        Mass-normalised Ritz vectors, shape (r, size).
    companions
        Statically condensed vectors, stiffness-orthogonal to the kept ones, shape (p, size).
    amplitude
        Typical size of each coordinate, shape (r,): it weighs what may be left out.
    description
        One line for reports.
    """

    kept: Array
    companions: Array
    amplitude: Array
    description: str


@runtime_checkable
class Basis(Protocol):
    """Anything that finds the vectors of a reduced model."""

    def vectors(self, state: PrestressedState) -> BasisVectors:
        """Find the vectors for a prestressed state."""
        ...


@dataclass(frozen=True)
class ModalBasis:
    """Natural modes chosen by their participation in the load, static correction, and in-plane companions.

    Parameters
    ----------
    directions
        Rigid accelerations that load the structure, of ``"x", "y", "z", "rx", "ry", "rz"``. The paper's antenna turns
        about x: ``("rx",)``. Fewer directions make a smaller model.
    count
        Number of modes; None takes every mode with a part of at least ``threshold`` in a load's static strain energy.
    threshold
        Smallest part that counts.
    candidates
        Number of lowest modes among which is chosen.
    static_correction
        Add, for each direction, the static response that the chosen modes leave out.
    companions
        ``"condensed"``: in-plane fields follow at once; ``"unknowns"``: they move, with mass; ``"none"``: left out,
        which makes the film far too stiff.

    Raises
    ------
    InputError
        If an argument is out of range.
    """

    directions: Sequence[str] = ("z", "rx", "ry")
    count: int | None = None
    threshold: float = 5e-4
    candidates: int = 60
    static_correction: bool = True
    companions: str = "condensed"

    def __post_init__(self) -> None:
        if not self.directions:
            raise InputError("directions: expected at least one of 'x', 'y', 'z', 'rx', 'ry', 'rz', got none")
        for direction in self.directions:
            checks.one_of("directions", direction, RIGID_DIRECTIONS)
        if self.count is not None:
            checks.whole("count", self.count, 1)
        checks.between("threshold", self.threshold, 0.0, 1.0)
        checks.whole("candidates", self.candidates, 1)
        checks.one_of("companions", self.companions, COMPANIONS)

    def vectors(self, state: PrestressedState) -> BasisVectors:
        """Find the vectors for a prestressed state."""
        solver = ReferenceSolver(state)
        inertia = state.system.inertia
        loads = np.array([rigid_load(inertia, direction) for direction in self.directions])
        static = np.array([solver.solve(load) for load in loads])
        modes = solve_modes(state, n=min(self.candidates, state.system.size - 1))
        values = (2.0 * np.pi * modes.frequencies) ** 2
        participation = (modes.vectors @ loads.T).T
        shares = participation**2 / values / np.einsum("di,di->d", loads, static)[:, None]
        chosen = self._choose(shares)
        kept = modes.vectors[chosen]
        if self.static_correction:
            kept = np.concatenate([kept, static])
        kept = ritz(state, kept)
        amplitude = np.abs(loads @ kept.T).max(axis=0) / solver.energies(kept)
        return add_companions(
            state, solver, kept, amplitude, self.directions, self.companions, f"{len(chosen)} natural modes"
        )

    def _choose(self, shares: Array) -> NDArray[np.int64]:
        """Modes in order of frequency; ``shares`` (direction, mode) are parts of the static strain energy."""
        best = shares.max(axis=0)
        order = np.argsort(-best, kind="stable")
        wanted = self.count if self.count is not None else max(1, int(np.sum(best >= self.threshold)))
        return np.sort(order[:wanted])


@dataclass(frozen=True)
class PodBasis:
    """Proper orthogonal modes of a training run, in the inner product of the mass matrix, and in-plane companions.

    Parameters
    ----------
    data
        Result of a full run (``run.data``) with stored fields, ``simulate(..., fields="all", every=...)``.
    count
        Number of modes; None takes as many as hold all but ``lost`` of the kinetic-energy norm.
    lost
        Part of the snapshots' norm that may be left out.
    companions
        As in `ModalBasis`.

    Raises
    ------
    InputError
        If an argument is out of range or the run has no fields.
    """

    data: xr.Dataset
    count: int | None = None
    lost: float = 1e-5
    companions: str = "condensed"

    def __post_init__(self) -> None:
        if self.count is not None:
            checks.whole("count", self.count, 1)
        checks.between("lost", self.lost, 0.0, 1.0)
        checks.one_of("companions", self.companions, COMPANIONS)

    def vectors(self, state: PrestressedState) -> BasisVectors:
        """Find the vectors for a prestressed state."""
        snapshots = full_snapshots(state, self.data) * transverse_unknowns(state)
        mass = state.system.inertia.mass_matrix
        # Method of snapshots: eigenvectors of the Gram matrix, which is as small as the number of snapshots.
        values, weights = np.linalg.eigh(snapshots @ (mass @ snapshots.T))
        values, weights = values[::-1], weights[:, ::-1]
        left = 1.0 - np.cumsum(values) / values.sum()
        most = int(np.sum(values > 1e-12 * values[0]))
        wanted = self.count if self.count is not None else int(np.argmax(left <= self.lost)) + 1
        if wanted > most:
            raise InputError(f"count: expected at most {most} modes, the rank of the snapshots, got {wanted}")
        solver = ReferenceSolver(state)
        kept = ritz(state, (weights[:, :wanted] / np.sqrt(values[:wanted])).T @ snapshots)
        amplitude = np.sqrt(np.mean((kept @ (mass @ snapshots.T)) ** 2, axis=1))
        text = f"{wanted} proper orthogonal modes"
        return add_companions(state, solver, kept, amplitude, RIGID_DIRECTIONS, self.companions, text)


class ReferenceSolver:
    """Solutions with the tangent stiffness of the reference."""

    def __init__(self, state: PrestressedState) -> None:
        self._matrix = state.system.pattern.symmetric_matrix(state.tangent_entries)
        self._factor = SymmetricFactorization(state.system.pattern)
        try:
            self._factor.factorize(state.tangent_entries)
        except np.linalg.LinAlgError:
            raise InputError(
                "state: expected a structure held against rigid motion, got a singular stiffness"
            ) from None

    def solve(self, right: Array) -> Array:
        """Static response to one load, shape (size,)."""
        return self._factor.solve(right)

    def multiply(self, vectors: Array) -> Array:
        """Stiffness times each of the vectors (n, size)."""
        return (self._matrix @ vectors.T).T

    def energies(self, vectors: Array) -> Array:
        """Twice the strain energies; of mass-normalised vectors the squared frequencies [rad^2/s^2], shape (n,)."""
        return np.einsum("ri,ri->r", vectors, self.multiply(vectors))


def rigid_load(inertia: InertiaOperator, direction: str) -> Array:
    """Load of a unit rigid acceleration along or about an axis [N, N m], shape (size,)."""
    axis = RIGID_DIRECTIONS.index(direction)
    if axis < 3:
        return inertia.zeroth_moment[axis]
    return inertia.load(cross_matrix(np.eye(3)[axis - 3]))


def spin_loads(inertia: InertiaOperator, directions: Sequence[str]) -> list[Array]:
    """Centrifugal loads of unit angular velocities about the given axes that are not zero [N, N m], shapes (size,)."""
    spins = [cross_matrix(np.eye(3)[RIGID_DIRECTIONS.index(name) - 3]) for name in directions if name.startswith("r")]
    loads = [inertia.load(spin @ spin) for spin in spins]
    return [load for load in loads if np.any(load)]


def ritz(state: PrestressedState, vectors: Array) -> Array:
    """Mass-normalised Ritz vectors of a span, in order of frequency; dependent directions are dropped, (r, size)."""
    system = state.system
    mass, stiffness = system.inertia.mass_matrix, system.pattern.symmetric_matrix(state.tangent_entries)
    norms = np.sqrt(np.einsum("ri,ri->r", vectors, (mass @ vectors.T).T))
    unit = vectors / norms[:, None]
    values, turn = np.linalg.eigh(unit @ (mass @ unit.T))
    keep = values > 1e-10 * values[-1]
    orthonormal = (turn[:, keep] / np.sqrt(values[keep])).T @ unit
    _, turn = np.linalg.eigh(orthonormal @ (stiffness @ orthonormal.T))
    return turn.T @ orthonormal


def add_companions(
    state: PrestressedState,
    solver: ReferenceSolver,
    kept: Array,
    amplitude: Array,
    directions: Sequence[str],
    mode: str,
    text: str,
) -> BasisVectors:
    """Static modal derivatives of the kept vectors, split into slow ones (unknowns) and fast ones (condensed).

    Parameters
    ----------
    state
        Prestressed state.
    solver
        Its static solver.
    kept
        Mass-normalised Ritz vectors, shape (r, size).
    amplitude
        Typical size of each coordinate, shape (r,); it weighs what the derivatives are worth.
    directions
        Rigid accelerations whose spin pulls on the companions.
    mode
        One of `COMPANIONS`.
    text
        Description of the kept vectors.
    """
    nothing = np.zeros((0, state.system.size))
    if mode == "none":
        return BasisVectors(kept, nothing, amplitude, f"{text}, no companions")
    first, second = pairs(len(kept))
    sizes = np.maximum(amplitude, 1e-2 * amplitude.max())
    forces = quadratic_forces(state.system, kept) * (sizes[first] * sizes[second])[:, None]
    fields = np.array([-solver.solve(force) for force in forces])
    # Responses to the centrifugal loads carry the stiffening by spin.
    inertia = state.system.inertia
    pulled = np.array([solver.solve(load) for load in spin_loads(inertia, directions)]).reshape(-1, state.system.size)
    pulled = pulled * np.sqrt(solver.energies(fields).max() / solver.energies(pulled))[:, None]
    fields = np.concatenate([fields, pulled])
    # Orthogonal to the kept vectors in the energy, so that both do not compete.
    fields = fields - (fields @ solver.multiply(kept).T / solver.energies(kept)) @ kept
    gram = fields @ solver.multiply(fields).T
    values, turn = np.linalg.eigh(0.5 * (gram + gram.T))
    keep = values > _NEGLIGIBLE * max(values[-1], 0.0)
    if not keep.any() or values[-1] <= 0.0:
        return BasisVectors(kept, nothing, amplitude, f"{text}, no companions")
    span = (turn[:, keep] / np.sqrt(values[keep])).T @ fields
    if mode == "unknowns":
        joined = ritz(state, np.concatenate([kept, span]))
        fast, moving = nothing, len(span)
    else:
        # Natural frequencies of the companions among themselves: stiffness is the identity in this span.
        inverse, turn = np.linalg.eigh(span @ (inertia.mass_matrix @ span.T))
        highest = 2.0 * np.sqrt(solver.energies(kept)[amplitude > _NOTABLE * amplitude.max()].max())
        slow = inverse > 1.0 / (_FAST * highest) ** 2
        joined = ritz(state, np.concatenate([kept, turn.T[slow] @ span]))
        fast, moving = turn.T[~slow] @ span, int(slow.sum())
    text = f"{text}, {moving} moving and {len(fast)} condensed companions"
    # What a coordinate is worth, from the kept vectors and from the fields that they call for.
    parts = np.concatenate([kept * amplitude[:, None], fields]) @ (inertia.mass_matrix @ joined.T)
    worth = np.sqrt(np.sum(parts**2, axis=0))
    return BasisVectors(joined, fast, worth, text)
