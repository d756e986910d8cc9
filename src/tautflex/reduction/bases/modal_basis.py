"""Natural modes as basis of a reduced model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, UnsupportedError
from tautflex.numeric import Array
from tautflex.reduction.bases.static_derivatives import TREATMENTS, add_static_derivatives
from tautflex.reduction.bases.vectors import Basis, BasisVectors, ReferenceSolver, ritz
from tautflex.solvers.modal.natural import solve_modes
from tautflex.solvers.modal.rigid import RIGID_DIRECTIONS, rigid_loads
from tautflex.solvers.static.prestress import PrestressedState

# Part of the largest static energy below which a load is none but for round-off.
_NO_LOAD = 1e-24


@dataclass(frozen=True)
class ModalBasis(Basis):
    """Natural modes chosen by their participation in the load, static correction, and static modal derivatives.

    Parameters
    ----------
    directions
        Rigid accelerations that load the structure, of ``"x", "y", "z", "rx", "ry", "rz"``. The paper's antenna turns
        about x: ``("rx",)``. Fewer directions make a smaller model. Those that load nothing are left out.
    count
        Number of modes; None takes every mode with a part of at least ``threshold`` in a load's static strain energy.
    threshold
        Smallest part that counts.
    candidates
        Number of lowest modes among which is chosen.
    static_correction
        Add, for each direction, the static response that the chosen modes leave out.
    derivatives
        ``"condensed"``: in-plane fields follow at once; ``"unknowns"``: they move, with mass; ``"none"``: left out,
        which makes the film far too stiff.

    Raises
    ------
    InputError
        If an argument is out of range, or, once a structure is reduced, if no direction loads it.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.ModalBasis(directions=("rx",), count=12).count
    12
    """

    directions: Sequence[str] = ("z", "rx", "ry")
    count: int | None = None
    threshold: float = 5e-4
    candidates: int = 60
    static_correction: bool = True
    derivatives: str = "condensed"

    def __post_init__(self) -> None:
        for direction in checks.several("directions", self.directions, str, "'rx'"):
            checks.one_of("directions", direction, RIGID_DIRECTIONS)
        if not self.directions:
            raise InputError("directions: expected at least one of 'x', 'y', 'z', 'rx', 'ry', 'rz', got none")
        checks.flag("static_correction", self.static_correction)
        if self.count is not None:
            checks.whole("count", self.count, 1)
            if self.count > checks.whole("candidates", self.candidates, 1):
                text = f"count: expected at most candidates = {self.candidates}, got {self.count}"
                raise InputError(f"{text}; raise candidates, or take fewer modes")
        checks.between("threshold", self.threshold, 0.0, 1.0)
        checks.whole("candidates", self.candidates, 1)
        checks.one_of("derivatives", self.derivatives, TREATMENTS)

    def vectors(self, state: PrestressedState) -> BasisVectors:
        """Find the vectors for a prestressed state."""
        solver = ReferenceSolver(state)
        loads, static, energies = self._responses(state, solver)
        modes = solve_modes(state, n=min(self.candidates, state.system.size - 1))
        values = (2.0 * np.pi * modes.frequencies) ** 2
        if not values.all():
            text = f"candidates: expected modes with stiffness, got {np.sum(values == 0.0)} of frequency zero"
            raise UnsupportedError(f"{text}; hold the structure against rigid motion")
        participation = (modes.vectors @ loads.T).T
        shares = participation**2 / values / energies[:, None]
        best = shares.max(axis=0)  # parts of the static strain energy
        if self.count is not None and self.count > len(best):
            text = f"count: expected at most the {len(best)} modes among which is chosen, got {self.count}"
            raise InputError(f"{text}; take fewer, or raise candidates if the structure has more")
        wanted = self.count if self.count is not None else max(1, int(np.sum(best >= self.threshold)))
        chosen = np.sort(np.argsort(-best, kind="stable")[:wanted])
        kept = modes.vectors[chosen]
        if self.static_correction:
            kept = np.concatenate([kept, static])
        kept = ritz(state, kept)
        amplitude = np.abs(loads @ kept.T).max(axis=0) / solver.energies(kept)
        text = f"{len(chosen)} natural modes"
        return add_static_derivatives(state, solver, kept, amplitude, self.directions, self.derivatives, text)

    def _responses(self, state: PrestressedState, solver: ReferenceSolver) -> tuple[Array, Array, Array]:
        """Loads of the directions, static responses (d, size) and twice their energies; a load that is none left out.

        A straight cable feels no turn about itself.
        """
        every = rigid_loads(state.system.inertia)
        loads = np.array([every[RIGID_DIRECTIONS.index(direction)] for direction in self.directions])
        static = np.array([solver.solve(load) for load in loads])
        energies = np.einsum("di,di->d", loads, static)
        felt = np.abs(energies) > _NO_LOAD * np.abs(energies).max()
        if not felt.any():
            text = f"directions: expected an acceleration that loads the structure, got {', '.join(self.directions)}"
            raise InputError(f"{text}, which nothing feels; take another of 'x', 'y', 'z', 'rx', 'ry', 'rz'")
        return loads[felt], static[felt], energies[felt]
