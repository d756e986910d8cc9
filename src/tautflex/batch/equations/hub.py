"""A reduced model on a hub that is free to turn about one axis, for many runs [theory.md 9].

Terms are those of :mod:`tautflex.reduction.marching.free_hub`, steps those of its central differences.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp

from tautflex.batch.equations.assembly import PULL, TURN
from tautflex.batch.equations.equation import Sample
from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.equations.reduced_equation import ReducedEquation
from tautflex.batch.library import jax
from tautflex.batch.steps.products import product, settled, transposed

Array = jax.Array


class Place(NamedTuple):
    """What coordinates make of the inertia that they share with the hub.

    Parameters
    ----------
    coupling
        G: the structure's momentum about the axis is ``G deta/dt``, shape (r, runs).
    follow
        The same of the monomials, shape (m, runs).
    pull
        Centrifugal force of unit rate, shape (r, runs): ``dJ/dt = -2 pull deta/dt``.
    inertia
        J of hub and structure, shape (runs,).
    """

    coupling: Array
    follow: Array
    pull: Array
    inertia: Array


def dot(x: Array, y: Array) -> Array:
    """Inner products of all runs, (n, runs) -> (runs,)."""
    return jnp.sum(x * y, axis=0)


class HubEquation(ReducedEquation):
    """Equations of motion of coordinates and hub; ``parts`` are those of `ReducedEquation`.

    Parameters
    ----------
    moment
        Moment of inertia of hub and structure at rest about the axis [kg m^2], shape (runs,).
    push
        Torque of a unit of each input, shape (n,), and per coordinate, shape (n, r).
    """

    def __init__(self, *parts: Any) -> None:
        *own, self._moment, self._push = parts
        super().__init__(*own)
        self.parts = parts

    def place(self, q: Array) -> Place:
        """Inertia at coordinates."""
        y, force = settled(self._monomials.values(q)), self._monomials.force
        parts = []
        for term, sign in ((TURN, -1.0), (PULL, 1.0)):
            on_q, on_y = self._at_rest(self._c.load, term), self._at_rest(self._c.load_stress, term)
            if ("turning", term) not in self._absent:
                on_q = on_q + product(self._own[term], q)
            if ("turning_derivatives", term) not in self._absent:
                on_q = on_q + sign * product(transposed(self._coupled[term]), y)
                on_y = on_y + product(self._coupled[term], q)
            parts.append((on_q, on_y + 0.0 * y))
        (on_q, follow), (pull, on_y) = parts
        first, second = self._at_rest(self._c.load, PULL), self._at_rest(self._c.load_stress, PULL)
        inertia = self._moment - dot(pull + first, q) - dot(on_y + second, y)
        return Place(on_q + force(follow, q), follow, pull + force(on_y, q), inertia)

    def _at_rest(self, load: Array, term: int) -> Array:
        """Load of unit angular acceleration or squared rate, shape (n, runs) or (n, 1)."""
        return load[term] if load.ndim == 3 else load[term][:, None]

    def torque(self, q: Array, spin: Spin) -> Array:
        """Torque about the axis of all that acts from outside [N m], shape (runs,)."""
        if self._acting is None:
            return spin.torque
        torque, arms = (jnp.asarray(part) for part in self._push)
        return spin.torque + dot(spin.inputs, torque[:, None] + arms @ q)

    def coriolis(self, v: Array, rate: Array) -> Array:
        """Coriolis force of the coordinates alone, shape (r, runs)."""
        return jnp.zeros_like(v) if ("turning", TURN) in self._absent else product(self._own[TURN], 2.0 * rate * v)

    def late_coriolis(self, q: Array, v: Array, rate: Array) -> Array:
        """Coriolis force between monomials and coordinates, shape (r, runs)."""
        if ("turning_derivatives", TURN) in self._absent:
            return jnp.zeros_like(q)
        matrix, twice = self._coupled[TURN], 2.0 * rate
        through = self._monomials.force(product(matrix, twice * v), q)
        return through - product(transposed(matrix), settled(twice * self._monomials.rates(q, v)))

    def hub_acceleration(self, at: Place, v: Array, rate: Array, torque: Array, free: Array, solved: Array) -> Array:
        """Angular acceleration with which ``M a = M free - G' acceleration`` and the hub's balance hold, (runs,).

        ``free`` are the accelerations without it, ``solved`` is ``M^-1 G'``.
        """
        bend = 2.0 * dot(at.follow, self._monomials.values(v))
        left = torque + 2.0 * dot(at.pull, v) * rate - bend - dot(at.coupling, free)
        return left / (at.inertia - dot(at.coupling, solved))

    def damped(self, v: Array) -> Array:
        """Force of damping but for that of the static derivatives, shape (r, runs)."""
        return product(self._damping, v)

    def shape_force(self, stress: Array, q: Array) -> Array:
        """Force of a stress on the monomials, shape (r, runs)."""
        return self._monomials.force(stress, q)

    def moving(self, q: Array, a: Array) -> Array:
        """Mass that moves on its own times acceleration: the hub recoils."""
        at = self.place(q)
        return self.mass(a) - at.coupling * (dot(at.coupling, a) / at.inertia)

    def _mobile(self, q: Array) -> Array:
        at = self.place(q)
        return 1.0 - dot(at.coupling, self.mass_solve(at.coupling)) / at.inertia

    def sample(self, q: Array, v: Array, spin: Spin, store: tuple[str, ...]) -> Sample:
        """What is stored of an instant; kinetic energy is that of hub and structure."""
        found = super().sample(q, v, spin, store)
        if "energy" in store:
            at = self.place(q)
            carried = spin.rate * (0.5 * spin.rate * at.inertia + dot(at.coupling, v))
            found["energy"] = found["energy"].at[0].add(carried)
        return found
