"""Stages of a step, and the state of a run, as compiled time stepping reads them."""

from __future__ import annotations

from dataclasses import astuple
from typing import NamedTuple

import numpy as np

from tautflex.numeric import Array, Indices
from tautflex.solvers.transient.methods.scheme import Method, Stage


class StageNumbers(NamedTuple):
    """A `Stage` as plain numbers.

    Parameters
    ----------
    evaluation, weight, inertia, velocity, end_displacement, end_velocity, end_acceleration, average
        Of its `StepScheme`; triples multiply (increment, velocity, acceleration).
    size
        Of the stage [s].
    step
        Of the whole step [s].
    place, tangent
        Number of the stage, and of its effective stiffness.
    recalled
        Factors of (way back, velocity, acceleration) of every state passed in velocity and acceleration at its start,
        shape (state, 2, 3); (0, 2, 3): those of the start itself.
    """

    evaluation: float
    weight: float
    inertia: tuple[float, float, float]
    velocity: tuple[float, float, float]
    end_displacement: tuple[float, float, float]
    end_velocity: tuple[float, float, float]
    end_acceleration: tuple[float, float, float]
    average: bool
    size: float
    step: float
    place: int
    tangent: int
    recalled: Array


LOOKED = 4


class Work(NamedTuple):
    """What survives from step to step.

    Parameters
    ----------
    q, v, a, jerk, forces
        State at the last instant, rows of ``state``; ``forces`` are all but inertia.
    state
        Shape (5, r).
    passed
        State at the start of every stage of this step as it was last set, shape (stage, 5, r); of one stage it is not.
    inverse
        Inverses of effective stiffnesses (or of an explicit method's effective mass), shape (tangent, r, r).
    on_velocity, on_displacement
        Matrices of the frame in this step, shape (r, r).
    scale
        Largest force scale so far, shape (1,).
    sizes
        Size of the step that each inverse belongs to [s], 0: none, shape (tangent,).
    counts
        [steps, iterations, factorizations, force evaluations, steps since a look at an explicit method's stability].
    """

    q: Array
    v: Array
    a: Array
    jerk: Array
    forces: Array
    state: Array
    passed: Array
    inverse: Array
    on_velocity: Array
    on_displacement: Array
    scale: Array
    sizes: Array
    counts: Indices


def new_work(size: int, tangents: tuple[int, ...] = (0,)) -> Work:
    """Zeros for ``size`` coordinates and stages with the given numbers of effective stiffnesses."""
    state, passed = np.zeros((5, size)), np.zeros((len(tangents), 5, size))
    inverse, (on_velocity, on_displacement) = np.zeros((max(tangents) + 1, size, size)), np.zeros((2, size, size))
    scale, sizes, counts = np.zeros(1), np.zeros(len(inverse)), np.zeros(5, dtype=np.int64)
    q, v, a, jerk, forces = state
    return Work(q, v, a, jerk, forces, state, passed, inverse, on_velocity, on_displacement, scale, sizes, counts)


def stage_numbers(method: Method, size: float) -> tuple[StageNumbers, ...]:
    """Plain numbers of the stages of a step of a size [s]."""
    stages = zip(method.stages(size), method.tangents, strict=True)
    return tuple(_of_stage(stage, size, place, tangent) for place, (stage, tangent) in enumerate(stages))


def _of_stage(stage: Stage, size: float, place: int, tangent: int) -> StageNumbers:
    evaluation, weight, *combinations, average, _ = astuple(stage.scheme)
    inertia, velocity, place_end, velocity_end, acceleration_end = (
        (float(d), float(v), float(a)) for d, v, a in combinations
    )
    recalled = [(astuple(v), astuple(a)) for v, a in zip(stage.velocity, stage.acceleration, strict=True)]
    return StageNumbers(
        float(evaluation),
        float(weight),
        inertia,
        velocity,
        place_end,
        velocity_end,
        acceleration_end,
        bool(average),
        float(stage.share * size),
        float(size),
        place,
        tangent,
        np.array(recalled, dtype=float).reshape(-1, 2, 3),
    )
