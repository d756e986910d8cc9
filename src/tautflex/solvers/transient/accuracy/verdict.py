"""How far a run can be trusted: its time error and energy balance, in numbers and in words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tautflex.motion.hub import FreeHub
from tautflex.solvers.plausibility import FEW_STEPS, short_motions
from tautflex.solvers.transient.accuracy.time_error import ErrorSum, rounded_down
from tautflex.solvers.transient.adaptive import error_constant
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import TransientProblem

# Central differences turn a vibration by (phase)^3 / 24 too far in a step.
_EXPLICIT_CONSTANT = 1.0 / 24.0
# Limits of the phase at which a method's constant is taken [rad].
_PHASES = 0.01, 0.5
# Part of the largest energy that a method may take out or feed in without a word.
_NOTABLE = 0.01
# Part of the energy of the prestress below which nothing moves but round-off.
_STILL = 1e-20


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of a run.

    Parameters
    ----------
    error
        Estimated time error over the largest displacement; NaN where it was not asked for.
    balance
        Energy balance [J].
    warnings
        What the user should know.
    """

    error: float
    balance: Mapping[str, float]
    warnings: list[str]

    @property
    def attributes(self) -> dict[str, Any]:
        """What the record keeps of it."""
        return {"time_error": self.error, "energy_balance": json.dumps(self.balance)}


def judge(
    problem: TransientProblem, errors: ErrorSum | None, balance: Mapping[str, float], energy: float, mean_step: float
) -> Accuracy:
    """Accuracy of a run of any plant from what its steps summed up.

    Parameters
    ----------
    problem
        What was asked.
    errors
        Its local errors; None where the estimate is off.
    balance
        Its energy balance [J].
    energy
        Largest energy of the elastic motion [J].
    mean_step
        Mean size of its steps [s].
    """
    method, warnings, error = problem.method, _about_maneuver(problem), float("nan")
    missed = errors is not None and errors.missed > 0.0
    if not missed and energy + abs(balance["damping"]) <= _STILL * _stored(problem):
        return Accuracy(error if errors is None else 0.0, balance, warnings)
    if errors is not None:
        phase = float(np.clip(errors.frequency * mean_step, *_PHASES))
        error = errors.value(error_constant(method, phase) if isinstance(method, Method) else _EXPLICIT_CONSTANT)
        warnings += errors.warnings(error, mean_step)
    return Accuracy(error, balance, warnings + _about_energy(problem, balance, energy))


def _stored(problem: TransientProblem) -> float:
    """Size of the strain energy that the prestress has, by the stiffest direction of each element [J]."""
    total, system = 0.0, problem.state.system
    for block, stress in zip(system.blocks, system.initial_stress, strict=True):
        stiffest = np.abs(block.elasticity).max(axis=(1, 2))
        square = np.einsum("ns,ns->n", stress, stress)
        total += 0.5 * float(block.measure @ np.divide(square, stiffest, out=np.zeros_like(square), where=stiffest > 0))
    return total


def _about_maneuver(problem: TransientProblem) -> list[str]:
    if isinstance(problem.maneuver, FreeHub) or problem.adaptive is not None:
        return []
    shortest = min(short_motions(problem.maneuver, problem.time_step), default=None)
    if shortest is None:
        return []
    return [
        f"the maneuver of {shortest:g} s has fewer than {FEW_STEPS} steps of {problem.time_step:g} s: the run may "
        f"have missed it; set time_step = {rounded_down(shortest / 20.0):.2g} s or less"
    ]


def _about_energy(problem: TransientProblem, balance: Mapping[str, float], largest: float) -> list[str]:
    # Damping has taken what the elastic motion had beside the energy of its largest instant.
    taken, damped = balance["method"], balance["damping"]
    energy = largest + max(damped, 0.0)
    if damped < -_NOTABLE * energy:
        return [
            f"the damping of the steps put in {-damped:.3g} J: motion that is too stiff or too much damped for steps "
            f"of {problem.time_step:g} s overshoots or dies inside one, so that 'damping' and 'method' in the energy "
            "balance mean nothing, only their sum does; take a smaller time_step, GeneralizedAlpha(0.8) "
            "('generalized-alpha'), or less damping of the stiffest elements (beta by kind)"
        ]
    # What damping takes more than is fed in does not grow: behind a jump of the forces both are of the first order.
    if not abs(taken) > _NOTABLE * energy > 0.0 or -damped < taken < 0.0:
        return []
    what, why = ("took out", "its damping is numerical") if taken > 0.0 else ("fed in", "it is not stable here")
    return [
        f"the method {what} {abs(taken):.3g} J by itself, {abs(taken) / energy:.1%} of all that the elastic motion "
        f"had: {why}; take a smaller time_step than {problem.time_step:g} s, or EnergyConserving() "
        "('energy-conserving')"
    ]
