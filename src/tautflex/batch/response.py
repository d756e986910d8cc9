"""One run as a pure function of its numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
from jax import lax

from tautflex.batch.course import Course, Numbers, spin_of
from tautflex.batch.equation import STORED, Equation, Plant, Sample
from tautflex.batch.grid import SLACK, Steps, steps_of_run
from tautflex.batch.implicit import static_start
from tautflex.batch.library import jax
from tautflex.motion.coupling import Coupling
from tautflex.solvers.probes import ProbeSet

Array = jax.Array

# Reverse derivatives keep the state at the ends of blocks of so many steps and walk through one block at a time again.
_BLOCK = 64
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
    """Steps of one run."""

    def start(self, q: Array, v: Array) -> Any:
        """State at t = 0; has ``q``, ``v``, ``alive`` and ``iterations``."""
        ...

    def step(self, at: Any, step: Steps) -> Any:
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
    walk_of: Callable[[Equation, Numbers], Walk],
) -> Callable[[Numbers], Response]:
    """Pure function from numbers to the record of a run.

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
        Makes the steps of a run from its equation and the numbers of its maneuver.

    Returns
    -------
    callable
    """

    def respond(numbers: Numbers) -> Response:
        turn = {name: numbers[f"maneuver.{name}"] for name in course.numbers}
        equation = plant.equation(numbers, course, coupling, probes)
        walk = walk_of(equation, turn)
        q, found = jnp.zeros(plant.size), jnp.ones((), bool)
        if course.start is not None:
            q, found = static_start(equation, spin_of(course.start(turn), 0.0), _START_TOLERANCE, plant.secants)
        at = walk.start(q, jnp.asarray(velocity))
        at = at._replace(alive=at.alive & found)

        def sample(at: Any, time: Array, after: Array) -> Sample:
            record = equation.sample(at.q, at.v, course.spin(turn, time, after), store)
            return {name: jnp.where(at.alive, part, jnp.nan) for name, part in record.items()}

        def step(at: Any, this: Steps) -> tuple[Any, Sample]:
            at = walk.step(at, this)
            edge = this.start + this.size
            return at, sample(at, edge, edge + SLACK * time_step)

        block = min(_BLOCK, count)
        steps, place = steps_of_run(course.breaks(turn), time_step, count, block)
        blocks = Steps(*(part.reshape(-1, block) for part in steps))
        first = sample(at, jnp.zeros(()), jnp.asarray(SLACK * time_step))
        last, record = lax.scan(jax.checkpoint(lambda at, some: lax.scan(jax.checkpoint(step), at, some)), at, blocks)
        parts = {
            name: jnp.concatenate([begin[None], record[name].reshape(-1, *begin.shape)[place]])
            for name, begin in first.items()
        }
        times = time_step * jnp.arange(count + 1)
        end = jnp.asarray(course.end(turn))
        stored = {name: parts.get(name) for name in STORED}
        return Response(times, converged=last.alive, iterations=last.iterations, maneuver_end=end, **stored)

    return respond
