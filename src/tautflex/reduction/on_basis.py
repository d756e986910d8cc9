"""What all reduced models share: a structure whose motion is a few vectors, and perhaps what follows them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.numeric import Array
from tautflex.reduction.bases.vectors import BasisVectors, ReferenceSolver
from tautflex.reduction.polynomial.condensation import CondensedModel
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.problem import SteppingModel
from tautflex.structure.model import Model


class OnBasis(SteppingModel):
    """Structure on a basis; as it stands here, nothing follows the coordinates but their vectors."""

    basis: BasisVectors

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.basis.kept)

    @property
    def model(self) -> Model:
        """The structure."""
        return self.state.model

    @cached_property
    def reference(self) -> ReferenceSolver:
        """Static solver of the full reference."""
        return ReferenceSolver(self.state)

    @property
    @abstractmethod
    def coefficients(self) -> CondensedModel:
        """Equation of motion of the coordinates at the parameters of the state."""

    @abstractmethod
    def weighed(self, factors: Mapping[str, float]) -> CondensedModel:
        """The same with the inertial load of each kind of element times its factor."""

    @abstractmethod
    def arrays(self, damping: Damping) -> Any:
        """Arrays for the compiled stepper under a damping model."""

    def coordinates(self, q: Array) -> Array:
        """Coordinates of free unknowns by mass projection, shape (..., size) -> (..., r)."""
        mass = self.state.system.inertia.mass_matrix
        return (mass @ q.T).T @ self.basis.kept.T

    def displacement(self, eta: Array, offset: Array | None = None) -> Array:
        """Free unknowns [m, rad] from coordinates, shape (..., r) -> (..., size)."""
        return eta @ self.basis.kept

    def motion(self, eta: Array, rate: Array, acceleration: Array, offset: Array) -> tuple[Array, Array, Array]:
        """Free unknowns, their velocities and accelerations from those of the coordinates, shapes (size,)."""
        kept = self.basis.kept
        return eta @ kept, rate @ kept, acceleration @ kept

    def seen(self, look: csr_array, eta: Array, rate: Array, offset: Array) -> tuple[Array, Array]:
        """Readings ``look @ q`` of displacement and velocity at instants, shapes (time, reading)."""
        vectors = (look @ self.basis.kept.T).T
        return eta @ vectors, rate @ vectors

    @property
    def monomial_vectors(self) -> Array:
        """Displacement that follows each monomial, shape (m, size)."""
        return np.zeros((0, self.state.system.size))


def refuse_drifting(state: PrestressedState) -> None:
    """Raise UnsupportedError for a structure that can drift away: its static responses have no end."""
    if state.model.rigid_freedom:
        raise UnsupportedError(
            f"supports: expected a structure held against rigid motion, {state.model.rigid_freedom} rigid motion(s) "
            "are free; hold the frame (frame.support = 'corners')"
        )
