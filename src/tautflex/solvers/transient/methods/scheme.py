r"""Implicit integrators as data: a step is a tuple of stages.

A method turns a step size into stages that follow each other; most have one. A stage is a `StepScheme` over its share h
of the step. Its unknown is the displacement increment ``d`` from its start to the *evaluation instant*
``t + evaluation h``. With P(q, v, t) all forces except inertia, every scheme solves

    M a_s + weight P(q + d, v_e, t_e) + (1 - weight) P_n = 0,

where a_s, v_e and the state at the end of the stage are linear in d and in two vectors V and A: velocity and
acceleration at the start of the stage, or what the stage makes of all states that the step has passed. That is how a
stage remembers, and why those that solve its equation need not know that it does.
Wilson-theta evaluates beyond the step (weight 1), generalized-alpha at its end (weight 1 - alpha_f), the
energy-conserving method at its middle with the average stress of the step, Bathe's method in two stages, so one driver
serves them all. Adding a method = one small file with a frozen dataclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tautflex.errors import InputError
from tautflex.numeric import Array


@dataclass(frozen=True)
class Combination:
    """Coefficients of (increment d, velocity v, acceleration a)."""

    d: float
    v: float
    a: float


@dataclass(frozen=True)
class StepScheme:
    """Coefficients of one implicit stage of size h.

    Parameters
    ----------
    evaluation
        Evaluation instant in units of h.
    weight
        Weight of the forces at the evaluation instant; the rest weighs those at the start.
    inertia
        Acceleration a_s that enters the inertia force.
    velocity
        Velocity v_e at the evaluation instant.
    end_displacement
        Displacement increment at the end of the stage.
    end_velocity, end_acceleration
        Velocity and acceleration at the end of the stage.
    average_stress
        Internal forces of the average stress between the start and ``q + d / evaluation``, with gradients from their
        middle, instead of the internal forces at ``q + d``.
    tolerance
        Newton tolerance that the method needs to keep its promise.
    """

    evaluation: float
    weight: float
    inertia: Combination
    velocity: Combination
    end_displacement: Combination
    end_velocity: Combination
    end_acceleration: Combination
    average_stress: bool = False
    tolerance: float = 1e-6


@dataclass(frozen=True)
class Stage:
    """One solution of a step.

    Parameters
    ----------
    scheme
        Coefficients for the size of the stage.
    share
        Size of the stage over that of the step; the shares of a step add up to one.
    velocity, acceleration
        What the scheme takes for velocity V and acceleration A at its start: factors of all states that the step has
        passed, from its start to that of the stage, where d is the way back, ``q_state - q_start``. Empty: those of
        the start itself.
    """

    scheme: StepScheme
    share: float = 1.0
    velocity: tuple[Combination, ...] = ()
    acceleration: tuple[Combination, ...] = ()

    def recalled(self, states: Sequence[Any]) -> tuple[Any, Any]:
        """V and A from the states passed (anything with ``q``, ``v``, ``a``), the stage's start last."""
        start = states[-1]
        if not self.velocity:
            return start.v, start.a

        def mixed(factors: tuple[Combination, ...]) -> Any:
            return sum(c.d * (at.q - start.q) + c.v * at.v + c.a * at.a for c, at in zip(factors, states, strict=True))

        return mixed(self.velocity), mixed(self.acceleration)

    @property
    def factors(self) -> Array:
        """The factors that make V and A, shape (2, state, 3); without any state those of the start itself."""
        rows = [[(c.d, c.v, c.a) for c in row] for row in (self.velocity, self.acceleration)]
        return np.array(rows).reshape(2, len(self.velocity), 3)


class Method(ABC):
    """Implicit time-integration method; a frozen dataclass whose fields are its options."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name in results."""

    @abstractmethod
    def stages(self, step: float) -> tuple[Stage, ...]:
        """Stages of a step of a size [s]; plain arithmetic of it."""

    @property
    def tolerance(self) -> float:
        """Newton tolerance that keeps the method's promise."""
        return min(stage.scheme.tolerance for stage in self.stages(1.0))

    @property
    def average_stress(self) -> bool:
        """Whether a stage takes the average stress of its start and end."""
        return any(stage.scheme.average_stress for stage in self.stages(1.0))

    @property
    def tangents(self) -> tuple[int, ...]:
        """Number of the effective stiffness of each stage, from 0; stages with the same one share its factors."""
        numbers, found = list[int](), list[tuple[float, float]]()
        for scheme in (stage.scheme for stage in self.stages(1.0)):
            factors = scheme.inertia.d, scheme.velocity.d
            same = [n for n, other in enumerate(found) if np.allclose(factors, other, rtol=1e-9, atol=0.0)]
            numbers.append(same[0] if same else len(found))
            found += [] if same else [factors]
        return tuple(numbers)


class OneStageMethod(Method):
    """Implicit method that solves once in a step."""

    @abstractmethod
    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""

    def stages(self, step: float) -> tuple[Stage, ...]:
        """The one stage of a step of a size [s]."""
        return (Stage(self.scheme(step)),)


class _Instant(NamedTuple):
    """State of an oscillator."""

    q: float
    v: float
    a: float


def check_stages(method: Method) -> None:
    """Raise InputError where the stages of a method do not make a step."""
    stages = method.stages(1.0)
    shares = [stage.share for stage in stages]
    if not stages or min(shares) <= 0.0 or abs(sum(shares) - 1.0) > 1e-12:
        raise InputError(f"method: expected stages whose shares are positive and add up to 1, got {shares}")
    for number, stage in enumerate(stages, 1):
        sizes = {len(stage.velocity), len(stage.acceleration)}
        if sizes not in ({0}, {number}):
            raise InputError(
                f"method: expected factors of {number} states (or none) for V and A of stage {number}, "
                f"got {len(stage.velocity)} and {len(stage.acceleration)}"
            )
        if len(stages) > 1 and stage.scheme.weight != 1.0:
            raise InputError(f"method: expected weight 1 in all of several stages, got {stage.scheme.weight!r}")


def amplification(method: Method, phase: float, damping: float = 0.0) -> Array:
    """Matrix that a step multiplies (x, h x', h^2 x'') of a linear oscillator by, shape (3, 3).

    Parameters
    ----------
    method
        Implicit method.
    phase
        Angular frequency times step [rad].
    damping
        Damping ratio.
    """
    spring, dashpot = phase**2, 2.0 * damping * phase
    columns = []
    for start in np.eye(3):
        passed = [_Instant(*(float(x) for x in start))]
        for stage in method.stages(1.0):
            at, scheme = passed[-1], stage.scheme
            v, a = stage.recalled(passed)

            def value(part: Combination, v: float = v, a: float = a) -> float:
                return part.v * v + part.a * a

            forces = spring * at.q + dashpot * at.v
            known = value(scheme.inertia) + scheme.weight * (spring * at.q + dashpot * value(scheme.velocity))
            known += (1.0 - scheme.weight) * forces
            d = -known / (scheme.inertia.d + scheme.weight * (spring + dashpot * scheme.velocity.d))
            parts = (scheme.end_displacement, scheme.end_velocity, scheme.end_acceleration)
            move, velocity, acceleration = (part.d * d + value(part) for part in parts)
            passed.append(_Instant(at.q + move, velocity, acceleration))
        columns.append([passed[-1].q, passed[-1].v, passed[-1].a])
    return np.array(columns).T
