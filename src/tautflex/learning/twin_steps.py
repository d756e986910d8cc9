"""Central differences of the functional twin: the run is the last axis of every array, products are of matrices.

Step for step those of :mod:`tautflex.reduction.marching.free_hub.hub_steps` about one axis, in natural coordinates.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.batch.library import jax, jnp
from tautflex.learning.twin_constants import TwinConstants
from tautflex.learning.twin_monomials import TwinMonomials
from tautflex.reduction.polynomial.monomials import pair_table

Array = jax.Array


class Motion(NamedTuple):
    """Coordinates and hub of n runs.

    Parameters
    ----------
    q, v, a
        Coordinates, rates, accelerations, shape (r, n).
    angle, rate, acceleration, momentum
        Of the hub about its axis, shape (n,).
    coupling, inertia
        Momentum per rate of the coordinates, and moment of inertia, where these are; shapes (r, n) and (n,).
    """

    q: Array
    v: Array
    a: Array
    angle: Array
    rate: Array
    acceleration: Array
    momentum: Array
    coupling: Array
    inertia: Array


class Given(NamedTuple):
    """What acts over an interval.

    Parameters
    ----------
    load
        Force on the coordinates, left-hand side, shape (r, n).
    stress
        On the monomials, shape (m, n).
    torque
        On the hub without what forces gain in arm, shape (n,).
    arms
        That per coordinate, shape (r, n); None: there are none.
    """

    load: Array
    stress: Array
    torque: Array
    arms: Array | None


def _dot(x: Array, y: Array) -> Array:
    return jnp.sum(x * y, axis=0)


def _twice(matrix: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Products of a matrix with two arrays at once."""
    both = matrix @ jnp.concatenate([first, second], axis=1)
    return both[:, : first.shape[1]], both[:, first.shape[1] :]


class TwinSteps:
    """Steps of a twin; its numbers have the type ``kind``."""

    def __init__(self, c: TwinConstants, kind: Any) -> None:
        def taken(value: Any) -> Any:
            return None if value is None else jnp.asarray(value, dtype=kind)

        r = len(c.squares)
        self._c, self.monomials, self.kind = c, TwinMonomials(r), kind
        names = (
            "cubic", "viscous", "quadratic", "reach", "reach_follow", "spin", "spin_follow", "pull", "pull_follow",
            "square", "square_follow", "squares", "damping",
        )  # fmt: skip
        self._of: dict[str, Any] = {name: taken(getattr(c, name)) for name in names}
        self._pushed = bool(c.arms.any())
        acting = [c.load, c.stress, c.torque[:, None], *([c.arms] if self._pushed else [])]
        self._acting = taken(np.concatenate(acting, axis=1).T)
        # A centrifugal force of the coordinates alone is linear in them.
        slope = c.pull_follow[pair_table(r)]
        self._pull = taken(c.square + slope + np.diag(slope.diagonal()))

    def rest(self, runs: int) -> Motion:
        """Rest."""
        still, none = jnp.zeros((len(self._c.squares), runs), self.kind), jnp.zeros(runs, self.kind)
        return Motion(
            still, still, still, none, none, none, none, self._of["reach"][:, None] + still, self._c.inertia + none
        )

    def given(self, value: Array, before: Array) -> tuple[Given, Given]:
        """What values of the actuators do, shape (c, n), and by how much that differs from values before."""
        return tuple(self._split(part) for part in _twice(self._acting, value, value - before))  # type: ignore[return-value]

    def _split(self, rows: Array) -> Given:
        r, m = len(self._c.squares), len(self.monomials.first)
        arms = rows[r + m + 1 :] if self._pushed else None
        return Given(rows[:r], rows[r : r + m], rows[r + m], arms)

    def jump(self, at: Motion, change: Given) -> Motion:
        """Accelerations take up what acts anew."""
        force = change.load + self.monomials.force(change.stress, at.q)
        if self._c.driven:
            return at._replace(a=at.a - force)
        torque = self._torque(change, at.q) + _dot(at.coupling, force)
        rate = torque / (at.inertia - _dot(at.coupling, at.coupling))
        return at._replace(a=at.a - force - rate * at.coupling, acceleration=at.acceleration + rate)

    def turn(self, at: Motion, rate: Array, acceleration: Array) -> Motion:
        """Go on at a prescribed rate and acceleration; those of the coordinates take up the change of the latter."""
        push = (acceleration - at.acceleration) * at.coupling
        return at._replace(a=at.a - push, rate=rate, acceleration=acceleration)

    def _torque(self, given: Given, q: Array) -> Array:
        return given.torque if given.arms is None else given.torque + _dot(given.arms, q)

    def step(self, at: Motion, before: Array, given: Given, stiffness: Array, damping: Array) -> tuple[Motion, Array]:
        """One step, and the torque at its end; ``before`` is that at its start, shape (n,).

        Factors of linear stiffness and of damping have shape (n,).
        """
        c, of, h, force = self._c, self._of, self._c.step, self.monomials.force
        half = at.v + 0.5 * h * at.a
        q = at.q + h * half
        v = half + 0.5 * h * at.a
        y, rates = self.monomials.values(q), self.monomials.rates(q, v)
        stress = of["cubic"] @ y + given.stress
        if len(c.viscous):
            stress += damping * (of["viscous"].T @ (of["viscous"] @ rates))
        resisting = damping * of["damping"][:, None]
        known = stiffness * of["squares"][:, None] * q + given.load + resisting * half
        coupling, follow = of["reach"][:, None], jnp.zeros_like(y)
        if of["spin"] is not None:
            coupling = coupling + of["spin"] @ q
        if of["reach_follow"] is not None:
            follow = follow + of["reach_follow"][:, None]
        if of["spin_follow"] is not None:
            table, twice = of["spin_follow"], 2.0 * (at.rate + h * at.acceleration)
            through, late = _twice(table.T, q, twice * v)
            on_place, on_rate = _twice(table, y, rates)
            stress += late
            known -= twice * on_rate
            follow = follow + through
            coupling = coupling - on_place
        known += force(stress, q)
        if of["quadratic"] is not None:
            known += of["quadratic"] @ y
        coupling = coupling + force(follow, q)
        pull = of["pull"][:, None] + self._pull @ q
        on_y = of["pull_follow"][:, None]
        inertia = c.inertia - _dot(of["pull"][:, None] + of["square"] @ q, q) - _dot(of["pull"][:, None], q)
        if of["square_follow"] is not None:
            table = of["square_follow"]
            late, through = table @ y, table.T @ q
            pull = pull + late + force(through, q)
            inertia -= _dot(late, q) + _dot(through, y)
        inertia -= 2.0 * _dot(on_y, y)
        torque = self._torque(given, q)
        momentum = at.momentum + 0.5 * h * (before + torque)
        inverse = 1.0 / (1.0 + 0.5 * h * resisting)
        solved = inverse * coupling
        share, acceleration, a = inertia - _dot(coupling, solved), at.acceleration, at.a
        if c.driven:
            rate = at.rate + h * acceleration
            a = -inverse * (known + rate**2 * pull) - acceleration * solved
            v, angle = half + 0.5 * h * a, at.angle + 0.5 * h * (at.rate + rate)
            return Motion(q, v, a, angle, rate, acceleration, momentum, coupling, inertia), torque
        for _ in range(2):
            rate = (momentum - _dot(coupling, v)) / inertia
            frame = rate**2 * pull
            if of["spin"] is not None:
                frame = frame + of["spin"] @ (2.0 * rate * v)
            free = -inverse * (known + frame)
            bend = 2.0 * _dot(follow, self.monomials.values(v))
            acceleration = (torque + 2.0 * _dot(pull, v) * rate - bend - _dot(coupling, free)) / share
            a = free - acceleration * solved
            v = half + 0.5 * h * a
        rate = (momentum - _dot(coupling, v)) / inertia
        angle = at.angle + 0.5 * h * (at.rate + rate)
        return Motion(q, v, a, angle, rate, acceleration, momentum, coupling, inertia), torque

    def interval(self, at: Motion, given: Given, stiffness: Array, damping: Array) -> Motion:
        """Steps of an interval over which the same acts."""
        torque = self._torque(given, at.q)
        for _ in range(self._c.count):
            at, torque = self.step(at, torque, given, stiffness, damping)
        return at
