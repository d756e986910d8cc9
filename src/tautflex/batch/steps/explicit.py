"""Central differences on a batch of reduced models, step for step those of :mod:`tautflex.reduction.marching.steps`."""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from tautflex.batch.equations.equation import Sample, jump_of
from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.equations.reduced_equation import ReducedEquation
from tautflex.batch.library import jax
from tautflex.batch.steps.grid import Instants
from tautflex.batch.steps.products import norm

Array = jax.Array

# Parts of the stable step that a run may start with, and that it may use later; as in the single run.
START_SHARE, STABLE_SHARE = 1.0, 0.8
# Relative error of a force in single precision: some units in the last place.
_OWN_ROUND_OFF = 16.0 * float(np.finfo(jnp.float32).eps)


class ExplicitState(NamedTuple):
    """State between steps; forces are internal ones, given is the stress that acts on the monomials there."""

    q: Array
    v: Array
    a: Array
    forces: Array
    given: Array
    alive: Array
    iterations: Array


def followed(felt: Array, limit: Array, size: Array, half: Array, internal: Array) -> Array:
    """Whether steps can follow the stiffness that they have felt; single precision feels its own round-off, too."""
    if felt.dtype == jnp.float32:
        limit = limit + _OWN_ROUND_OFF * size * norm(half) * norm(internal)
    return felt <= limit * (1.0 + 1e-9) + 1e-300


class ExplicitMarch:
    """Steps: ``M a + (C + G) v + ... = 0`` at the end of each, the derivatives' damping at the predicted velocity."""

    # Steps between two looks at the stability.
    block = 32
    evaluations: tuple[float, ...] = (1.0,)

    def __init__(self, equation: ReducedEquation, time_step: float) -> None:
        self.equation, self._time_step = equation, time_step

    def start(self, q: Array, v: Array, spin: Spin) -> ExplicitState:
        """Acceleration that balances all forces at t = 0; runs whose step is above the stable one end here."""
        e = self.equation
        predicted = e.predicted(q, v, spin)
        forces = e.forces(q, v, spin, predicted)
        still = jax.tree.map(jnp.zeros_like, predicted)
        a, internal = e.mass_solve(-forces.total), e.internal(q, v, predicted)
        alive = e.follows(self._time_step, START_SHARE, q, still)
        return ExplicitState(q, v, a, internal, e.given(spin, q)[1], alive, jnp.zeros(q.shape[1:]))

    def motion(self, at: ExplicitState, spin: Spin) -> Spin:
        """It is prescribed."""
        return spin

    def beside(self, at: ExplicitState) -> Sample:
        """Nothing."""
        return {}

    def check(self, at: ExplicitState, first: Instants) -> ExplicitState:
        """Runs that have become too stiff, or too strongly damped, for their steps end."""
        e = self.equation
        stable = e.follows(self._time_step, STABLE_SHARE, at.q, e.predicted(at.q, at.v, first.spins[0]))
        return at._replace(alive=at.alive & stable)

    def step(self, at: ExplicitState, step: Instants) -> ExplicitState:
        """One step; a step without length only lets the motion jump."""
        e, h, spin = self.equation, step.size, step.spins[0]
        half = at.v + 0.5 * h * at.a
        q = at.q + h * half
        moving = half + 0.5 * h * at.a
        predicted = e.predicted(q, moving, spin)
        internal = e.internal(q, moving, predicted)
        given = e.given(spin, q)[1]
        # Stiffness that this very step has felt, less what is given anew, against what central differences can follow.
        felt = h * (jnp.sum(half * (internal - at.forces), axis=0) - e.power(given - at.given, q, half))
        limit = 4.0 * jnp.sum(half * e.mass(half), axis=0)
        alive = at.alive & (followed(felt, limit, h, half, internal) | ~step.real)
        a = e.end_acceleration(-internal - e.around(q, half, spin, predicted), 0.5 * h, spin)
        new = ExplicitState(q, half + 0.5 * h * a, a, internal, given, alive, at.iterations)
        old = at._replace(q=at.q + h * at.v, v=at.v + h * at.a, alive=alive)
        going = alive & step.real
        moved = jax.tree.map(lambda after, before: jnp.where(going, after, before), new, old)
        jump = jump_of(e, moved.q, moved.v, step)
        return moved._replace(a=moved.a + jump.acceleration)
