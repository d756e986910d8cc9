"""What all reduced models share: a structure whose motion is a few vectors, and perhaps what follows them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from tautflex.errors import UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.surface import SurfaceOnVectors
from tautflex.numeric import Array
from tautflex.reduction.bases.answers import fast_limit
from tautflex.reduction.bases.vectors import BasisVectors, ReferenceSolver
from tautflex.reduction.polynomial.condensation import CondensedModel
from tautflex.reduction.polynomial.monomials import monomial_rates, monomials
from tautflex.reduction.polynomial.strains import quadratic_forces
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.problem import SteppingModel
from tautflex.structure.model import Model

# Motion across the film, beside all motion, of vectors that count as in its plane: 1e-7 of what is seen across, as they
# are a thousandth of the coordinates' motion themselves.
_IN_PLANE = 1e-4


class OnBasis(SteppingModel):
    """Structure on a basis: displacement = eta kept + (E y + load response) derivatives."""

    basis: BasisVectors
    in_elements: ClassVar[bool] = False
    """Whether stresses act in the model's own elements; else their work on the strains is a polynomial."""

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.basis.kept)

    @property
    def model(self) -> Model:
        """The structure."""
        return self.state.model

    @property
    def monomial_count(self) -> int:
        """Number of monomials."""
        return int(self.coefficients.load_stress.shape[1])

    @cached_property
    def second_degree(self) -> Array:
        """Second-degree internal force of the coordinates on all unknowns per monomial, shape (m, size)."""
        return quadratic_forces(self.state.system, self.basis.kept)

    @cached_property
    def reference(self) -> ReferenceSolver:
        """Static solver of the full reference."""
        return ReferenceSolver(self.state)

    @cached_property
    def fast_limit(self) -> float:
        """Frequency from which on what is not kept answers at once [rad/s]."""
        return fast_limit(self.reference, self.basis)

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

    def restressed(self, arrays: Any, columns: Mapping[int, Array], answers: Array) -> Any:
        """Arrays with room for n stresses that inputs give (row, strain, n), and for what answers them (n, size)."""
        return arrays

    def missed(self, columns: Mapping[int, Array]) -> Array:
        """Part of the stiffness by each of n stresses (row, strain, n) that the model has wrong, shape (n,)."""
        return np.zeros(next(iter(columns.values())).shape[2] if columns else 0)

    def coordinates(self, q: Array) -> Array:
        """Coordinates of free unknowns by mass projection, shape (..., size) -> (..., r)."""
        mass = self.state.system.inertia.mass_matrix
        return (mass @ q.T).T @ self.basis.kept.T

    def displacement(self, eta: Array, offset: Array | None = None) -> Array:
        """Free unknowns [m, rad] from coordinates.

        Parameters
        ----------
        eta
            Coordinates, shape (..., r).
        offset
            Static derivatives that the load prescribes, shape (..., p); None is none.

        Returns
        -------
        numpy.ndarray
            Shape (..., size).
        """
        result = eta @ self.basis.kept + self._following(monomials(eta))
        return result if offset is None else result + offset @ self.basis.derivatives

    def frames(self, eta: Array, offset: Array) -> NDArray[np.float32]:
        """Displacement of all nodes [m] in single precision, as `displacement` in one product, (time, node, 3)."""
        parts = [eta]
        if len(self.basis.derivatives):
            parts.append(monomials(eta) @ self.coefficients.follow_quadratic.T + offset)
        return (np.concatenate(parts, axis=1).astype(np.float32) @ self._frame_vectors).reshape(len(eta), -1, 3)

    @cached_property
    def _frame_vectors(self) -> NDArray[np.float32]:
        """Vectors and static derivatives at all nodes, shape (r + p, 3 node)."""
        vectors = np.concatenate([self.basis.kept, self.basis.derivatives])
        return self.state.system.translations(vectors).reshape(len(vectors), -1).astype(np.float32)

    def _following(self, y: Array) -> Array | float:
        """Displacement that follows monomials at once, shape (..., m) -> (..., size)."""
        return y @ self.monomial_vectors if len(self.basis.derivatives) else 0.0

    def motion(self, eta: Array, rate: Array, acceleration: Array, offset: Array) -> tuple[Array, Array, Array]:
        """Free unknowns, their velocities and accelerations from those of the coordinates, shapes (size,)."""
        kept, bend = self.basis.kept, monomial_rates(eta, acceleration) + 2.0 * monomials(rate)
        v = rate @ kept + self._following(monomial_rates(eta, rate))
        return self.displacement(eta, offset), v, acceleration @ kept + self._following(bend)

    def looked(self, look: csr_array, answers: Array) -> tuple[Array, ...]:
        """Readings ``look @ q`` of vectors, static derivatives, what follows monomials, and answers to stresses."""
        kept, derivatives, beside = ((look @ each.T).T for each in (self.basis.kept, self.basis.derivatives, answers))
        return kept, derivatives, self.coefficients.follow_quadratic.T @ derivatives, beside

    def seen(
        self, looked: tuple[Array, ...], eta: Array, rate: Array, offset: Array, stresses: Array
    ) -> tuple[Array, Array]:
        """Readings of displacement and velocity at instants, shapes (time, reading)."""
        kept, derivatives, follow, beside = looked
        place, speed = eta @ kept, rate @ kept
        if len(derivatives):
            place = place + monomials(eta) @ follow + offset @ derivatives
            speed = speed + monomial_rates(eta, rate) @ follow
        return place + stresses @ beside, speed

    def surface(self, eta: Array, offset: Array) -> Array:
        """Measures of the film, as `FilmSurface.measure` has them, at instants, shape (time, 4)."""
        if self.film.count == self.size:
            return self.film.measure(eta)
        return self.film.measure(np.concatenate([eta, monomials(eta), offset], axis=1))

    @cached_property
    def film(self) -> SurfaceOnVectors:
        """The film's measures, of the coordinates alone or of all that moves it."""
        film, following = self.state.system.surface, self.basis.derivatives
        # What follows a flat film's motion stays in its plane, but for round-off.
        across, whole = (np.abs(part).max(initial=0.0) for part in (film.look @ following.T, following))
        followed = [self.monomial_vectors, following] if across > _IN_PLANE * whole else []
        return SurfaceOnVectors(film, np.concatenate([self.basis.kept, *followed]))

    @cached_property
    def monomial_vectors(self) -> Array:
        """Displacement that follows each monomial, shape (m, size)."""
        return self.coefficients.follow_quadratic.T @ self.basis.derivatives


def refuse_turning(state: PrestressedState) -> None:
    """UnsupportedError if beams turn by any angle: a basis adds vectors, and their forces are no polynomials."""
    if any(block.turns for block in state.system.blocks):
        raise UnsupportedError(
            "strain: expected beams whose forces are polynomials, got 'corotational' ones, which only simulate, "
            "solve_static and modes take; set the frame's strain = 'green-lagrange'"
        )


def refuse_drifting(state: PrestressedState) -> None:
    """Raise UnsupportedError for a structure that can drift away: its static responses have no end."""
    if state.model.rigid_freedom:
        raise UnsupportedError(
            f"supports: expected a structure held against rigid motion, {state.model.rigid_freedom} rigid motion(s) "
            "are free; hold the frame (frame.support = 'corners')"
        )
