"""The reduced model as pure functions: coefficients are assembled from its pieces once per run [theory.md 10]."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from tautflex.batch.course import Course, Numbers, Spin
from tautflex.batch.equation import Forces, Sample
from tautflex.batch.library import jax
from tautflex.mechanics.inertia import cross_matrix
from tautflex.motion.coupling import Coupling
from tautflex.motion.maneuvers import unit_axis
from tautflex.reduction.model import ReducedModel
from tautflex.reduction.pieces import Coefficients, Factors, assemble
from tautflex.solvers.probes import ProbeSet

Array = jax.Array

_SECANTS = 2


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
        c = self._c = assemble(plant.rom.pieces, factors, jnp)
        self._mass_inverse = jnp.linalg.inv(c.mass)
        self._modes = _natural_modes(jax.lax.stop_gradient(c.mass), jax.lax.stop_gradient(c.linear))
        self._cubic, self._viscous = 0.25 * c.cubic, self._beta * c.viscous
        self._stiffness = jnp.concatenate([c.linear, c.quadratic], axis=1)
        self._viscous_stiffness = jnp.concatenate([self._cubic, self._viscous], axis=1)
        turn = [_turning(c, weight, origin) for weight in (spin, spin @ spin)]
        # One product for all that is linear in (q, v, swing, pull), one for what follows the companions.
        damping = self._alpha * c.mass + self._beta * c.linear
        none = jnp.zeros((c.cubic.shape[0], plant.size))
        self._on_coordinates = jnp.block(
            [[damping, turn[0].own, turn[1].own], [none, turn[0].companions, turn[1].companions]]
        )
        self._on_monomials = jnp.concatenate([turn[0].back.T, turn[1].back.T], axis=1)
        self._load, self._follow = [part.load for part in turn], [part.follow for part in turn]
        basis = plant.rom.basis
        self._kept = jnp.asarray((probes.map @ basis.kept.T).T)
        self._companions = jnp.asarray((probes.map @ basis.companions.T).T)

    def _monomials(self, q: Array) -> Array:
        """Products ``q_i q_j``, i <= j, by slices: gathers are slow on processors."""
        return jnp.concatenate([q[i] * q[i:] for i in range(self.size)])

    def _rates(self, q: Array, v: Array) -> Array:
        return jnp.concatenate([q[i] * v[i:] + v[i] * q[i:] for i in range(self.size)])

    def _applied(self, s: Array, q: Array) -> Array:
        """Force ``Y' s`` of stresses that work on the monomials."""
        starts = np.cumsum([0, *range(self.size, 1, -1)])
        upper = jnp.stack([jnp.pad(s[k : k + self.size - i], (i, 0)) for i, k in enumerate(starts)])
        return jnp.sum((upper + upper.T) * q, axis=1)

    def _scales(self, spin: Spin) -> tuple[Any, Any]:
        on = float(self._coupling.inertial_load)
        return on * spin.acceleration, on * spin.square

    def _frame_parts(self, q: Array, v: Array, y: Array, rate: Array, spin: Spin) -> tuple[Array, Array, Array]:
        """Force of damping and of the moving frame, stress of the latter, and its load."""
        c, r = self._coupling, self.size
        euler, square = self._scales(spin)
        load = euler * self._load[0] + square * self._load[1]
        gyro, turn = 2.0 * spin.rate * float(c.gyroscopic), spin.acceleration * float(c.euler)
        pull = spin.square * float(c.centrifugal)
        both = load + self._on_coordinates @ jnp.concatenate([v, gyro * v + turn * q, pull * q])
        follow = self._on_monomials @ jnp.concatenate([gyro * rate + turn * y, pull * y])
        return both[:r] + follow, both[r:], load[:r]

    def frame(self, q: Array, v: Array, spin: Spin) -> Array:
        """Part of the forces that jumps with the motion, shape (r,)."""
        force, stress, _ = self._frame_parts(q, jnp.zeros_like(v), self._monomials(q), self._rates(q, v), spin)
        gyro = 2.0 * spin.rate * float(self._coupling.gyroscopic)
        both = self._on_coordinates[:, self.size : 2 * self.size] @ (gyro * v)
        return force + both[: self.size] + self._applied(stress + both[self.size :], q)

    def forces(self, q: Array, v: Array, spin: Spin) -> Forces:
        """All forces but inertia; the internal norm counts what the companions feel, as the single run does."""
        c = self._c
        y, rate = self._monomials(q), self._rates(q, v)
        force, stress, load = self._frame_parts(q, v, y, rate, spin)
        stress = stress + self._viscous_stiffness @ jnp.concatenate([y, rate])
        internal = self._stiffness @ jnp.concatenate([q, y]) + self._applied(stress, q)
        return Forces(internal + force, jnp.linalg.norm(internal), jnp.linalg.norm(load))

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
            follow = c.follow_quadratic @ self._rates(q, v)
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
