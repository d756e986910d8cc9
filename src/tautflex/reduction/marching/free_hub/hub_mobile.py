"""Mass that coordinates move on a free hub, which recoils, and how stiff they are there; compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.numeric import Array, jit
from tautflex.reduction.marching.dispatch import tangent
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import add_slopes, place_hub, shared_rates
from tautflex.reduction.marching.free_hub.hub_work import HubWork, set_inputs
from tautflex.reduction.marching.steps import STABLE_SHARE
from tautflex.reduction.marching.work import Work
from tautflex.reduction.polynomial.forces import add_times, dot
from tautflex.solvers.transient.free_hub.balance import cholesky, solve
from tautflex.solvers.transient.free_hub.momentum import held_apart


@jit
def solve_mass(hub: HubArrays, inverse: Array, ride: HubWork) -> None:
    """Fill ``solved`` for an inverse of the coordinates' mass."""
    for k in range(6):
        if hub.freedom[k] != 0.0:
            ride.solved[k].fill(0.0)
            add_times(1.0, inverse, ride.at.coupling[k], ride.solved[k])


@jit
def mobile_square(hub: HubArrays, ride: HubWork, v: Array) -> float:
    """What a free hub takes from ``v' M v`` at the last place, ``(G v)' R^-1 G v``."""
    if hub.turns.size == 1:
        row = 3 + hub.turns[0]
        return dot(ride.at.coupling[row], v) ** 2 / ride.at.mass[row, row]
    relative = np.empty(6)
    for k in range(6):
        relative[k] = hub.freedom[k] * dot(ride.at.coupling[k], v)
    return dot(relative, solve(cholesky(held_apart(ride.at.mass, hub.freedom)), relative))


@jit
def mobile_inverse(hub: HubArrays, ride: HubWork) -> Array:
    """Inverse of the coordinates' mass on their hub at the last place, shape (r, r)."""
    solve_mass(hub, ride.inverse, ride)
    r, at, inverse, right = ride.inverse.shape[0], ride.at, ride.inverse.copy(), np.zeros(6)
    for j in range(r):
        for k in range(6):
            right[k] = hub.freedom[k] * ride.solved[k, j]
        if hub.turns.size == 1:
            axis = 3 + hub.turns[0]
            right[axis] /= at.mass[axis, axis] - dot(at.coupling[axis], ride.solved[axis])
        else:
            right = shared_rates(hub, at, ride.solved, right)
        for k in range(6):
            if right[k] != 0.0:
                for i in range(r):
                    inverse[i, j] += ride.solved[k, i] * right[k]
    return inverse


@jit
def carried_mass(hub: HubArrays, ride: HubWork) -> Array:
    """What a free hub takes from the coordinates' mass at the last place, ``G' R^-1 G``, shape (r, r)."""
    r, lower = ride.load.shape[1], cholesky(held_apart(ride.at.mass, hub.freedom))
    result, column = np.zeros((r, r)), np.empty(6)
    for j in range(r):
        for k in range(6):
            column[k] = hub.freedom[k] * ride.at.coupling[k, j]
        moved = solve(lower, column)
        for i in range(r):
            for k in range(6):
                result[i, j] += hub.freedom[k] * ride.at.coupling[k, i] * moved[k]
    return result


@jit
def stiffest(arrays: Any, hub: HubArrays, inputs: HubInputs, row: int, work: Work, ride: HubWork) -> float:
    """Largest squared angular frequency of the coordinates on their hub at the present state [1/s^2]."""
    set_inputs(arrays, inputs, row, work.q, ride)
    place_hub(hub, arrays, work.q, ride.at)
    matrix = tangent(arrays, work.q, ride.given)
    solve_mass(hub, ride.inverse, ride)
    lower = np.linalg.cholesky(arrays.mass - carried_mass(hub, ride))
    half = np.linalg.solve(lower, matrix)
    return np.linalg.eigvalsh(np.linalg.solve(lower, half.T))[-1]


@jit
def stable(arrays: Any, hub: HubArrays, inputs: HubInputs, row: int, size: float, work: Work, ride: HubWork) -> bool:
    """Whether central differences follow the stiffness, and the lagged damping, at the present state.

    Most often a bound of all frequencies is enough, the norm of stiffness times inverse mass.
    """
    lagged, slope = 0.0, ride.space[0]
    for n in range(arrays.viscous.shape[0]):
        slope.fill(0.0)
        add_slopes(arrays.first, arrays.second, arrays.viscous[n], work.q, slope)
        lagged += dot(slope, slope)
    limit = STABLE_SHARE * 4.0 / (size * size)
    set_inputs(arrays, inputs, row, work.q, ride)
    place_hub(hub, arrays, work.q, ride.at)
    matrix, inverse = tangent(arrays, work.q, ride.given), mobile_inverse(hub, ride)
    square = 0.0
    for i in range(work.q.size):
        for j in range(work.q.size):
            square += dot(matrix[i], inverse[j]) ** 2
    fast = square > limit * limit and stiffest(arrays, hub, inputs, row, work, ride) > limit
    return not fast and size * lagged <= STABLE_SHARE
