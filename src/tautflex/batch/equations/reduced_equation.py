"""Equations of motion of a reduced model for many runs: the run is the last axis of every array [theory.md 10]."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import jax.numpy as jnp
from jax import lax

from tautflex.batch.equations.assembly import PULL, TURN
from tautflex.batch.equations.equation import Forces, Sample, as_kind
from tautflex.batch.equations.input_terms import InputTerms
from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.library import jax
from tautflex.batch.steps.products import (
    Monomials,
    branched,
    norm,
    one_by_one,
    product,
    refined,
    settled,
    transposed,
)
from tautflex.motion.coupling import Coupling
from tautflex.reduction.polynomial.condensation import CondensedModel
from tautflex.reduction.polynomial.fields import Fields

Array = jax.Array


class Shared(NamedTuple):
    """What no parameter changes.

    Parameters
    ----------
    size
        Number of coordinates.
    monomials
        Their products.
    cubic, viscous
        Stress fields of the third-degree force and of the static derivatives' damping.
    curved
        Whether there are second-degree forces.
    """

    size: int
    monomials: Monomials
    cubic: Fields
    viscous: Fields
    curved: bool


class Damping(NamedTuple):
    """Damping of all runs.

    Parameters
    ----------
    alpha, beta
        Factors of mass and stiffness, shape (runs,).
    most
        Largest factor of the stiffness of a kind of element, shape (runs,).
    weights, vectors
        Weights of vectors, shape (rank, runs), and these, (rank, r).
    besides
        What kinds of element add, see `Assembly`; None where they are alike.
    """

    alpha: Array
    beta: Array
    most: Array
    weights: Array
    vectors: Array
    besides: tuple[Array, Array] | None


class ReducedEquation:
    """Equations of motion of the coordinates of all runs; see :mod:`tautflex.reduction.marching.steps` for the terms.

    Parameters
    ----------
    c
        Condensed model of every run; what all runs share lacks the last axis.
    damping
        Damping.
    modes
        Natural modes as columns, and squares of their frequencies.
    bounds
        Traces of two parts of the tangent as quadratic forms, matrices, and the norm of the inverse of the mass matrix.
    absent
        Names and places of turning terms that are zero.
    kept
        Readings of the coordinates, shape (n, r).
    acting
        What inputs do; None without any.
    """

    def __init__(
        self,
        shared: Shared,
        c: CondensedModel,
        damping: Damping,
        modes: tuple[Array, Array],
        bounds: tuple[Array, Array, Array],
        coupling: Coupling,
        absent: frozenset[tuple[str, int]],
        kept: Array,
        acting: InputTerms | None,
    ) -> None:
        self.parts: tuple[Any, ...] = shared, c, damping, modes, bounds, coupling, absent, kept, acting
        self.size, self._shared, self._c, self._coupling, self._absent = shared.size, shared, c, coupling, absent
        self._alpha, self._beta, self._most, weights, vectors, besides = damping
        self._damping = self._alpha * _per_run(c.mass) + self._beta * _per_run(c.linear)
        (self._phi, self._squares), self._bounds = modes, bounds
        self._back = transposed(self._phi)
        self._coupled_modes = len(vectors) > 0 or besides is not None
        self._besides = None if besides is None else besides[1]
        if besides is not None:
            self._damping += _per_run(besides[0])
            moved = jnp.einsum("ij...,jk...->ik...", besides[0], self._phi)
            self._alpha = self._alpha + jnp.sum(_per_run(self._phi * moved), axis=0)
        if len(vectors):
            self._damping += jnp.einsum("kn,ki,kj->ijn", weights, vectors, vectors)
            own = _per_run(jnp.einsum("ki,ij...->kj...", vectors, self._phi))
            self._alpha = self._alpha + jnp.sum(weights[:, None] * own * own, axis=0)
        self._own, self._coupled = tuple(c.turning), tuple(c.turning_derivatives)
        self._monomials, self._kept, self._acting = shared.monomials, kept, acting

    def in_kind(self, kind: Any) -> ReducedEquation:
        """The same equations with coefficients of a floating-point type; states must have it too."""
        return type(self)(*as_kind(kind, self.parts))

    def _weights(self, spin: Spin) -> tuple[Any, Any, Any]:
        """Factors of the gyroscopic, Euler and centrifugal terms."""
        c = self._coupling
        gyro, turn = 2.0 * spin.rate * float(c.gyroscopic), spin.acceleration * float(c.euler)
        return gyro, turn, spin.square * float(c.centrifugal)

    def _load(self, load: Array, spin: Spin) -> Array:
        """Loads of angular acceleration and squared rate on something, shape (2, n) -> (n, runs)."""
        on = self._coupling.load_factor
        first, second = _per_run(load)
        return on * spin.acceleration * first + on * spin.square * second

    def predicted(self, q: Array, v: Array, spin: Spin) -> tuple[Array, Array, Array]:
        """Load, and stress and force that go through the static derivatives, as the single run takes them.

        Where nothing turns they are not computed.
        """
        m = len(self._monomials.first)
        nothing = jnp.zeros_like(q), jnp.zeros((m, *q.shape[1:]), q.dtype), jnp.zeros_like(q)
        turning = jnp.any(spin.rate != 0.0) | jnp.any(spin.acceleration != 0.0) | jnp.any(spin.square != 0.0)
        of_frame = lax.cond(turning, self._through_derivatives, lambda q, v, spin: nothing, q, v, spin)
        if self._acting is None or isinstance(spin.inputs, tuple):
            return of_frame
        force, stress, load = of_frame
        own, given = self._acting.of_numbers(spin.inputs)
        return force + own, stress + given, load + own

    def given(self, spin: Spin, q: Array) -> tuple[Array, Array]:
        """What does not depend on the state: load, shape (r, runs), and stress on the monomials, shape (m, runs)."""
        load, stress = (self._load(part, spin) + 0.0 * q[0] for part in (self._c.load, self._c.load_stress))
        if self._acting is None or isinstance(spin.inputs, tuple):
            return load, stress
        own, given = self._acting.of_numbers(spin.inputs)
        return load + own, stress + given

    def power(self, stress: Array, q: Array, v: Array) -> Array:
        """Power of a stress on the monomials, shape (runs,)."""
        return jnp.sum(stress * self._monomials.rates(q, v), axis=0)

    def _through_derivatives(self, q: Array, v: Array, spin: Spin) -> tuple[Array, Array, Array]:
        gyro, turn, pull = self._weights(spin)
        load = self._load(self._c.load, spin)
        stress, force = self._load(self._c.load_stress, spin), jnp.zeros_like(q)
        y, rate = self._monomials.values(q), self._monomials.rates(q, v)
        if ("turning_derivatives", TURN) not in self._absent:
            matrix = self._coupled[TURN]
            stress += product(matrix, settled(gyro * v + turn * q))
            # M(S) is skew, M(S^2) symmetric.
            force -= product(transposed(matrix), settled(gyro * rate + turn * y))
        if ("turning_derivatives", PULL) not in self._absent:
            matrix = self._coupled[PULL]
            stress += pull * product(matrix, q)
            force += pull * product(transposed(matrix), settled(y))
        return load + force, stress, load

    def _turning(self, q: Array, v: Array, spin: Spin) -> Array:
        """Gyroscopic, Euler and centrifugal force on the coordinates themselves."""
        gyro, turn, pull = self._weights(spin)
        force = jnp.zeros_like(q)
        if ("turning", TURN) not in self._absent:
            force += product(self._own[TURN], gyro * v + turn * q)
        if ("turning", PULL) not in self._absent:
            force += pull * product(self._own[PULL], q)
        return force

    def frame(self, q: Array, v: Array, spin: Spin) -> Array:
        """Part of the forces that jumps with the motion, shape (r, runs)."""
        force, stress, _ = self.predicted(q, v, spin)
        return force + self._turning(q, v, spin) + self._monomials.force(stress, q)

    def _stress(self, y: Array) -> Array:
        return _through(self._shared.cubic, lambda y: product(self._c.cubic, y), y)

    def _lagging(self, rate: Array) -> Array:
        """Stress of the static derivatives' damping at rates of the monomials, shape (m, runs)."""
        viscous, besides, fields = self._c.viscous, self._besides, self._shared.viscous

        def resist(rate: Array) -> Array:
            own = self._beta * product(viscous, rate)
            return own if besides is None else own + product(besides, rate)

        return _through(fields, resist, rate)

    def internal(self, q: Array, v: Array, predicted: tuple[Array, Array, Array]) -> Array:
        """Internal force, that of the static derivatives and their damping included, shape (r, runs)."""
        y, rate = self._monomials.values(q), self._monomials.rates(q, v)
        stress = predicted[1] + self._stress(y) + self._lagging(rate)
        force = product(self._c.linear, q) + self._monomials.force(stress, q)
        return force + product(self._c.quadratic, y) if self._shared.curved else force

    def forces(self, q: Array, v: Array, spin: Spin, predicted: tuple[Array, Array, Array]) -> Forces:
        """All forces but inertia; the internal norm counts what the static derivatives feel, as the single run does."""
        internal = settled(self.internal(q, v, predicted))
        total = settled(internal + self.around(q, v, spin, predicted))
        return Forces(total, norm(internal), norm(predicted[2]))

    def around(self, q: Array, v: Array, spin: Spin, predicted: tuple[Array, Array, Array]) -> Array:
        """All forces but inertia and internal ones, shape (r, runs)."""
        return predicted[0] + self._turning(q, v, spin) + product(self._damping, v)

    def mass(self, a: Array) -> Array:
        """Mass times acceleration, shape (r, runs)."""
        return product(self._c.mass, a)

    def inverse(self, mass: Any, damping: Any, stiffness: Any) -> Callable[[Array], Array]:
        """Inverse of ``mass M + damping C + stiffness K`` at the reference, less what C couples of natural modes."""
        diagonal = mass + damping * self._alpha + (stiffness + damping * self._beta) * self._squares
        return lambda r: settled(product(self._phi, settled(product(self._back, r) / diagonal)))

    def mass_solve(self, force: Array) -> Array:
        """Acceleration of a force, shape (r, runs)."""
        inverse = self.inverse(1.0, 0.0, 0.0)
        return lax.custom_linear_solve(self.mass, force, lambda _, f: inverse(f), lambda _, f: inverse(f))

    def end_acceleration(self, force: Array, half: Any, spin: Spin | None) -> Array:
        """Solution a of ``(M + half (C + G)) a = force``, shape (r, runs); without a spin there is no G."""
        still = spin is None or ("turning", TURN) in self._absent
        gyro = 0.0 if spin is None else self._weights(spin)[0]
        without = self.inverse(1.0, half, 0.0)

        def left(a: Array) -> Array:
            result = self.mass(a) + half * product(self._damping, a)
            return result if still else result + half * gyro * product(self._own[TURN], a)

        def solve(left: Callable[[Array], Array], force: Array) -> Array:
            if still and not self._coupled_modes:
                return without(force)
            # What is left out is small: half a step times the rate, or times a damping ratio and a frequency.
            return refined(left, without, force)

        return lax.custom_linear_solve(left, force, solve, solve)

    def follows(self, size: float, share: float, q: Array, predicted: tuple[Array, Array, Array]) -> Array:
        """Whether a share of the limit of central differences lets steps of a size follow the stiffness at q.

        Traces bound the eigenvalues; only where that is not enough the tangent is looked at. Likewise the static
        derivatives' damping, which is taken from the predicted velocity and must not reverse it.
        """
        q, predicted = lax.stop_gradient((q, predicted))
        cubic, viscous, heaviness = lax.stop_gradient(self._bounds)
        limit = share * 4.0 / size**2
        stress = predicted[1] + self._stress(self._monomials.values(q))
        bound = jnp.max(self._squares, axis=0) + heaviness * (
            jnp.sum(q * product(cubic, q), axis=0) + jnp.sqrt(2.0) * norm(stress)
        )
        near = ~(bound <= limit * self._mobile(q))
        if self._shared.curved:
            near = jnp.ones_like(near)
        soft = lax.cond(jnp.any(near), lambda: self._softer(limit, q, predicted), lambda: jnp.ones_like(near))
        lagging = size * self._most * jnp.sum(q * product(viscous, q), axis=0)
        return (soft | ~near) & (lagging <= share)

    def _mobile(self, q: Array) -> Array | float:
        """Least part of the mass that moves on its own where what carries the structure recoils."""
        return 1.0

    def moving(self, q: Array, a: Array) -> Array:
        """Mass that moves on its own times acceleration, shape (r, runs)."""
        return self.mass(a)

    def _softer(self, limit: float, q: Array, predicted: tuple[Array, Array, Array]) -> Array:
        """Whether ``limit M`` less the tangent stiffness at q is positive definite."""

        def force(q: Array) -> Array:
            return self.internal(q, jnp.zeros_like(q), predicted)

        units = jnp.eye(self.size, dtype=q.dtype)[:, :, None] * jnp.ones_like(q[0])
        tangents = jax.vmap(lambda unit: jax.jvp(force, (q,), (unit,))[1])(units)
        masses = jax.vmap(lambda unit: self.moving(q, unit))(units)
        lower = one_by_one(jnp.linalg.cholesky, jnp.moveaxis(limit * masses - tangents, -1, 0))
        return jnp.all(jnp.isfinite(lower), axis=(1, 2))

    def sample(self, q: Array, v: Array, spin: Spin, store: tuple[str, ...]) -> Sample:
        """What is stored of an instant."""
        c, found = self._c, Sample()
        y = settled(self._monomials.values(q))
        if "displacement" in store:
            offset = self._load(c.follow_load, spin)
            if self._acting is not None:
                offset = offset + self._acting.look @ spin.inputs
            found["displacement"] = _points(self._kept @ q + product(c.follow_quadratic, y) + offset)
        if "velocity" in store:
            found["velocity"] = _points(
                self._kept @ v + product(c.follow_quadratic, settled(self._monomials.rates(q, v)))
            )
        if "energy" in store:
            strain = 0.5 * jnp.sum(q * product(c.linear, q), axis=0)
            strain += 0.5 * jnp.sum(y * self._stress(y), axis=0)
            if self._shared.curved:
                strain += jnp.sum(q * product(c.quadratic, y), axis=0) / 3.0
            if self._acting is not None:
                strain += self._acting.stored(q, y, spin.inputs)
            found["energy"] = jnp.stack([0.5 * jnp.sum(v * self.mass(v), axis=0), strain])
        return found


def _per_run(array: Array) -> Array:
    """A matrix, or a pair of vectors, with an axis of the runs."""
    return array[..., None] if array.ndim == 2 else array


def _points(readings: Array) -> Array:
    """Readings of three components per probe: (n, runs) -> (probe, 3, runs)."""
    return readings.reshape(-1, 3, *readings.shape[1:])


def _through(fields: Fields, function: Callable[[Array], Array], y: Array) -> Array:
    """``F' f(F y)`` of a linear function of all runs."""
    if fields.shape is None:
        return branched(function, y)
    shape = jnp.asarray(fields.shape, y.dtype)
    return shape.T @ function(shape @ y)
