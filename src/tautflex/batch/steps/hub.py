"""Central differences on a batch of reduced models on a free hub of one axis.

Step for step those of :mod:`tautflex.reduction.marching.free_hub.hub_steps`: the hub's rate follows from its momentum.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp

from tautflex.batch.equations.equation import Sample
from tautflex.batch.equations.hub import HubEquation, dot
from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.library import jax
from tautflex.batch.steps.explicit import STABLE_SHARE, START_SHARE, followed
from tautflex.batch.steps.grid import Instants

Array = jax.Array


class HubBatchState(NamedTuple):
    """State between steps: that of `ExplicitState`, and the hub's angle, rate, acceleration, momentum and torque."""

    q: Array
    v: Array
    a: Array
    forces: Array
    given: Array
    alive: Array
    iterations: Array
    angle: Array
    rate: Array
    acceleration: Array
    momentum: Array
    torque: Array


class HubMarch:
    """Steps of coordinates and hub."""

    block = 32
    evaluations: tuple[float, ...] = (1.0,)

    def __init__(self, equation: HubEquation, time_step: float) -> None:
        self.equation, self._time_step = equation, time_step

    def motion(self, at: HubBatchState, spin: Spin) -> Spin:
        """It is part of the answer."""
        return spin._replace(rate=at.rate, acceleration=at.acceleration, square=at.rate**2)

    def beside(self, at: HubBatchState) -> Sample:
        """The hub: angle [rad] and rate [rad/s], shape (2, runs)."""
        return {"hub": jnp.stack([at.angle, at.rate])}

    def start(self, q: Array, v: Array, spin: Spin) -> HubBatchState:
        """Accelerations that balance all forces at t = 0; runs whose step is above the stable one end here."""
        e = self.equation
        load, stress = e.given(spin._replace(acceleration=0.0, square=0.0), q)
        internal = e.internal(q, v, (load, stress, load))
        rate = spin.rate + jnp.zeros_like(q[0])
        at, torque = e.place(q), e.torque(q, spin)
        force = internal + e.late_coriolis(q, v, rate) + e.coriolis(v, rate) + rate**2 * at.pull + e.damped(v) + load
        free, solved = e.mass_solve(-force), e.mass_solve(at.coupling)
        acceleration = e.hub_acceleration(at, v, rate, torque, free, solved)
        still = jnp.zeros_like(load), jnp.zeros_like(stress), jnp.zeros_like(load)
        return HubBatchState(
            q,
            v,
            free - acceleration * solved,
            internal,
            stress,
            e.follows(self._time_step, START_SHARE, q, still),
            jnp.zeros_like(rate),
            jnp.zeros_like(rate),
            rate,
            acceleration,
            at.inertia * rate + dot(at.coupling, v),
            torque + 0.0 * rate,
        )

    def check(self, at: HubBatchState, first: Instants) -> HubBatchState:
        """Runs that have become too stiff, or too strongly damped, for their steps end."""
        e = self.equation
        load, stress = e.given(first.spins[0]._replace(acceleration=0.0, square=0.0), at.q)
        stable = e.follows(self._time_step, STABLE_SHARE, at.q, (load, stress, load))
        return at._replace(alive=at.alive & stable)

    def step(self, at: HubBatchState, step: Instants) -> HubBatchState:
        """One step; a step without length only lets what acts jump."""
        e, h = self.equation, step.size
        spin = step.spins[0]._replace(acceleration=0.0, square=0.0)
        half = at.v + 0.5 * h * at.a
        q = at.q + h * half
        v = half + 0.5 * h * at.a
        load, given = e.given(spin, q)
        internal = e.internal(q, v, (load, given, load))
        place, torque = e.place(q), e.torque(q, spin)
        felt = h * (dot(half, internal - at.forces) - e.power(given - at.given, q, half))
        limit = 4.0 * (dot(half, e.mass(half)) - dot(place.coupling, half) ** 2 / place.inertia)
        alive = at.alive & (followed(felt, limit, h, half, internal) | ~step.real)
        solved = e.end_acceleration(place.coupling, 0.5 * h, None)
        known = internal + load + e.late_coriolis(q, v, at.rate + h * at.acceleration) + e.damped(half)
        momentum = at.momentum + 0.5 * h * (at.torque + torque)
        a, acceleration = at.a, at.acceleration
        for _ in range(2):
            rate = (momentum - dot(place.coupling, v)) / place.inertia
            free = e.end_acceleration(-(known + e.coriolis(v, rate) + rate**2 * place.pull), 0.5 * h, None)
            acceleration = e.hub_acceleration(place, v, rate, torque, free, solved)
            a = free - acceleration * solved
            v = half + 0.5 * h * a
        rate = (momentum - dot(place.coupling, v)) / place.inertia
        angle = at.angle + 0.5 * h * (at.rate + rate)
        new = HubBatchState(
            q, v, a, internal, given, alive, at.iterations, angle, rate, acceleration, momentum, torque + 0.0 * rate
        )
        going = alive & step.real
        moved = jax.tree.map(lambda after, before: jnp.where(going, after, before), new, at._replace(alive=alive))
        return jax.lax.cond(jnp.any(step.jump), self._jump, lambda moved, step: moved, moved, step)

    def _jump(self, at: HubBatchState, step: Instants) -> HubBatchState:
        """Accelerations take up what jumps at the end of a step."""
        e, change = self.equation, step.change._replace(acceleration=0.0, square=0.0)
        place, (load, stress) = e.place(at.q), e.given(change, at.q)
        torque, inside = e.torque(at.q, change), e.shape_force(stress, at.q)
        free, solved = e.mass_solve(-(load + inside)), e.mass_solve(place.coupling)
        left = torque - dot(place.coupling, free)
        acceleration = left / (place.inertia - dot(place.coupling, solved))
        after = at._replace(
            a=at.a + free - acceleration * solved,
            forces=at.forces + inside,
            given=at.given + stress,
            acceleration=at.acceleration + acceleration,
            torque=at.torque + torque,
        )
        return jax.tree.map(lambda new, old: jnp.where(step.jump, new, old), after, at)
