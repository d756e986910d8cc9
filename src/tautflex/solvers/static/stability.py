"""Whether small motion about a state grows: pivots of ``K + K_T``, then the growth rate [theory.md 3, 4, 13]."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.mechanics.dampings.damping import Damping
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array
from tautflex.solvers.linear.eigenpairs import lowest_eigenpairs
from tautflex.solvers.linear.quadratic import QuadraticPencil, fastest_growing
from tautflex.solvers.plausibility import point_text
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.pivots import find_fall
from tautflex.solvers.static.prestress import PrestressedState

# Off the growth rate without damping and spin, which would make the shifted matrix singular.
_BEYOND = 1.3


class Instability(NamedTuple):
    """The motion that grows fastest: rate [1/s], shape (size,) with a largest translation of 1, and it all in words."""

    rate: float
    shape: Array
    text: str


def find_instability(
    state: PrestressedState, q: Array, motion: RigidMotion, coupling: Coupling, damping: Damping
) -> Instability | None:
    """Fastest growing small motion about an equilibrium in steady motion; None if none grows.

    Parameters
    ----------
    state
        Prestressed state.
    q
        Free unknowns of the equilibrium [m, rad], shape (size,).
    motion, coupling
        Steady motion of the frame, and which of its terms count.
    damping
        That of the state at rest.

    Notes
    -----
    The pivots of ``K_tan(q) + K_T`` tell whether the potential has directions in which it falls (`find_fall`). Only
    then eigenvalues of ``l^2 M + l (C + G) + K_tan + K_T`` are sought: the Coriolis force may hold what the potential
    does not.
    """
    stiffness = stiffness_about(state, q, motion, coupling)
    pattern, mass = state.system.pattern, state.system.inertia.mass_entries
    # At rest the state itself knows.
    fall = find_fall(state.system, stiffness, q, state.unstable_modes if stiffness is state.tangent_entries else None)
    if fall is None:
        return None
    rate, vector = float(np.sqrt(-fall.eigenvalue)), fall.vector
    inertia, matrix = state.system.inertia, damping.of(state.linear)
    gyroscopic, proportional = (
        inertia.entries(coupling.velocity_weight(motion)),
        matrix.proportional(mass, state.tangent_entries),
    )
    if gyroscopic.any() or proportional.any() or matrix.rank:
        pencil = QuadraticPencil(pattern, mass, proportional, gyroscopic, stiffness, matrix)
        eigenvalue, grown = fastest_growing(pencil, _BEYOND * rate)
        if eigenvalue.real <= 1e-6 * rate:
            return None
        rate, vector = float(eigenvalue.real), grown.real if np.abs(grown.real).max() > 0.0 else grown.imag
    vector = scaled(state, vector)
    return Instability(rate, vector, growth_text(state, fall.directions, rate, vector, motion))


def growth_text(state: PrestressedState, count: int, rate: float, shape: Array, motion: RigidMotion) -> str:
    """Sentence about motions that grow, the fastest at a rate [1/s] in a shape of (size,)."""
    node = int(np.argmax(np.linalg.norm(state.system.translations(shape), axis=1)))
    spin = float(np.linalg.norm(motion.angular_velocity))
    cause = (
        f"the tension does not hold a spin of {spin:.3g} rad/s: spin more slowly or"
        if spin
        else "its prestress pushes:"
    )
    return (
        f"the starting state is unstable: {count} motion(s) grow out of it, the fastest at {rate:.3g} 1/s, most at "
        f"node {node} {point_text(state.model.nodes[node])}; {cause} raise the tension, or set initial_imperfection "
        "to follow the motion"
    )


class Start(NamedTuple):
    """Free unknowns [m, rad] of a starting equilibrium and of its imperfection, shapes (size,), and warnings."""

    equilibrium: Array
    offset: Array
    warnings: list[str]


def find_start(
    state: PrestressedState, motion: RigidMotion, coupling: Coupling, damping: Damping, imperfection: float = 0.0
) -> Start:
    """Equilibrium in steady motion, whether it is stable, and a largest displacement [m] from it.

    The imperfection has the shape that grows fastest, or in which the potential of a stable state rises least.
    """
    q = spinning_equilibrium(state, motion, coupling)
    unstable, offset = find_instability(state, q, motion, coupling, damping), np.zeros(len(q))
    if imperfection:
        pattern, mass = state.system.pattern, state.system.inertia.mass_entries
        softest = lowest_eigenpairs(pattern, stiffness_about(state, q, motion, coupling), mass, 1)[1][0]
        offset = imperfection * (unstable.shape if unstable else scaled(state, softest))
    return Start(q, offset, [unstable.text] if unstable else [])


def stiffness_about(state: PrestressedState, q: Array, motion: RigidMotion, coupling: Coupling) -> Array:
    """Values of ``K_tan(q) + K_T`` of a steady motion in the pattern, shape (entries,)."""
    tangent = state.system.tangent(q) if q.any() else state.tangent_entries
    weight = coupling.displacement_weight(motion)
    return tangent + state.system.inertia.entries(weight) if weight.any() else tangent


def scaled(state: PrestressedState, vector: Array) -> Array:
    """A vector whose largest translation is 1 and positive, shape (size,)."""
    largest = largest_translation(state, vector)
    return vector / largest if largest else vector


def largest_translation(state: PrestressedState, vector: Array) -> float:
    """The translation of largest size, with its sign."""
    moved = state.system.translations(vector).ravel()
    return float(moved[np.abs(moved).argmax()])
