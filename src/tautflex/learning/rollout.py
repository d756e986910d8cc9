"""Policies on the functional twin: actions, rollouts, and their slope over a truncated horizon."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from tautflex.batch.library import jax, jnp
from tautflex.control.tasks.policy import network
from tautflex.learning.functional import FunctionalTwin, Params, TwinState
from tautflex.numeric import Array as Numbers

Array = jax.Array
Layers = tuple[tuple[Any, Any], ...]

# What an untrained network adds to the law in front of it, in parts of the limits.
_START = 1e-2


class Course(NamedTuple):
    """Where n episodes stand: their state, what the policy sees, features of its linear law, and its network's part."""

    state: TwinState
    seen: Array
    features: Array
    held: Array


def start_layers(key: Array, sizes: Sequence[int], kind: Any) -> Layers:
    """Weights and biases of a network that commands next to nothing; ``sizes`` from what it sees to its commands."""
    layers = []
    for number, (inner, outer) in enumerate(pairwise(sizes)):
        size = float((_START if number == len(sizes) - 2 else 1.0) / np.sqrt(inner))
        weights = size * jax.random.normal(jax.random.fold_in(key, number), (outer, inner), kind)
        layers.append((weights, jnp.zeros(outer, kind)))
    return tuple(layers)


class Rollouts:
    """Rollouts of a policy: a network behind a linear law.

    Parameters
    ----------
    twin
        The environment.
    gain
        Linear law in parts of the limits, shape (commands, z).
    keep
        Of the lag behind the network, see `network`.
    """

    def __init__(self, twin: FunctionalTwin, gain: Numbers, keep: float) -> None:
        self._twin, self._gain, self._keep = twin, jnp.asarray(gain, twin.kind), keep

    def begin(self, key: Array, params: Params) -> Course:
        """Begin episodes with parameters of shape (n,)."""
        state, seen = self._twin.reset(key, params)
        features = self._twin.features(state, state.measured, state.measured, params)
        return Course(state, seen, features, jnp.zeros_like(state.action))

    def run(self, layers: Layers, key: Array, course: Course, params: Params, steps: int) -> tuple[Course, Any]:
        """Go on for some intervals: where episodes stand then, and rewards and costs, shape (steps, n) each."""
        twin, columns = self._twin, tuple((weights, bias[:, None]) for weights, bias in layers)

        @jax.checkpoint
        def one(course: Course, drawn: Array) -> tuple[Course, tuple[Array, Array]]:
            action, held = network(columns, self._gain, course.features, course.seen, course.held, self._keep, jnp)
            before = course.state
            state, seen, reward, _, _, info = twin.step_drawn(drawn, before, action, params)
            features = twin.features(state, state.measured, before.measured, params)
            return Course(state, seen, features, held), (reward, info["cost"])

        runs = len(course.state.place)
        drawn = jax.vmap(lambda own: twin.draws(own, runs))(jax.random.split(key, steps))
        return jax.lax.scan(one, course, drawn)

    def slope(
        self, layers: Layers, key: Array, course: Course, params: Params, steps: int
    ) -> tuple[Array, Layers, Course]:
        """Mean reward over a horizon, its slope after the layers, and where the episodes stand at its end.

        What comes before the horizon has no slope.
        """

        def lost(layers: Layers) -> tuple[Array, Course]:
            end, (rewards, _) = self.run(layers, key, course, params, steps)
            return jnp.mean(rewards), end

        (mean, end), slope = jax.value_and_grad(lost, has_aux=True)(layers)
        return mean, slope, jax.lax.stop_gradient(end)

    def cost(self, layers: Layers, key: Array, params: Params) -> Array:
        """Mean cost of whole episodes, shape (n,); that of one that failed is the worst."""
        course, worst = self.begin(jax.random.fold_in(key, 0), params), self._twin.arena.task.worst_cost
        _, (_, costs) = self.run(layers, jax.random.fold_in(key, 1), course, params, self._twin.steps)
        return jnp.where(jnp.any(costs >= worst, axis=0), worst, jnp.mean(costs, axis=0))
