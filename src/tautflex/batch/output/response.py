"""Runs as a pure function of their numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
from jax import lax

from tautflex.batch.equations.equation import STORED, EachRun, Plant, Sample
from tautflex.batch.equations.rate_history import Course, Numbers, Spin, spin_of
from tautflex.batch.library import jax
from tautflex.batch.steps.grid import SLACK, Instants, Steps, instants, spin_at, steps_of_run
from tautflex.batch.steps.implicit import static_start
from tautflex.motion.coupling import Coupling
from tautflex.solvers.transient.probes import ProbeSet

Array = jax.Array

_START_TOLERANCE = 1e-10


class Response(NamedTuple):
    """Record of one run, NaN from where it failed; None is what was not asked for.

    Parameters
    ----------
    time
        Instants [s].
    displacement, velocity
        At the probes [m, m/s], shape (time, probe, 3).
    energy
        Kinetic and strain energy of the elastic motion [J], shape (time, 2).
    converged
        Whether every step met its tolerance.
    iterations
        Nonlinear iterations of all steps.
    maneuver_end
        [s].
    """

    time: Array
    displacement: Array | None
    velocity: Array | None
    energy: Array | None
    converged: Array
    iterations: Array
    maneuver_end: Array


class Walk(Protocol):
    """Steps of a run, or of many."""

    block: int
    """Steps between two checks; reverse derivatives keep the state there and walk through one block at a time again."""
    evaluations: tuple[float, ...]
    """Parts of a step after which the forces of its stages are evaluated."""

    def start(self, q: Array, v: Array, spin: Spin) -> Any:
        """State at t = 0; has ``q``, ``v``, ``alive`` and ``iterations``."""
        ...

    def check(self, at: Any, first: Instants) -> Any:
        """What is looked at only now and then, before the step given."""
        ...

    def step(self, at: Any, step: Instants) -> Any:
        """One step."""
        ...


def response_function(
    plant: Plant,
    course: Course,
    coupling: Coupling,
    probes: ProbeSet,
    time_step: float,
    count: int,
    velocity: Any,
    store: tuple[str, ...],
    walk_of: Callable[[Any], Walk],
) -> Callable[[Numbers, EachRun], Response]:
    """Pure function from numbers to the record of a run, or of many side by side.

    Parameters
    ----------
    plant
        Structure.
    course
        Maneuver.
    coupling
        Switches of the rotating-frame terms.
    probes
        Measuring points.
    time_step, count
        Grid.
    velocity
        Initial velocity of the coordinates, shape (n,).
    store
        Names of `STORED`.
    walk_of
        Makes the steps from an equation.

    Returns
    -------
    callable
        Its result has the runs as last axis.
    """
    # Blocks of equal length, so that few steps without length are added.
    longest = count + jax.eval_shape(course.breaks, course.numbers).shape[0]

    def respond(numbers: Numbers, each: EachRun) -> Response:
        def turn(numbers: Numbers) -> Numbers:
            return {name: numbers[f"maneuver.{name}"] for name in course.numbers}

        equation = plant.equation(numbers, each, course, coupling, probes)
        walk = walk_of(equation)
        block = -(-longest // -(-longest // walk.block))
        shape = (plant.size,) if each.runs is None else (plant.size, each.runs)
        q, found = jnp.zeros(shape), jnp.ones(shape[1:], bool)
        if course.start is not None:
            start = course.start
            rate = each(lambda numbers: jnp.asarray(start(turn(numbers)), dtype=float))(numbers)
            q, found = static_start(equation, spin_of(rate, 0.0), _START_TOLERANCE, plant.secants, shape)
        begin = each(lambda numbers: spin_at(course, turn(numbers), 0.0, SLACK * time_step))(numbers)
        at = walk.start(q, jnp.asarray(velocity).reshape(-1, *(1 for _ in shape[1:])) + jnp.zeros(shape), begin)
        at = at._replace(alive=at.alive & found)

        def sample(q: Array, v: Array, alive: Array, spin: Spin) -> Sample:
            record = equation.sample(q, v, spin, store)
            return {name: jnp.where(alive, part, jnp.nan) for name, part in record.items()}

        def step(at: Any, this: Instants) -> tuple[Any, Sample]:
            at = walk.step(at, this)
            return at, sample(at.q, at.v, at.alive, this.after)

        def walk_block(at: Any, steps: Steps) -> Any:
            # What depends on time alone is found for all steps of a block at once.
            these = each(lambda numbers, steps: instants(course, turn(numbers), steps, time_step, walk.evaluations))(
                numbers, steps
            )
            at = walk.check(at, jax.tree.map(lambda part: part[0], these))
            return lax.scan(jax.checkpoint(step), at, these)

        steps, place = each(lambda numbers: steps_of_run(course.breaks(turn(numbers)), time_step, count, block))(
            numbers
        )
        blocks = Steps(*(part.reshape(-1, block, *shape[1:]) for part in steps))
        first = sample(at.q, at.v, at.alive, begin)
        last, record = lax.scan(jax.checkpoint(walk_block), at, blocks)

        def on_grid(begin: Array, values: Array) -> Array:
            values = values.reshape(-1, *begin.shape)
            return jnp.concatenate([begin[None], each(lambda _, values, place: values[place])(numbers, values, place)])

        parts = {name: on_grid(begin, record[name]) for name, begin in first.items()}
        times = time_step * jnp.arange(count + 1)
        times = jnp.broadcast_to(times.reshape(-1, *(1 for _ in shape[1:])), (count + 1, *shape[1:]))
        end = each(lambda numbers: jnp.asarray(course.end(turn(numbers)), dtype=float))(numbers)
        stored = {name: parts.get(name) for name in STORED}
        return Response(times, converged=last.alive, iterations=last.iterations, maneuver_end=end, **stored)

    return respond
