"""What inputs do to a reduced model, per unit of each, for many runs."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from tautflex.batch.library import jax
from tautflex.batch.steps.products import product
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.reduction.inputs import ReducedInputs
from tautflex.reduction.polynomial.strains import stress_loads
from tautflex.solvers.transient.probes import ProbeSet

Array = jax.Array


class InputTerms(NamedTuple):
    """Of n inputs; forces are on the left-hand side.

    Parameters
    ----------
    force
        Force on the coordinates, shape (r, n).
    stress
        Stress on the monomials, shape (m, n), or (m, n, runs).
    look
        Readings of what the structure answers at once, shape (reading, n).
    storing, rest, square
        What stresses add to the strain energy: with monomials, (m, n), coordinates, (r, n), and each other, (n, n).
    """

    force: Any
    stress: Any
    look: Any
    storing: Any
    rest: Any
    square: Any

    @classmethod
    def of(cls, reduced: ReducedInputs, on_monomials: Any, probes: ProbeSet) -> InputTerms:
        """From those of a reduced model; ``on_monomials`` is what forces do to what follows these, (n, m[, runs])."""
        given: InputSet = reduced.given
        count, places = len(given.labels), np.flatnonzero(given.stressing)

        def widened(part: Any) -> Any:
            whole = np.zeros((part.shape[0], count))
            whole[:, places] = part
            return whole

        square = np.zeros((count, count))
        if len(places):
            own = stress_loads(given.system, reduced.columns) @ reduced.answers.T
            square[np.ix_(places, places)] = own
        storing, rest = widened(reduced.stress.T), widened(reduced.beta.T)
        through = jnp.swapaxes(on_monomials, 0, 1)
        given_stress = storing - reduced.slopes
        stress = given_stress.reshape(*storing.shape, *(1 for _ in through.shape[2:])) - through
        return cls(rest - reduced.load, stress, widened(probes.map @ reduced.answers.T), storing, rest, square)

    def of_numbers(self, u: Array) -> tuple[Array, Array]:
        """Force on the coordinates, shape (r, runs), and stress on the monomials, (m, runs), of numbers (n, runs)."""
        return jnp.asarray(self.force) @ u, product(self.stress, u)

    def stored(self, q: Array, y: Array, u: Array) -> Array:
        """What stresses add to the strain energy [J], shape (runs,)."""
        through = jnp.asarray(self.storing.T) @ y + jnp.asarray(self.rest.T) @ q + 0.5 * jnp.asarray(self.square) @ u
        return jnp.sum(u * through, axis=0)
