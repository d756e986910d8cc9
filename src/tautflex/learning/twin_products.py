"""Products of coordinates, and forces of stresses on them, with slopes of their own.

Products pick coordinates by their numbers, whose slope by itself adds up number by number, slowly. Each of them is the
other's slope: with y the products and Y their derivatives, that of y(q) is ``Y(q)' y_bar``, and that of ``Y(q)' s`` is
``2 Y(q) f_bar`` after the stresses, ``Y(f_bar)' s`` after the coordinates.
"""

from __future__ import annotations

from typing import Any

from tautflex.batch.library import jax
from tautflex.batch.steps.products import Monomials
from tautflex.reduction.polynomial.monomials import pair_table

Array = jax.Array


class TwinProducts:
    """The m products of r coordinates; slopes backwards alone."""

    def __init__(self, count: int) -> None:
        plain, place = Monomials(count), pair_table(count)
        self.count = len(plain.first)

        def force(stress: Array, q: Array) -> Array:
            both = stress[place]
            # The derivative of a square counts twice.
            total = stress[place.diagonal()] * q
            for j in range(count):
                total = total + both[:, j] * q[j]
            return total

        self.values: Any = jax.custom_vjp(plain.values)
        self.rates: Any = jax.custom_vjp(plain.rates)
        self.force: Any = jax.custom_vjp(force)
        self.values.defvjp(lambda q: (plain.values(q), q), lambda q, back: (self.force(back, q),))
        self.rates.defvjp(
            lambda q, v: (plain.rates(q, v), (q, v)),
            lambda qv, back: (self.force(back, qv[1]), self.force(back, qv[0])),
        )
        self.force.defvjp(
            lambda stress, q: (force(stress, q), (stress, q)),
            lambda known, back: (self.rates(known[1], back), self.force(known[0], back)),
        )
