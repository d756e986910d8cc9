"""Model predictive control within limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.sparse import csc_matrix

from tautflex import checks
from tautflex.control.estimate import Estimator, any_estimator, steady_reference
from tautflex.control.law import ControlLaw, own_memory
from tautflex.control.laws.lqr import of_all
from tautflex.control.laws.optimal import Filtered
from tautflex.control.riccati import regulator
from tautflex.control.signals import LoopSpec, Reference, check_numbers, labelled
from tautflex.control.spillover import refuse_spillover
from tautflex.errors import InputError, MissingExtraError
from tautflex.numeric import Array, Indices
from tautflex.text import brief

# Of the solver, relative and absolute, in commands over their limits.
_ACCURACY = 1e-8


class Program(NamedTuple):
    """Quadratic program over the next commands, in parts of their limits.

    Parameters
    ----------
    solver
        OSQP, set up; every solution starts from what the memory holds.
    linear
        Linear cost per deviation of the state, shape (commands of all steps, state).
    limits
        Of one step's commands, shape (m,).
    state, command
        What follows the reference, shapes (state, 3 axes) and (m, 3 axes).
    """

    solver: Any
    linear: Array
    limits: Array
    state: Array
    command: Array


class MPCMemory(NamedTuple):
    """What a sample needs: estimator and program, expected state, last command, and the last plan, (plan, dual)."""

    estimator: Estimator
    program: Program
    used: Indices
    total: int
    expected: Array
    last: Array
    plan: Array
    dual: Array


@dataclass(frozen=True)
class MPC(Filtered, ControlLaw):
    """Model predictive control: every sample has a plan of least cost within limits, whose first step is done.

    The cost is that of `LQG` over the horizon, and beyond it that of the regulator without limits, so that the two
    agree where no limit is met [Rawlings, Mayne & Diehl 2017]. The state is told by the sensors if they tell all of
    it, else by the Kalman filter. OSQP solves the program (extra ``control``). Like them it is refused where, without
    limits, it makes modes unstable that it does not know; what these do while a limit is met is not looked at.

    Parameters
    ----------
    limits
        Name of an actuator with an effort -> largest command of either sign, > 0, in its unit.
    horizon
        Steps of the plan, >= 1.

    Raises
    ------
    InputError
        If a number is out of range.
    MissingExtraError
        If OSQP is not installed.
    """

    limits: Mapping[str, float] | None = None
    horizon: int = 20
    __repr__ = brief

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.whole("horizon", self.horizon, 1)
        check_numbers("limits", self.limits)

    def start(self, spec: LoopSpec) -> MPCMemory:
        """Set the program up."""
        plant, used = self.design(spec)
        given = labelled("limits", self.limits or {}, plant.inputs)
        for k, label in enumerate(plant.inputs):
            if k not in given:
                raise InputError(f"limits: expected a limit of every command with an effort, got none of {label!r}")
        estimator = any_estimator(plant, spec, self.noise)
        known, m = estimator.plant, len(used)
        sizes = np.array([given[k] for k in range(m)])
        weights = self.weights(known)
        gain, final = regulator(known, weights)
        state, command = steady_reference(plant, known, self.feedforward)
        # Where no limit is met the law is the regulator.
        free_law = of_all(estimator.with_gain(gain, gain @ state + command), used, len(spec.commanded))
        refuse_spillover(spec, free_law, type(self).__name__, "modes", "raise modes, or the tolerances")
        # x of steps 0 to N from the first x and all commands, in parts of their limits.
        free, forced, moved = [np.eye(len(known.A))], [np.zeros((len(known.A), self.horizon * m))], known.B * sizes
        for step in range(self.horizon):
            free.append(known.A @ free[-1])
            following = known.A @ forced[-1]
            following[:, step * m : (step + 1) * m] += moved
            forced.append(following)
        states, pushed = np.concatenate(free), np.concatenate(forced)
        cost = block_diag(*[weights.Q] * self.horizon, final)
        cross = np.zeros((len(states), self.horizon * m))
        cross[: -len(known.A)] = np.kron(np.eye(self.horizon), weights.N * sizes)
        each = np.kron(np.eye(self.horizon), weights.R * np.outer(sizes, sizes))
        whole = pushed.T @ cost @ pushed + pushed.T @ cross + cross.T @ pushed + each
        scale = float(np.abs(whole).max())
        program = Program(
            _solver(whole / scale),
            (pushed.T @ cost + cross.T) @ states / scale,
            sizes,
            state,
            command,
        )
        none = np.zeros(self.horizon * m)
        return MPCMemory(estimator, program, used, len(spec.commanded), np.zeros(len(known.A)), np.zeros(m), none, none)

    def act(self, memory: MPCMemory, measurement: Array, reference: Reference) -> tuple[MPCMemory, Array]:
        """Solve the program from the plan of the last sample, one step further on."""
        memory = own_memory(memory, MPCMemory)
        estimator, (solver, linear, limits, state, command) = memory.estimator, memory.program
        x = estimator.update(memory.expected, memory.last, measurement)
        base = command @ reference.numbers / limits
        ends = np.tile(base, self.horizon)
        solver.update(q=linear @ (x - state @ reference.numbers), l=-1.0 - ends, u=1.0 - ends)
        solver.warm_start(x=memory.plan, y=memory.dual)
        found = solver.solve(raise_error=False)
        if found.info.status_val not in (1, 2):
            raise InputError(
                f"MPC: expected a program with a solution, got {found.info.status!r}; the state left the range of "
                "numbers, check limits and the model"
            )
        m = len(memory.used)
        u = np.clip(found.x[:m] + base, -1.0, 1.0) * limits
        plan, dual = (np.append(part[m:], part[-m:]) for part in (found.x, found.y))
        result = np.zeros(memory.total)
        result[memory.used] = u
        return memory._replace(expected=estimator.expect(x, u), last=u, plan=plan, dual=dual), result


def _solver(cost: Array) -> Any:
    try:
        import osqp
    except ImportError as error:
        raise MissingExtraError(
            "MPC: expected the package osqp, which is not installed; pip install 'tautflex[control]'"
        ) from error
    solver, n = osqp.OSQP(), len(cost)
    # A step size that is chosen by the clock would make two runs differ.
    settings = {"eps_abs": _ACCURACY, "eps_rel": _ACCURACY, "max_iter": 20_000, "adaptive_rho_interval": 50}
    solver.setup(
        csc_matrix(np.triu(cost)),
        np.zeros(n),
        csc_matrix(np.eye(n)),
        -np.ones(n),
        np.ones(n),
        verbose=False,
        **settings,
    )
    return solver
