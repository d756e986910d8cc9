"""Monomials of the functional twin, whose slopes go back by the same formulas."""

from __future__ import annotations

from typing import Any

from tautflex.batch.library import jax, jnp
from tautflex.batch.steps.products import Monomials
from tautflex.reduction.polynomial.monomials import pair_table

Array = jax.Array


def _settled(x: Array) -> Array:
    """Numbers that are computed once: the compiler computes others again wherever they are used, but for products."""
    return jnp.matmul(jnp.eye(len(x), dtype=x.dtype), x, precision="highest")


class TwinMonomials(Monomials):
    """`Monomials` with slopes in reverse mode alone.

    With Y = dy/dq, ``rates(q, v) = Y(q) v`` and ``force(s, q) = Y(q)' s`` are each other's transposes, and both are
    linear in q: ``force(s, q) v = s rates(q, v)``. JAX by itself would scatter where these gather.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self._place = pair_table(count)
        self._values: Any = jax.custom_vjp(super().values)
        self._values.defvjp(lambda q: (self.values(q), q), lambda q, g: (self._gather(g, q),))
        self._rates: Any = jax.custom_vjp(super().rates)
        self._rates.defvjp(
            lambda q, v: (self.rates(q, v), (q, v)), lambda at, g: (self._gather(g, at[1]), self._gather(g, at[0]))
        )
        self._force: Any = jax.custom_vjp(lambda stress, q: _settled(self._gather(stress, q)))
        self._force.defvjp(lambda stress, q: (self.force(stress, q), (stress, q)), self._back)

    def _back(self, at: tuple[Array, Array], slope: Array) -> tuple[Array, Array]:
        (stress, q), slope = at, _settled(slope)
        return super().rates(q, slope), self._gather(stress, slope)

    def _gather(self, stress: Array, q: Array) -> Array:
        both = stress[self._place]
        # The derivative of a square counts twice; numbers of one type stay so.
        total = stress[self._place.diagonal()] * q
        for j in range(len(q)):
            total = total + both[:, j] * q[j]
        return total

    def values(self, q: Array) -> Array:
        """Monomials, shape (m, runs)."""
        found: Array = self._values(q)
        return found

    def rates(self, q: Array, v: Array) -> Array:
        """Their rates, shape (m, runs)."""
        found: Array = self._rates(q, v)
        return found

    def force(self, stress: Array, q: Array) -> Array:
        """Force ``Y' s`` on the coordinates of stresses that work on the monomials, shape (r, runs)."""
        found: Array = self._force(stress, q)
        return found
