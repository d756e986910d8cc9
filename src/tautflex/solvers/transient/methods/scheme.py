r"""Implicit one-step integrators as data, and what an explicit one offers.

A method turns a step size h into the coefficients of a `StepScheme`. The unknown of a step is the displacement
increment ``d`` from the start of the step to the *evaluation instant* ``t + evaluation h``. With P(q, v, t) all forces
except inertia, every scheme solves

    M a_s + weight P(q + d, v_e, t_e) + (1 - weight) P_n = 0,

where a_s, v_e and the state at the end of the step are linear in d and in the start's velocity and acceleration.
Wilson-theta evaluates beyond the step (weight 1), generalized-alpha at its end (weight 1 - alpha_f), the
energy-conserving method at its middle with the average stress of the step, so one driver serves them all. Adding a
method = one small file with a frozen dataclass.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from tautflex.mechanics.dampings.damping import Damping
    from tautflex.mechanics.loads.inputs import InputSet
    from tautflex.motion.coupling import Coupling
    from tautflex.solvers.static.prestress import PrestressedState
    from tautflex.solvers.transient.explicit import ExplicitStepper


@dataclass(frozen=True)
class Combination:
    """Coefficients of (increment d, start velocity v, start acceleration a)."""

    d: float
    v: float
    a: float


@dataclass(frozen=True)
class StepScheme:
    """Coefficients of one implicit step of size h.

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
        Displacement increment at the end of the step.
    end_velocity, end_acceleration
        Velocity and acceleration at the end of the step.
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


class ImplicitMethod(Protocol):
    """A time-integration method."""

    @property
    def name(self) -> str:
        """Name in results."""
        ...

    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""
        ...


class ExplicitMethod(Protocol):
    """A method that makes its own steps."""

    @property
    def name(self) -> str:
        """Name in results."""
        ...

    def stepper(
        self, state: PrestressedState, damping: Damping, coupling: Coupling, inputs: InputSet | None = None
    ) -> ExplicitStepper:
        """Stepper of one run."""
        ...
