"""Steps of equal size that also end on the discontinuities of each run's maneuver.

Every run of a batch takes the same number of steps: those of the grid and one for every discontinuity. A discontinuity
on the grid makes a step without length, which the integrators pass over.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp

from tautflex.batch.equations.rate_history import Numbers, RateHistory, Spin
from tautflex.batch.library import jax

Array = jax.Array

# Steps shorter than this part of the nominal one have no length.
SLACK = 1e-9


class Steps(NamedTuple):
    """Begin and length of the steps of one run [s], and whether the motion may jump at the end, shape (n,) each."""

    start: Array
    size: Array
    jump: Array


def steps_of_run(breaks: Any, time_step: float, count: int, multiple: int = 1) -> tuple[Steps, Array]:
    """Steps that reach ``count`` instants of the grid and all breaks between, which are in any order, shape (k,).

    Filled up to a multiple by steps without length. With them comes the number of the step that ends at each instant of
    the grid, shape (count,).
    """
    grid = time_step * jnp.arange(1, count + 1)
    end = time_step * count
    # Beyond the end nothing happens; the copy at the end is a step without length.
    inside = jnp.sort(jnp.clip(breaks, 0.0, end))
    fill = -(count + inside.size) % multiple
    edges = jnp.sort(jnp.concatenate([grid, inside, jnp.full(fill, end)]))
    start = jnp.concatenate([jnp.zeros(1), edges[:-1]])
    # One jump where discontinuities coincide.
    fresh = jnp.diff(inside, prepend=-1.0) > SLACK * time_step
    number = jnp.arange(inside.size) + jnp.sum(grid[None, :] <= inside[:, None], axis=1)
    jump = jnp.zeros(edges.size, bool).at[number].set(fresh)
    before = jnp.sum(inside[:, None] < grid[None, :], axis=0)
    return Steps(start, edges - start, jump), jnp.arange(count) + before


class Instants(NamedTuple):
    """What a step has to know, shape (n,) each: its length [s], whether it has any, and its motion.

    That is known where the forces of each stage are evaluated, and at the end: whether it may jump, by how much, and
    what is behind the jump.
    """

    size: Array
    real: Array
    spins: tuple[Spin, ...]
    jump: Array
    change: Spin
    after: Spin


def spin_at(history: RateHistory, numbers: Numbers, time: Any, inside: Any) -> Spin:
    """Motion of one run as arrays; ``inside`` tells the stretch."""
    return jax.tree.map(lambda part: jnp.asarray(part, dtype=float), history.spin(numbers, time, inside))


def instants(
    history: RateHistory, numbers: Numbers, steps: Steps, time_step: float, evaluations: tuple[float, ...]
) -> Instants:
    """Motion of one run at some of its steps; ``evaluations`` as of a `March`, ``time_step`` is the nominal one [s]."""
    slack = SLACK * time_step

    def of(start: Array, size: Array, jump: Array) -> Instants:
        real = size > slack
        edge = start + size
        middle = jnp.minimum(start + 0.5 * size, edge - slack)
        length = jnp.where(real, size, time_step)
        spins = tuple(spin_at(history, numbers, start + part * length, middle) for part in evaluations)
        after = spin_at(history, numbers, edge, edge + slack)
        change = jax.tree.map(jnp.subtract, after, spin_at(history, numbers, edge, middle))
        return Instants(size, real, spins, jump, change, after)

    return jax.vmap(of)(*steps)
