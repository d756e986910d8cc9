"""Stages of a step, and the state of a run, as compiled time stepping reads them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.numeric import Array, Indices
from tautflex.solvers.transient.methods.scheme import Combination, Method, Stage


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


class Work(NamedTuple):
    """What survives from step to step.

    Parameters
    ----------
    q, v, a, jerk, forces
        State at the last instant; ``forces`` are all but inertia.
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
        [steps, iterations, factorizations, force evaluations].
    """

    q: Array
    v: Array
    a: Array
    jerk: Array
    forces: Array
    passed: Array
    inverse: Array
    on_velocity: Array
    on_displacement: Array
    scale: Array
    sizes: Array
    counts: Indices


def new_work(size: int, tangents: tuple[int, ...] = (0,)) -> Work:
    """Zeros for ``size`` coordinates and stages with the given numbers of effective stiffnesses."""
    q, v, a, jerk, forces = (np.zeros(size) for _ in range(5))
    passed, inverse = np.zeros((len(tangents), 5, size)), np.zeros((max(tangents) + 1, size, size))
    on_velocity, on_displacement = (np.zeros((size, size)) for _ in range(2))
    scale, sizes, counts = np.zeros(1), np.zeros(len(inverse)), np.zeros(4, dtype=np.int64)
    return Work(q, v, a, jerk, forces, passed, inverse, on_velocity, on_displacement, scale, sizes, counts)


def stage_numbers(method: Method, size: float) -> tuple[StageNumbers, ...]:
    """Plain numbers of the stages of a step of a size [s]."""
    stages = zip(method.stages(size), method.tangents, strict=True)
    return tuple(_of_stage(stage, size, place, tangent) for place, (stage, tangent) in enumerate(stages))


def _of_stage(stage: Stage, size: float, place: int, tangent: int) -> StageNumbers:
    scheme = stage.scheme

    def triple(c: Combination) -> tuple[float, float, float]:
        return float(c.d), float(c.v), float(c.a)

    recalled = [(triple(v), triple(a)) for v, a in zip(stage.velocity, stage.acceleration, strict=True)]
    return StageNumbers(
        float(scheme.evaluation),
        float(scheme.weight),
        triple(scheme.inertia),
        triple(scheme.velocity),
        triple(scheme.end_displacement),
        triple(scheme.end_velocity),
        triple(scheme.end_acceleration),
        bool(scheme.average_stress),
        float(stage.share * size),
        float(size),
        place,
        tangent,
        np.array(recalled, dtype=float).reshape(-1, 2, 3),
    )


# What an explicit step needs of a scheme: frame terms at its end, and its size.
_NOTHING = (0.0, 0.0, 0.0)
EXPLICIT = StageNumbers(
    1.0, 1.0, _NOTHING, _NOTHING, _NOTHING, _NOTHING, _NOTHING, False, 0.0, 0.0, 0, 0, np.zeros((0, 2, 3))
)
