"""The reduced model as pure functions: coefficients are assembled from its pieces once per run [theory.md 10]."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from tautflex.batch.course import Course, Numbers, Spin
from tautflex.batch.equation import Forces, Sample
from tautflex.batch.library import jax
from tautflex.mechanics.damping import Rayleigh
from tautflex.mechanics.inertia import cross_matrix
from tautflex.motion.coupling import Coupling
from tautflex.motion.maneuvers import unit_axis
from tautflex.reduction.model import ReducedModel
from tautflex.reduction.monomials import pairs
from tautflex.reduction.pieces import Coefficients, Factors, assemble
from tautflex.solvers.probes import ProbeSet

Array = jax.Array

_SECANTS = 1


class ReducedPlant:
    """A reduced model for batches.

    Parameters
    ----------
    rom
        Reduced model.
    """

    def __init__(self, rom: ReducedModel) -> None:
        self.rom, self.state, self.size = rom, rom.state, rom.size
        self.secants = _SECANTS
        self.kinds = tuple(rom.pieces.elastic)
        first, second = pairs(rom.size)
        # Second-degree forces of a flat structure are round-off.
        self.curved = rom.plant(Rayleigh()).quadratic.size > 0
        self.pick = jnp.asarray(np.eye(rom.size)[np.concatenate([first, second])])

    def equation(self, numbers: Numbers, course: Course, coupling: Coupling, probes: ProbeSet) -> ReducedEquation:
        """Equation of one run."""
        return ReducedEquation(self, numbers, course, coupling, probes)


class ReducedEquation:
    """Equation of motion of the coordinates of one run; see :mod:`tautflex.reduction.march` for its terms.

    Parameters
    ----------
    plant
        Reduced model.
    numbers
        Factors and damping, possibly traced.
    course
        Maneuver.
    coupling
        Switches of the rotating-frame terms.
    probes
        Measuring points.
    """

    def __init__(
        self, plant: ReducedPlant, numbers: Numbers, course: Course, coupling: Coupling, probes: ProbeSet
    ) -> None:
        self.size, self._plant, self._coupling = plant.size, plant, coupling
        spin, origin = cross_matrix(unit_axis(course.axis)), np.asarray(course.origin, dtype=float)
        self._alpha, self._beta = numbers["damping.alpha"], numbers["damping.beta"]

        def by_kind(name: str) -> dict[str, Any]:
            return {kind: numbers[f"{name}.{kind}"] for kind in plant.kinds if f"{name}.{kind}" in numbers}

        factors = Factors(
            numbers.get("tension_x", 1.0),
            numbers.get("tension_y", 1.0),
            by_kind("youngs_modulus"),
            by_kind("density"),
        )
        # Its fields are arrays of the library it was assembled with.
        c: Any = assemble(plant.rom.pieces, factors, jnp)
        self._c = c
        self._count = c.cubic.shape[0]
        self._pick = plant.pick
        self._mass_inverse = jnp.linalg.inv(c.mass)
        self._modes = _natural_modes(jax.lax.stop_gradient(c.mass), jax.lax.stop_gradient(c.linear))
        self._cubic, self._viscous = 0.25 * c.cubic, self._beta * c.viscous
        turn = [_turning(c, weight, origin) for weight in (spin, spin @ spin)]
        self._turn = turn
        self._damping = self._alpha * c.mass + self._beta * c.linear
        self._load, self._follow = [part.load for part in turn], [part.follow for part in turn]
        basis = plant.rom.basis
        self._kept = jnp.asarray((probes.map @ basis.kept.T).T)
        self._companions = jnp.asarray((probes.map @ basis.companions.T).T)

    def _monomials(self, q: Array) -> Array:
        """Products ``q_i q_j``, i <= j; selection by small matrices is faster than by index, here and on a GPU."""
        both = self._pick @ q
        return both[: self._count] * both[self._count :]

    def _pairs(self, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Monomials, their rates, and the factors ``(q_j, q_i)`` of every monomial."""
        m = self._count
        place, rate = self._pick @ q, self._pick @ v
        swapped = jnp.concatenate([place[m:], place[:m]])
        both = rate * swapped
        return place[:m] * place[m:], both[:m] + both[m:], swapped

    def _applied(self, s: Array, swapped: Array) -> Array:
        """Force ``Y' s`` of stresses that work on the monomials."""
        return (jnp.concatenate([s, s]) * swapped) @ self._pick

    def _scales(self, spin: Spin) -> tuple[Any, Any]:
        on = float(self._coupling.inertial_load)
        return on * spin.acceleration, on * spin.square

    def _weights(self, spin: Spin) -> tuple[Any, Any, Any]:
        """Factors of the gyroscopic, Euler and centrifugal terms."""
        c = self._coupling
        return (
            2.0 * spin.rate * float(c.gyroscopic),
            spin.acceleration * float(c.euler),
            spin.square * float(c.centrifugal),
        )

    def predicted(self, q: Array, v: Array, spin: Spin) -> tuple[Array, Array]:
        """Force and stress of the moving frame that go through the companions, as the single run takes them."""
        gyro, turn, pull = self._weights(spin)
        euler, square = self._scales(spin)
        y, rate, _ = self._pairs(q, v)
        first, second = self._turn
        force = (gyro * rate + turn * y) @ first.back + pull * (y @ second.back)
        stress = first.companions @ (gyro * v + turn * q) + pull * (second.companions @ q)
        return force, stress + euler * self._load[0][self.size :] + square * self._load[1][self.size :]

    def _on_coordinates(self, q: Array, v: Array, spin: Spin) -> tuple[Array, Array]:
        """Force of the moving frame on the coordinates themselves, and its load."""
        gyro, turn, pull = self._weights(spin)
        euler, square = self._scales(spin)
        load = euler * self._load[0][: self.size] + square * self._load[1][: self.size]
        first, second = self._turn
        return load + first.own @ (gyro * v + turn * q) + pull * (second.own @ q), load

    def frame(self, q: Array, v: Array, spin: Spin) -> Array:
        """Part of the forces that jumps with the motion, shape (r,)."""
        force, stress = self.predicted(q, v, spin)
        return force + self._on_coordinates(q, v, spin)[0] + self._applied(stress, self._pairs(q, v)[2])

    def forces(self, q: Array, v: Array, spin: Spin, predicted: tuple[Array, Array]) -> Forces:
        """All forces but inertia; the internal norm counts what the companions feel, as the single run does."""
        c, (force, stress) = self._c, predicted
        y, rate, swapped = self._pairs(q, v)
        internal = c.linear @ q + self._applied(stress + self._cubic @ y + self._viscous @ rate, swapped)
        if self._plant.curved:
            internal += c.quadratic @ y
        turning, load = self._on_coordinates(q, v, spin)
        total = internal + force + turning + self._damping @ v
        return Forces(total, jnp.linalg.norm(internal), jnp.linalg.norm(load))

    def mass(self, a: Array) -> Array:
        """Mass times acceleration, shape (r,)."""
        return self._c.mass @ a

    def mass_solve(self, force: Array) -> Array:
        """Acceleration of a force, shape (r,)."""
        return self._mass_inverse @ force

    def inverse(self, mass: Any, damping: Any, stiffness: Any) -> Callable[[Array], Array]:
        """Inverse of ``mass M + damping C + stiffness K`` at the reference."""
        phi, squares = self._modes
        diagonal = mass + damping * self._alpha + (stiffness + damping * self._beta) * squares
        return lambda r: phi @ ((r @ phi) / diagonal)

    def sample(self, q: Array, v: Array, spin: Spin, store: tuple[str, ...]) -> Sample:
        """What is stored of an instant."""
        c, found = self._c, Sample()
        y = self._monomials(q)
        if "displacement" in store:
            euler, square = self._scales(spin)
            follow = c.follow_quadratic @ y + euler * self._follow[0] + square * self._follow[1]
            found["displacement"] = (q @ self._kept + follow @ self._companions).reshape(-1, 3)
        if "velocity" in store:
            follow = c.follow_quadratic @ self._pairs(q, v)[1]
            found["velocity"] = (v @ self._kept + follow @ self._companions).reshape(-1, 3)
        if "energy" in store:
            strain = 0.5 * q @ c.linear @ q + q @ (c.quadratic @ y) / 3.0 + 0.5 * y @ self._cubic @ y
            found["energy"] = jnp.stack([0.5 * v @ c.mass @ v, strain])
        return found


class _Turning(NamedTuple):
    """``M(Z)`` of the coordinates, between companions and coordinates both ways, and what the load Z does."""

    own: Array
    companions: Array
    back: Array
    load: Array
    follow: Array


def _turning(c: Coefficients, weight: np.ndarray, origin: np.ndarray) -> _Turning:
    """Terms of one matrix Z; the frame's origin is at ``-origin`` from the line it turns about."""
    push = -weight @ origin
    first = jnp.concatenate([c.first, c.first_stress], axis=2)
    zeroth = jnp.concatenate([c.zeroth, c.zeroth_stress], axis=1)
    return _Turning(
        jnp.einsum("ab,abij->ij", weight, c.turning),
        jnp.einsum("ab,abkj->kj", weight, c.turning_companions),
        jnp.einsum("ab,bakj->kj", weight, c.turning_companions),
        jnp.einsum("ab,abi->i", weight, first) + push @ zeroth,
        jnp.einsum("ab,abi->i", weight, c.follow_first) + push @ c.follow_zeroth,
    )


def _natural_modes(mass: Array, stiffness: Array) -> tuple[Array, Array]:
    """Mass-normalised modes as columns and squares of their frequencies."""
    lower = jnp.linalg.cholesky(mass)
    half = jax.scipy.linalg.solve_triangular(lower, stiffness, lower=True)
    squares, turn = jnp.linalg.eigh(jax.scipy.linalg.solve_triangular(lower, half.T, lower=True))
    return jax.scipy.linalg.solve_triangular(lower.T, turn, lower=False), squares
