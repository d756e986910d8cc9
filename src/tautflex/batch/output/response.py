"""Runs as a pure function of their numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
from jax import lax

from tautflex.batch.equations.equation import STORED, EachRun, Sample, as_kind
from tautflex.batch.equations.full import FullPlant
from tautflex.batch.equations.inputs import BatchInputs
from tautflex.batch.equations.rate_history import Numbers, RateHistory, Spin, spin_of
from tautflex.batch.equations.reduced import ReducedPlant
from tautflex.batch.equations.reduced_equation import ReducedEquation
from tautflex.batch.equations.stability import reduced_falls
from tautflex.batch.library import jax
from tautflex.batch.steps.grid import SLACK, Instants, Steps, instants, spin_at, steps_of_run
from tautflex.batch.steps.implicit import static_start
from tautflex.solvers.transient.problem import TransientProblem

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
    fall
        Rate at which motion leaves an unstable start where neither damping nor Coriolis forces hold it back [1/s],
        else 0; None for the full model.
    hub
        Of a free hub: angle turned through [rad] and angular velocity [rad/s], shape (time, 2).
    """

    time: Array
    displacement: Array | None
    velocity: Array | None
    energy: Array | None
    converged: Array
    iterations: Array
    maneuver_end: Array
    fall: Array | None = None
    hub: Array | None = None


class March(Protocol):
    """Steps of a run, or of many."""

    equation: Any
    """What it solves."""
    block: int
    """Steps between two checks; reverse derivatives keep the state there and march through a block at a time again."""
    evaluations: tuple[float, ...]
    """Parts of a step after which the forces of its stages are evaluated."""

    def start(self, q: Array, v: Array, spin: Spin) -> Any:
        """State at t = 0; has ``q``, ``v``, ``alive`` and ``iterations``."""
        ...

    def motion(self, at: Any, spin: Spin) -> Spin:
        """What drives the run at a state: what is prescribed there, or what is part of the answer."""
        ...

    def beside(self, at: Any) -> Sample:
        """What is stored of a state beside the elastic motion."""
        ...

    def check(self, at: Any, first: Instants) -> Any:
        """What is looked at only now and then, before the step given."""
        ...

    def step(self, at: Any, step: Instants) -> Any:
        """One step."""
        ...


def response_function(
    plant: FullPlant | ReducedPlant,
    problem: TransientProblem,
    history: RateHistory,
    inputs: BatchInputs,
    velocity: Any,
    store: tuple[str, ...],
    march_of: Callable[[Any], March],
    single: bool = False,
) -> Callable[[Numbers, EachRun], Response]:
    """Pure function from numbers to the record of a run, or of many side by side, then with the runs as last axis.

    ``velocity`` is the initial one of the coordinates, shape (n,); ``march_of`` makes the steps from an equation.
    Starts are found in double precision, steps made in ``single`` where that is asked for.
    """
    kind = jnp.float32 if single else jnp.float64
    time_step, count = problem.time_step, problem.count
    # Blocks of equal length, so that few steps without length are added.
    longest = count + jax.eval_shape(history.edges, history.numbers).shape[0]

    def respond(numbers: Numbers, each: EachRun) -> Response:
        def turn(numbers: Numbers) -> Numbers:
            return {name: numbers[name] for name in history.numbers}

        equation = plant.equation(numbers, each, history, problem.coupling, problem.placed, inputs)
        march = march_of(equation.in_kind(kind) if isinstance(equation, ReducedEquation) and single else equation)
        block = -(-longest // -(-longest // march.block))
        shape = (plant.size,) if each.runs is None else (plant.size, each.runs)
        q, found, steady = jnp.zeros(shape), jnp.ones(shape[1:], bool), spin_of(jnp.zeros(shape[1:]), 0.0)
        if history.start is not None:
            start = history.start
            steady = spin_of(each(lambda numbers: jnp.asarray(start(turn(numbers)), dtype=float))(numbers), 0.0)
            q, found = static_start(equation, steady, _START_TOLERANCE, plant.pairs, shape)
        fall = reduced_falls(equation, plant.size, q, steady) if plant.side_by_side else None
        begin = each(lambda numbers: spin_at(history, turn(numbers), 0.0, SLACK * time_step))(numbers)
        v = jnp.asarray(velocity).reshape(-1, *(1 for _ in shape[1:])) + jnp.zeros(shape)
        q, v, begin = as_kind(kind, (q, v, begin))
        at = march.start(q, v, begin)
        at = at._replace(alive=at.alive & found)

        def sample(at: Any, after: Spin) -> Sample:
            record = march.equation.sample(at.q, at.v, march.motion(at, after), store) | march.beside(at)
            return {name: jnp.where(at.alive, part, jnp.nan) for name, part in record.items()}

        def step(at: Any, this: Instants) -> tuple[Any, Sample]:
            at = march.step(at, this)
            return at, sample(at, this.after)

        def march_block(at: Any, steps: Steps) -> Any:
            # What depends on time alone is found for all steps of a block at once.
            these = each(lambda numbers, steps: instants(history, turn(numbers), steps, time_step, march.evaluations))(
                numbers, steps
            )
            these = as_kind(kind, these)
            at = march.check(at, jax.tree.map(lambda part: part[0], these))
            return lax.scan(jax.checkpoint(step), at, these)

        steps, place = each(lambda numbers: steps_of_run(history.edges(turn(numbers)), time_step, count, block))(
            numbers
        )
        blocks = Steps(*(part.reshape(-1, block, *shape[1:]) for part in steps))
        first = sample(at, begin)
        last, record = lax.scan(jax.checkpoint(march_block), at, blocks)

        def on_grid(begin: Array, values: Array) -> Array:
            values = values.reshape(values.shape[0] * values.shape[1], *begin.shape)
            return jnp.concatenate([begin[None], each(lambda _, values, place: values[place])(numbers, values, place)])

        parts = {name: on_grid(begin, record[name]) for name, begin in first.items()}
        times = time_step * jnp.arange(count + 1)
        times = jnp.broadcast_to(times.reshape(-1, *(1 for _ in shape[1:])), (count + 1, *shape[1:]))
        end = each(lambda numbers: jnp.asarray(history.end(turn(numbers)), dtype=float))(numbers)
        stored = {name: parts.get(name) for name in (*STORED, "hub")}
        return Response(times, converged=last.alive, iterations=last.iterations, maneuver_end=end, fall=fall, **stored)

    return respond
